"""Experiments of blind trials: excitations, noise and disturbances drawn at random, other than the paper's.

The other axes are held exactly: a hull held by its thrusters pitches a little with every push, which moves its range
by 0.4 mm (root mean square, the paper's runs). That is a gap of its own, seen where the sonar's noise is below 3 mm,
and no case without a gap may have one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...experiment import Excitation, Scenario, Sonar, Tachometer, Turbulence
from ...plant import Truth
from .cause import RUNS, log_uniform

DURATION_S, PERIOD_S = 120.0, 0.1
DEPTH_M = 0.9144  # [m] 3 ft, the paper's
BAND_RAD_S = (0.15, 1.5)  # of the single sinusoids; the paper's lie from 0.2 to 1 rad/s
PAPER_RAD_S = (0.5, 0.2, 1.0)  # of data sets 1 to 3, kept clear of by 3 %
LARGEST_M = 0.42  # [m] amplitude; the paper's is 0.46 m
TOP_REV_S = (10.0, 17.0)  # [rev/s] propeller speed that the amplitudes are chosen for
UNSEEN = ("multisine", "chirp", "step_coast", "square", "speed_sine")
UNSEEN_SHARE, COLOURED_SHARE, STILL_SHARE, WHITE_SHARE = 0.25, 0.25, 0.4, 0.3  # of the cases; choices
NOISE_M, TACHOMETER_REV_S = (0.002, 0.015), (0.01, 0.08)
TURBULENCE_M_S2, TURBULENCE_S, SONAR_MEMORY_S = (4e-4, 4e-3), (0.5, 6.0), (0.15, 1.5)
WHITE_S = 0.02  # [s] correlation time below the tick: a fresh acceleration at every tick
BASE = Scenario(
    name="trial", path=Path("trial"), description="", truth="", duration_s=DURATION_S, period_s=PERIOD_S,
    standoff_m=2.7, depth_m=DEPTH_M, n_limit_rev_s=None, hold="rigid", seed=0,
    excitation=Excitation("speed_sine", "speed", (0.0,), (1.0,)),
)  # fmt: skip


@dataclass(frozen=True)
class Experiment:
    """The runs of one case, the held-out ones last.

    Attributes:
        family: kind of excitation of the given runs.
        scenarios: RUNS + HOLDOUTS of them; the held-out ones repeat the given ones with noise of their own, and the
            last is of another family.
        sonar_memory_s: correlation time of the sonar's noise, 0 for white [s].
    """

    family: str
    scenarios: tuple[Scenario, ...]
    sonar_memory_s: float

    @property
    def turbulence(self) -> str:
        """One of still, white, coloured."""
        turbulence = self.scenarios[0].turbulence
        if turbulence.acceleration_m_s2 == 0.0:
            return "still"
        return "white" if turbulence.time_s == WHITE_S else "coloured"


def draw_experiment(random: np.random.Generator, truth: Truth, familiar: bool) -> Experiment:
    """An experiment for a hull of that truth; familiar: closed-loop sinusoids and white sonar noise only."""
    unseen = bool(random.random() < UNSEEN_SHARE) and not familiar
    family = str(random.choice(UNSEEN)) if unseen else "position_sine"
    others = [name for name in ("position_sine", *UNSEEN) if name != family]
    families = [family] * RUNS + [str(random.choice(others))]
    top = random.uniform(*TOP_REV_S)
    bands = _bands(random, len(families))
    sonar = _sonar(random)
    tachometer = Tachometer(log_uniform(random, *TACHOMETER_REV_S), float(random.choice([0.0, 1.0])))
    coloured = bool(random.random() < COLOURED_SHARE) and not familiar
    memory = log_uniform(random, *SONAR_MEMORY_S) if coloured else 0.0
    turbulence, same_place = _turbulence(random), random.random() < 0.5
    common = replace(BASE, sonar=sonar, tachometer=tachometer, turbulence=turbulence)
    standoff = random.uniform(2.2, 3.2)
    scenarios = []
    for k, (name, rad_s) in enumerate(zip(families, bands, strict=True), 1):
        standoff = standoff if same_place else random.uniform(2.2, 3.2)
        excitation = _excitation(name, rad_s, top, random, truth)
        scenarios.append(replace(common, name=f"run_{k}", standoff_m=standoff, excitation=excitation))
    return Experiment(family, (*scenarios[:RUNS], *scenarios), memory)


def amplitude_m(rad_s: float, top_rev_s: float, truth: Truth) -> float:
    """Amplitude of a sinusoid [m] whose peak inertia and drag together take the thrust at top_rev_s, at most LARGEST_M.

    beta n^2 = ((A w^2)^2 + (alpha A^2 w^2)^2)^(1/2), since the two peak a quarter of a period apart.
    """
    square = (truth.beta_m_per_rev2 * top_rev_s**2 / rad_s**2) ** 2
    b = 0.5 / truth.alpha_per_m**2
    return min(math.sqrt(math.sqrt(b * b + square / truth.alpha_per_m**2) - b), LARGEST_M)


def _bands(random: np.random.Generator, count: int) -> list[float]:
    """Frequencies, one in each of `count` equal parts of the band on a log scale, clear of the paper's, shuffled."""
    edges = np.geomspace(*BAND_RAD_S, count + 1)
    drawn = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        rad_s = log_uniform(random, low, high)
        while min(abs(rad_s / paper - 1.0) for paper in PAPER_RAD_S) < 0.03:
            rad_s = log_uniform(random, low, high)
        drawn.append(rad_s)
    return [float(rad_s) for rad_s in random.permutation(drawn)]


def _sonar(random: np.random.Generator) -> Sonar:
    dropout = random.uniform(0.0, 0.08) if random.random() < 0.4 else 0.0
    resolution = float(random.choice([0.0, 0.002, 0.005, 0.01]))
    return Sonar(noise_m=log_uniform(random, *NOISE_M), resolution_m=resolution, dropout=dropout)


def _turbulence(random: np.random.Generator) -> Turbulence:
    draw, level, time_s = random.random(), log_uniform(random, *TURBULENCE_M_S2), log_uniform(random, *TURBULENCE_S)
    if draw < STILL_SHARE:
        return Turbulence()
    white = draw < STILL_SHARE + WHITE_SHARE
    return Turbulence(3.0 * level if white else level, WHITE_S if white else time_s)


def _excitation(name: str, rad_s: float, top: float, random: np.random.Generator, truth: Truth) -> Excitation:
    share, phase, ramp = random.uniform(0.55, 1.0), random.uniform(-np.pi, np.pi), random.uniform(3.0, 8.0)
    if name == "multisine":
        several = tuple(float(w) for w in np.geomspace(0.7 * rad_s, 2.0 * rad_s, int(random.integers(3, 6))))
        sizes = tuple(0.6 * share * amplitude_m(w, top, truth) / len(several) ** 0.5 for w in several)
        return Excitation(name, "position", sizes, several, ramp_s=ramp)
    if name == "chirp":
        ends = tuple(random.permutation([0.6 * rad_s, 1.6 * rad_s]).tolist())
        return Excitation(name, "position", (share * amplitude_m(max(ends), top, truth),), ends, 0.0, ramp, phase)
    if name == "step_coast":
        push = random.uniform(2.0, 5.0)
        return Excitation(name, "speed", (share * 0.75 * top,), push_s=push, coast_s=random.uniform(4.0, 12.0))
    if name == "square":
        slow = 0.1 + 0.3 * rad_s
        return Excitation(name, "position", (0.5 * share * LARGEST_M,), (slow,), phase_rad=phase)
    if name == "speed_sine":
        quick = max(rad_s, 0.35)
        return Excitation(name, "speed", (share * top,), (quick,), phase_rad=0.5 * math.pi)
    return Excitation(name, "position", (share * amplitude_m(rad_s, top, truth),), (rad_s,), 0.0, ramp, phase)
