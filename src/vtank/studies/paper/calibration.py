"""Estimated against true drag: which true drag a published value stands for.

The truth's drag is varied from a tenth of Brutzman's to many times it, everything else staying as in a preset. For
each data set that gives the estimator's median and its 10-90 % band over the true drag. Read backwards, a published
value corresponds to the true drag at which the median passes through it, and is compatible with every true drag whose
band holds it (a confidence belt after Neyman).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...estimate.paper import Array
from ...plant import load_truth
from ...units import FOOT_M
from .published import SETS, brutzman_a_per_ft
from .records import records
from .study import FAST, QUANTITIES, Level, estimate_all, quantiles

MULTIPLES = (0.3, 1.0, 3.0, 6.0, 10.0, 15.0, 22.0, 30.0, 45.0, 65.0)  # true drag over Brutzman's
BASES = ("physical", "paper-ii")
ESTIMATORS = ("kalman", "two_stage", "least_squares")


@dataclass(frozen=True)
class Calibration:
    """Quantiles of a [1/ft] over true drag: (base, method) -> shape (multiples, data sets, 3)."""

    multiples: Array
    bands: dict[tuple[str, str], Array]

    def implied(self, base: str, method: str, data_set: int, a_per_ft: float) -> tuple[float, float, float]:
        """True drag over Brutzman's for a published a: lowest compatible, at the median, highest compatible.

        NaN where no true drag of the range does it; at an end of the range the interval may go on beyond it.
        """
        low, middle, high = self.bands[base, method][:, data_set].T
        fine = np.geomspace(self.multiples[0], self.multiples[-1], 400)
        a = [np.interp(fine, self.multiples, curve) for curve in (low, middle, high)]
        inside = fine[(a[0] <= a_per_ft) & (a_per_ft <= a[2])]
        crossing = np.flatnonzero(np.diff(np.sign(a[1] - a_per_ft)) != 0)
        centre = float(fine[crossing[0]]) if crossing.size else np.nan
        return (float(inside[0]), centre, float(inside[-1])) if inside.size else (np.nan, centre, np.nan)


def calibrate(
    seed: int,
    seeds: int,
    advance: Callable[[str], None] = lambda note: None,
    multiples: Sequence[float] = MULTIPLES,
    bases: Sequence[str] = BASES,
) -> Calibration:
    """Simulate and estimate at every true drag; `advance` is called once for each base and multiple."""
    bands = {(base, method): np.empty((len(multiples), SETS, 3)) for base in bases for method in ESTIMATORS}
    for base in bases:
        for i, multiple in enumerate(multiples):
            alpha = multiple * brutzman_a_per_ft() / FOOT_M
            truth = replace(load_truth(base), alpha_per_m=alpha, name=f"{base}, drag x {multiple:g}")
            flown = records(truth, seeds, seed)
            for method in ESTIMATORS:
                found = estimate_all(flown, Level("method", method, method, FAST[method]))
                a = found[..., QUANTITIES.index("a")]
                bands[base, method][i] = [quantiles(a[:, data_set]) for data_set in range(SETS)]
            advance(f"{base}, {multiple:g} times Brutzman's drag")
    return Calibration(np.array(multiples, dtype=float), bands)
