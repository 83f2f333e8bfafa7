"""Echoes from beyond the wall (multipath): of a sonar's stray ranges, whether they are late rather than early."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...effects import BY_NAME
from ...record.columns import channel_of
from ...rigid.filtered import Filtered
from ...rigid.fit import Fit
from ...rigid.places import Placed
from ...rigid.recorded import Recorded
from ..outliers import multipath

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Echoes:
    """Echoes that a sonar hears.

    placed: the effect, with the values found. gain: of log evidence, by being late rather than early. runs: without
    the ranges that came by the longer way, which would pull at everything else that is sought; before: with them.
    """

    placed: Placed
    gain: float
    runs: tuple[Recorded, ...]
    before: tuple[Recorded, ...]


def heard(runs: Sequence[Recorded], found: Sequence[Filtered], candidates: Sequence[Placed]) -> Echoes | None:
    """The clearest echoes; None where no sonar hears any. found: filters along the runs.

    The effect of a range that moves no simulation is that of echoes.
    """
    best = None
    layout = runs[0].layout
    for placed in (placed for placed in candidates if not any(number.slots for number in placed.parameters)):
        for c, column in enumerate(layout.columns):
            if channel_of(column) == "range_m" and layout.vehicle.instrument(column) == placed.place:
                e = np.concatenate([f.innovation[run.column == c] for run, f in zip(runs, found, strict=True)])
                gain, p, extra_m = multipath(BY_NAME[placed.effect], e)
                if gain > (best.gain if best else 0.0):
                    numbers = [replace(q, starts=(v,)) for q, v in zip(placed.parameters, (p, extra_m), strict=True)]
                    late = [(run.column == c) & (f.innovation > 0.5 * extra_m)
                            for run, f in zip(runs, found, strict=True)]  # fmt: skip
                    kept = tuple(run.keeping(~stray) for run, stray in zip(runs, late, strict=True))
                    best = Echoes(replace(placed, parameters=tuple(numbers)), gain, kept, tuple(runs))
    return best


def still_heard(echoes: Echoes, fit: Fit, p: Array, candidates: Sequence[Placed]) -> Echoes | None:
    """The echoes that all ranges tell of beside what was found since, at p; a cause that was lacking may feign some."""
    runs = tuple(replace(full, wall=run.wall) for full, run in zip(echoes.before, fit.runs, strict=True))
    runs = tuple(run.ordered(p) for run in runs)
    again = heard(runs, replace(fit, runs=runs).filter(p), candidates)
    return again if again and again.placed.name == echoes.placed.name else None
