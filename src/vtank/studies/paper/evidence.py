"""What findings are made of: results, claims with verdicts, and the arithmetic and the wording of their numbers."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...estimate.paper import Array
from ...present import Paragraph, fixed
from .calibration import Calibration
from .campaign import Campaign
from .practice import Practice
from .published import SETS, published
from .study import QUANTITIES, Study

HOLDS, PARTLY, FAILS = "supported", "partly supported", "not supported"
WITHIN = 2.0  # factor within which an estimate counts as reproducing a printed value; a convention
LOW_DRAG, HIGH_DRAG = "physical", "paper-ii"
NAMES = {"kalman": "Kalman, q_ii = 1", "two_stage": "two-stage, printed q_ii", "least_squares": "least squares"}


@dataclass(frozen=True)
class Finding:
    """A claim, whether the simulations support it, and the numbers."""

    claim: str
    verdict: str
    text: str

    @property
    def block(self) -> Paragraph:
        """As a paragraph."""
        return Paragraph(self.text, f"{self.claim} — {self.verdict}.")


def told(name: str, verdict: str, /, **values: object) -> Finding:
    """The finding of that name in findings.toml, with the verdict and the values in their places."""
    return Finding(sentences()[name]["claim"], verdict, filled(name, **values))


def filled(name: str, /, **values: object) -> str:
    """The text of that name in findings.toml on one line, with the values in their places."""
    always = {"low": LOW_DRAG, "high": HIGH_DRAG, "within": WITHIN, "sets": SETS}
    return " ".join(sentences()[name]["text"].format(**always | values).split())


@cache
def sentences() -> dict[str, dict[str, str]]:
    """Claims and texts of findings.toml by name."""
    return tomllib.loads(Path(__file__).with_name("findings.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Results:
    """Everything the findings draw on; campaigns may be of some truths only."""

    study: Study
    calibration: Calibration
    practice: Practice
    campaigns: dict[str, Campaign]


def median(s: Study, truth: str, factor: str, label: str, method: str, quantity: str) -> float:
    """Median over seeds and data sets at one level."""
    return float(s.band(truth, s.level(factor, label, method), quantity)[1])


def within(values: Array, printed: Array) -> float:
    """Share of estimates, shape (seeds, sets), that have the print's sign and lie within a factor WITHIN of it."""
    return float(np.mean(_near(values, printed)))


def _near(values: Array, printed: Array) -> NDArray[np.bool_]:
    ratio = values / printed
    return (ratio >= 1.0 / WITHIN) & (ratio <= WITHIN)


def reproduced(estimates: Array, printed: dict[str, Array]) -> tuple[float, float]:
    """Shares of runs, and of seeds in all data sets, with every quantity within a factor WITHIN of the print.

    estimates: shape (seeds, sets, QUANTITIES).
    """
    good = np.all([_near(estimates[..., QUANTITIES.index(q)], target) for q, target in printed.items()], axis=0)
    return float(np.mean(good)), float(np.mean(good.all(axis=1)))


def positive_within(values: Array, factor: float) -> bool:
    """Whether all values are positive and within a factor of each other."""
    return bool(values.min() > 0.0 and values.max() <= factor * values.min())


def apart(s: Study, method: str) -> float:
    """Probability that a run of the high-drag vehicle shows more drag than one of the other, mean over data sets."""
    low, high = (s.of(t, "method", method, method)[..., 0] for t in (LOW_DRAG, HIGH_DRAG))
    return float(np.mean([np.mean(high[:, None, d] < low[None, :, d]) for d in range(SETS)]))


def implied_medians(c: Calibration, method: str, base: str) -> Array:
    """True drag over Brutzman's at the median for Table 2's values, those that have one."""
    found = [c.implied(base, method, d, a)[1] for d, a in enumerate(published()[2].values["a"].tolist())]
    return np.array([x for x in found if np.isfinite(x)])


def compatible(c: Calibration, method: str, base: str) -> str:
    """True drags over Brutzman's that are compatible with every value of Table 2, each by itself, as text."""
    ends = np.array([c.implied(base, method, d, a) for d, a in enumerate(published()[2].values["a"].tolist())])
    low, high, tried = float(np.max(ends[:, 0])), float(np.min(ends[:, 2])), c.multiples
    if not low <= high:
        return f"compatible with no one true drag of {tried[0]:g} to {tried[-1]:g} times Brutzman's"
    everything = low <= 1.05 * tried[0] and high >= 0.95 * tried[-1]
    worth = "all that were tried: they say nothing about it" if everything else f"{tried[0]:g} to {tried[-1]:g} tried"
    return f"compatible with true drags from {low:.2g} to {high:.2g} times Brutzman's ({worth})"


def span(values: Sequence[float] | Array, digits: int) -> str:
    """Smallest to largest magnitude, or "none"."""
    ordered = sorted(np.asarray(values, dtype=float).tolist(), key=abs)
    return f"{ordered[0]:.{digits}f} to {ordered[-1]:.{digits}f}" if ordered else "none of the tried multiples of"


def band(values: Array, digits: int) -> str:
    """Median and band as text."""
    low, middle, high = (fixed(x, digits, "diverges") for x in values)
    return f"{middle} [{low}, {high}]"


def interval(low: float, middle: float, high: float) -> str:
    """Median and compatible interval as text."""
    return f"{fixed(middle, 1)} [{f'{low:.1f}, {high:.1f}' if np.isfinite(low) else '-'}]"


def numbers(values: Sequence[float]) -> str:
    """Two decimals each; "diverges" for infinity."""
    return ", ".join(fixed(x, 2, "diverges") for x in values)


def percent(share: float) -> str:
    """A share in percent."""
    return f"{100.0 * share:.0f} %"


def steady_speed(a: float, b: float, gamma: float, n_rev_s: float) -> float:
    """Speed ahead at which a u^2 + gamma n u + b n^2 = 0 [ft/s], for parameters in feet and n ahead."""
    return float(np.max(np.roots([a, gamma * n_rev_s, b * n_rev_s**2]).real))


def pure_noise(deviation_ft_s: float, step_s: float) -> tuple[float, float]:
    """a [1/ft] and tau [s] that Model II's regression gives to white Gaussian noise in u without any motion.

    With u = e, z is predicted by e0 - 2 e1 = 3/2 (e0 - e1) - (e0 + e1)/2. The first part, odd under exchange of e0 and
    e1, is 3/2 of h2; the even one has only f0 + f1, f = e|e|, to be regressed on, with coefficient
    -E(e f)/(2 E(f f)) = -sqrt(2/pi)/(3 s). Hence C1 = T a = -sqrt(2/pi)/(3 s) and C2 = T/tau = 3/2.
    """
    return -math.sqrt(2.0 / math.pi) / (3.0 * deviation_ft_s * step_s), 2.0 * step_s / 3.0
