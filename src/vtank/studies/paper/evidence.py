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
from ...present import Paragraph, fixed, listed
from .campaign import Campaign
from .joint import Joint
from .practice import Practice
from .published import SETS
from .study import STEPS_S, Study

HOLDS, PARTLY, FAILS = "supported", "partly supported", "not supported"
WITHIN = 2.0  # factor within which an estimate counts as reproducing a printed value; a convention
LOW_DRAG, HIGH_DRAG = "physical", "paper-ii"


@dataclass(frozen=True)
class Finding:
    """A claim, whether the simulations support it and at which T, and the numbers."""

    claim: str
    verdict: str
    text: str
    where: str = ""

    @property
    def block(self) -> Paragraph:
        """As a paragraph."""
        return Paragraph(self.text, f"{self.claim} — {self.verdict}{self.where}.")


def told(name: str, held: str | NDArray[np.bool_], /, **values: object) -> Finding:
    """The finding of that name in findings.toml with the values in their places.

    held: the verdict, or whether the claim holds at each of STEPS_S: what holds at some only is supported in part.
    """
    claim, text = sentences()[name]["claim"], filled(name, **values)
    if isinstance(held, str):
        return Finding(claim, held, text)
    if held.all() or not held.any():
        return Finding(claim, HOLDS if held.all() else FAILS, text, " at every T" if held.all() else " at any T")
    places = [f"{step:g}" for step, holds in zip(STEPS_S, held, strict=True) if holds]
    return Finding(claim, PARTLY, text, f": at T = {listed(places)} s")


def filled(name: str, /, **values: object) -> str:
    """The text of that name in findings.toml on one line, with the values in their places."""
    steps = listed([f"{step:g}" for step in STEPS_S])
    always = {"low": LOW_DRAG, "high": HIGH_DRAG, "within": WITHIN, "sets": SETS, "steps": steps}
    return " ".join(sentences()[name]["text"].format(**always | values).split())


@cache
def sentences() -> dict[str, dict[str, str]]:
    """Claims and texts of findings.toml by name."""
    return tomllib.loads(Path(__file__).with_name("findings.toml").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Results:
    """Everything the findings draw on; campaigns may be of some truths only."""

    study: Study
    joint: Joint
    practice: Practice
    campaigns: dict[str, Campaign]


def within(values: Array, printed: Array) -> Array:
    """Share of estimates, shape (steps, seeds, sets), with the print's sign and within a factor WITHIN; (steps,)."""
    ratio = values / printed
    return np.asarray(np.mean((ratio >= 1.0 / WITHIN) & (ratio <= WITHIN), axis=(1, 2)))


def steady(values: Array, factor: float) -> Array:
    """Whether all values of the last axis are positive and within a factor of each other."""
    return np.asarray((values.min(axis=-1) > 0.0) & (values.max(axis=-1) <= factor * values.min(axis=-1)))


def apart(s: Study, method: str) -> Array:
    """Probability that a run of the high-drag vehicle shows more drag than one of the other, at each T, (steps,)."""
    low, high = (s.of(truth, "method", method, method)[..., 0] for truth in (LOW_DRAG, HIGH_DRAG))
    return np.asarray(np.mean(high[:, :, None] < low[:, None], axis=(1, 2, 3)))


def span(values: Sequence[float] | Array, digits: int) -> str:
    """Smallest to largest magnitude, or "none"."""
    ordered = sorted(np.asarray(values, dtype=float).tolist(), key=abs)
    return f"{ordered[0]:.{digits}f} to {ordered[-1]:.{digits}f}" if ordered else "none of the tried multiples of"


def numbers(values: Sequence[float] | Array, digits: int = 2) -> str:
    """Decimals of each, one after another; "diverges" for infinity."""
    return ", ".join(fixed(x, digits, "diverges") for x in np.asarray(values).tolist())


def percents(shares: Sequence[float] | Array) -> str:
    """Shares in percent, one after another."""
    return ", ".join(f"{100.0 * share:.0f}" for share in shares) + " %"


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
