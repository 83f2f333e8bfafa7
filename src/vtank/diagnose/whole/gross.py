"""Gross mistakes: what is turned round, exchanged or in another unit, looked for before anything is fitted.

A simulation that takes metres for feet follows its instruments somewhere else, and own parameters are fitted to that:
from there no small change tells of the mistake. So each is tried as it is, with the vehicle as its file has it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...errors import InputError
from ...rigid.filtered import Noise
from ...rigid.fit import Fit, log_likelihood
from ...rigid.layout import Layout
from ...rigid.noise import cut
from ...rigid.places import Placed
from ...rigid.recorded import Recorded
from .model import blank

CLEARLY = 20.0  # log-likelihood on a part of the recording by which a mistake is worth a fit of its own; a choice


def mistaken(layout: Layout, runs: Sequence[Recorded], noise: Noise, candidates: Sequence[Placed]) -> Placed | None:
    """The mistake of no free number that the recordings are likeliest with, where they are so beyond doubt.

    noise: that recordings begin with, which forgives all but gross mistakes.
    """
    fit = Fit(cut(runs), noise)

    def level(placed: Placed | None) -> float:
        p = blank(fit, layout, (placed,) if placed else (), ()).vector()
        try:
            return sum(log_likelihood(f.innovation, f.variance) for f in fit.filter(p))
        except InputError:
            return -np.inf

    fixed = [c for c in candidates if c.parameters and all(q.slots and q.scale == 0.0 for q in c.parameters)]
    if not fixed:
        return None
    levels = [level(placed) for placed in fixed]
    best = int(np.argmax(np.nan_to_num(levels, nan=-np.inf)))
    return fixed[best] if levels[best] > max(level(None), -1e300) + CLEARLY else None
