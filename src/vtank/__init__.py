"""A virtual tank for underwater vehicles, which explains the gap between a simulator and a recording.

    import vtank as vt

    runs = vt.load("data")                       # or vt.run("paper-ds1", "paper-ds4", seed=1)
    fit = vt.identify(runs, model="II")          # fit.values, fit.sd
    d = vt.diagnose(runs, nominal="paper-ii")    # print(d)
    d.report("gap.html"), d.save("gap.toml")
    vt.predict("gap.toml", runs[0])
    vt.import_log("dive.BIN").write("dive.csv")  # ArduPilot, PX4, ROS, MCAP, any table

Importing vtank loads nothing else; each name loads what it needs when it is first used.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from .facade import facade

__version__ = "0.1.0"

if not {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"} & os.environ.keys():
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: small matrices, where threads only get in each other's way

if TYPE_CHECKING:
    from . import water as water
    from .diagnosed import Diagnosis as Diagnosis
    from .diagnosed import WholeDiagnosis as WholeDiagnosis
    from .effects.effect import Effect as Effect
    from .errors import InputError as InputError
    from .estimate.maximum_likelihood import Estimate as Estimate
    from .library import diagnose as diagnose
    from .library import effects as effects
    from .library import identify as identify
    from .library import load as load
    from .library import predict as predict
    from .library import run as run
    from .logs.importing import import_log as import_log
    from .plant.truth import Truth as Truth
    from .plant.truth import load_truth as load_truth
    from .plant.vehicle import Vehicle as Vehicle
    from .plant.vehicle import load_vehicle as load_vehicle
    from .record.run import Run as Run
    from .viewed import view as view

__all__ = facade(__name__)
