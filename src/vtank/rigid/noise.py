"""The noise of recordings before any of it is sought: white errors of the columns, and the disturbance of each axis.

White errors are what is faster than any hull.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..record.repeats import smallest_step
from .filtered import STILL, Noise
from .fit import Fit
from .recorded import Recorded
from .thinned import scatter

Array = NDArray[np.float64]
FIRST_SIGMA = np.array([0.02, 0.02, 0.02, 0.05, 0.05, 0.02])  # [m/s2, rad/s2] from which the search starts; guesses
FIRST_TIMING = 0.03  # share of the time between rows by which inputs turn early or late, to start from; a guess
LEAST_SIGMA = 1e-5  # [m/s2, rad/s2] below which a disturbance is none
ENOUGH = 6000  # measurements that the noise is sought on first; a choice
SURELY = 4.6  # log-likelihood from which an instrument has a slow error: odds of a hundred
LASTS = 0.5  # of the longest run, over which a disturbance that is remembered stands for a steady force; a choice
KEPT = 0.25  # share of its fastest scatter, as a variance, below which a white error is not believed; a choice


def first_noise(runs: Sequence[Recorded]) -> Noise:
    """White errors from what is faster than any hull, and disturbances to start from."""
    columns = runs[0].layout.columns
    found = [
        np.median([scatter(run.value[run.column == c]) for run in runs if (run.column == c).any()])
        for c in range(len(columns))
    ]
    variance = np.maximum(np.array(found) ** 2, rounding(runs))
    return Noise(variance, np.where(_disturbed(runs), FIRST_SIGMA, 0.0), timing=FIRST_TIMING).even


def against(fit: Fit) -> float:
    """Log odds, beforehand, against a noise's slow errors, disturbances that are steady forces, and runs' phases.

    What lasts over most of every run is no more turbulence than an instrument's bias is its noise.
    """
    noise, lasts_s = fit.noise, LASTS * max(float(np.ptp(run.time_s)) for run in fit.runs)
    steady = (noise.sigma > STILL) & (noise.memory_s > lasts_s)
    phases = [run.phase_s / run.usual_s for run in fit.runs if run.tick_s]
    beyond = np.count_nonzero(noise.slow) + np.count_nonzero(steady)
    return SURELY * float(beyond) + 0.5 * float(np.sum(np.square(phases)))


def _disturbed(runs: Sequence[Recorded]) -> NDArray[np.bool_]:
    """Axes that are disturbed in some run, (6,)."""
    return np.any([run.disturbed for run in runs], axis=0)


def rounding(runs: Sequence[Recorded]) -> Array:
    """Variance of rounding to the smallest step that each column takes, a twelfth of its square, (C,)."""
    return np.array([resolution(runs, c) ** 2 / 12.0 for c in range(len(runs[0].layout.columns))])


def resolution(runs: Sequence[Recorded], c: int) -> float:
    """Smallest step that a column's values take [its unit]."""
    return smallest_step(np.concatenate([run.value[run.column == c] for run in runs]))


def cut(runs: Sequence[Recorded], enough: int = ENOUGH) -> tuple[Recorded, ...]:
    """Enough of the recordings, in measurements: runs from the first on, the last of them cut short."""
    found: list[Recorded] = []
    for run in runs:
        left = enough - sum(other.time_s.size for other in found)
        if left < enough // 4 and found:
            break
        found.append(run.until(run.time_s[min(left, run.time_s.size) - 1]))
    return tuple(found)
