"""Gross mistakes: what is turned round, exchanged, in another unit or late, looked for before anything is fitted.

A simulation that takes metres for feet follows its instruments somewhere else, and own parameters are fitted to that:
from there no small change tells of the mistake. So each is tried as it is, with the vehicle as its file has it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...errors import InputError
from ...rigid.filtered import Noise
from ...rigid.fit import Fit, partial_likelihood
from ...rigid.layout import Layout
from ...rigid.noise import cut
from ...rigid.places import Placed
from ...rigid.recorded import Recorded
from .model import blank

CLEARLY = 20.0  # log-likelihood on a part of the recording by which a mistake is worth a fit of its own; a choice


def mistaken(layout: Layout, runs: Sequence[Recorded], noise: Noise, candidates: Sequence[Placed]) -> Placed | None:
    """The mistake that the recordings are likeliest with, where they are so beyond doubt, to be fitted from there.

    Of those without a free number, and of those with one that has gross values. noise: that recordings begin with,
    which forgives all but gross mistakes.
    """
    fit = Fit(cut(runs), noise)

    def level(placed: Placed | None) -> float:
        p = blank(fit, layout, (placed,) if placed else (), ()).vector()
        there = replace(fit, runs=tuple(run.ordered(p) for run in fit.runs))
        try:
            found = sum(map(partial_likelihood, there.filter(p)))
        except InputError:
            return -np.inf
        return found if np.isfinite(found) else -np.inf

    fixed = [c for c in candidates if c.parameters and all(q.slots and q.scale == 0.0 for q in c.parameters)]
    gross = [c for c in candidates if any(q.far for q in c.parameters)]
    if not fixed and not gross:
        return None
    right = level(None)
    tried = [(level(placed), placed) for placed in fixed]
    for placed in gross:
        before, (number,) = right, placed.parameters
        for value in number.far:  # for as long as it gets better
            there = replace(placed, parameters=(replace(number, starts=(value,)),))
            now = level(there)
            if now < before:
                break
            tried.append((now, there))
            before = now
    if not tried:
        return None
    most, mistake = max(tried, key=lambda pair: pair[0])
    return mistake if most > max(right, -1e300) + CLEARLY else None
