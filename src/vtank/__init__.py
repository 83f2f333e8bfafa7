"""A virtual tank for identifying the surge dynamics of an underwater vehicle.

    import vtank as vt

    runs = vt.load("data")                       # or vt.run("paper-ds1", "paper-ds4", seed=1)
    fit = vt.identify(runs, model="II")          # fit.values, fit.sd
    d = vt.diagnose(runs, nominal="paper-ii")    # print(d), d.report("gap.html"), d.save("gap.toml")
    vt.predict("gap.toml", runs[0])

Importing vtank loads nothing else; each name loads what it needs when it is first used.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from .errors import InputError
from .facade import facade

__version__ = "0.1.0"

if not {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"} & os.environ.keys():
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: small matrices, where threads only get in each other's way

if TYPE_CHECKING:
    from .diagnosed import Diagnosis
    from .effects.effect import Effect
    from .estimate.maximum_likelihood import Estimate
    from .library import diagnose, effects, identify, load, predict, run
    from .plant.truth import Truth, load_truth
    from .plant.vehicle import Vehicle, load_vehicle
    from .record.run import Run

__all__ = ["InputError"]
__all__ += facade(
    __name__,
    {
        "library": ("load", "run", "identify", "diagnose", "predict", "effects"),
        "diagnosed": ("Diagnosis",),
        "record.run": ("Run",),
        "estimate.maximum_likelihood": ("Estimate",),
        "effects.effect": ("Effect",),
        "plant.truth": ("Truth", "load_truth"),
        "plant.vehicle": ("Vehicle", "load_vehicle"),
    },
)
