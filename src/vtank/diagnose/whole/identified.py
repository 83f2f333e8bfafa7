"""Own parameters of a whole vehicle from its recordings: drag and added mass of the axes, thrust, lag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...plant.vehicle import Vehicle
from ...record.run import Run
from ...record.shown import preformatted
from ...rigid.filtered import shaken
from ...rigid.fit import Fit
from ...rigid.layout import AXES
from ...rigid.noise import first_noise
from ...rigid.recordings import record
from ..given import telling
from .model import blank
from .own import own_unknowns
from .plane import in_the_plane
from .settling import flowing, reformed, rightly_begun, settled


@dataclass(frozen=True)
class WholeEstimate:
    """Estimates by parameter and place, `quadratic_drag@yaw`, SI; gain and lag are those of all thrusters.

    Attributes:
        vehicle: whose file gives the priors, 30 % of drag and added mass, 20 % of gain, 50 % of lag.
        nominal, values, sd: the file's numbers, what was found, and its standard deviation.
        disturbance: of each axis [m/s2, rad/s2]. noise: white error of each column, in its unit.
        notes: what is told of columns.
    """

    vehicle: str
    nominal: dict[str, float]
    values: dict[str, float]
    sd: dict[str, float]
    disturbance: dict[str, float]
    noise: dict[str, float]
    notes: tuple[str, ...] = ()

    @property
    def document(self) -> dict[str, Any]:
        """As plain data, schema vtank.identified/1."""
        names = ("vehicle", "nominal", "values", "sd", "disturbance", "noise", "notes")
        return {"schema": "vtank.identified/1", **{name: getattr(self, name) for name in names}}

    def _repr_html_(self) -> str:
        """The table, for a notebook."""
        return preformatted(str(self))

    def __str__(self) -> str:
        """A table."""
        width = max(len(name) for name in self.values)
        head = f"{self.vehicle}, own parameters [SI]\n{'':{width}}  {'file':>10}  {'found':>10}  {'sd':>9}\n"
        return head + "".join(
            f"{name:{width}}  {self.nominal[name]:10.4g}  {value:10.4g}  {self.sd[name]:9.2g}\n"
            for name, value in self.values.items()
        )


def identify(runs: Sequence[Run], vehicle: Vehicle, axes: Sequence[str] | None = None) -> WholeEstimate:
    """Maximum a posteriori estimates from all runs together, with the noise that is likeliest beside them.

    Arguments and errors as of `diagnose`.
    """
    kept, said = telling(runs)
    layout, seen, notes = record(kept, vehicle, axes)
    seen, flat = in_the_plane(layout, seen)
    noise = first_noise(seen)
    own = own_unknowns(layout, seen)
    begun = rightly_begun(*settled(blank(Fit(seen, noise), layout, (), own), noise.variance), noise.variance)
    model, there = flowing(*reformed(*begun, noise.variance), noise.variance)
    nominal = {u.name: float(np.mean(u.base)) for u in own}
    found = model.fit.noise
    return WholeEstimate(
        vehicle=vehicle.name,
        nominal=nominal,
        values={u.name: nominal[u.name] + float(theta) for u, theta in zip(own, model.theta, strict=True)},
        sd={u.name: float(sd) for u, sd in zip(own, model.sd, strict=True)},
        disturbance={axis: float(s) for axis, s in zip(AXES, shaken(found, there), strict=True) if s > 0.0},
        noise={name: float(np.sqrt(v)) for name, v in zip(layout.columns, found.variance, strict=True)},
        notes=notes + flat + said,
    )
