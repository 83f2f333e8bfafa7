"""What was found missing without a name, as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..plant.parameters import LAG, slot
from .freeform import Freeform
from .freeform.pursuit import Component
from .selection import Selection
from .verdict import Verdict


def unnamed(selection: Selection, verdict: Verdict) -> list[dict[str, Any]]:
    """What the verdict's model lacks, the largest gain of evidence first.

    Each has `kind`, `channel`, `about`, whether it is a `force` (else an error of the readings), its `gain` [nats], the
    `windows` in which it shows, its `frequency_rad_s`; and by how much an own parameter differs in every run, `runs`.
    """
    free = next((f for f in selection.free if f.fit is verdict.fit), None)
    components = sorted(free.components if free else (), key=lambda c: -c.gain)
    return [_told(free, component) for component in components if free]


def _told(free: Freeform, c: Component) -> dict[str, Any]:
    names = [run.name for run in free.fit.problem.runs]
    told = {name: getattr(c, name) for name in ("kind", "channel", "about", "force", "gain")}
    windows = [{"run": names[k], "from": start, "to": end} for k, start, end in c.windows]
    size = _size(free, c.about) if c.own else 0.0
    pairs = zip(names, c.coefficients, c.sd, strict=True) if size else ()
    runs = [{"run": name, "change": float(a / size), "sd": float(sd / abs(size))} for name, a, sd in pairs]
    return told | {"windows": windows, "frequency_rad_s": c.frequency, "runs": runs}


def _size(free: Freeform, term: str) -> float:
    """What multiplies an own term in the model itself; thrust is a force as it is, and lag takes its rate off it."""
    p: np.ndarray = free.fit.problem.model(free.fit.optimum.theta + free.shift, 0)[0]
    return {"drag": float(p[slot("alpha")]), "thrust": 1.0, "lag": -float(p[slot(LAG)])}[term]
