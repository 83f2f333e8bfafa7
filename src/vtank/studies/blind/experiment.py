"""Experiments of blind trials: vehicles, excitations, rates, noise and disturbances drawn at random.

The hull is flown as a tank flies it: thrusters hold its other axes, so that it pitches and sways a little with every
push. That moves its range by about 0.4 mm (root mean square, the paper's runs), which counts as noise of known size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...experiment import Excitation, Scenario, Sonar, Tachometer, Turbulence
from ...experiment.scenario import Control
from ...plant import Truth
from .cause import log_uniform
from .noise import Noise, draw_noise
from .vehicles import Craft

DEPTH_M = 0.9144  # [m] 3 ft, the paper's
BAND_RAD_S = (0.15, 1.5)  # of the single sinusoids; the paper's lie from 0.2 to 1 rad/s
LARGEST_M = 0.42  # [m] amplitude; the paper's is 0.46 m
TOP = (0.5, 0.85)  # [-] propeller speed that the amplitudes are chosen for, over the largest there is
UNSEEN = ("multisine", "chirp", "step_coast", "square", "speed_sine")
UNSEEN_SHARE, STILL_SHARE, WHITE_SHARE = 0.4, 0.35, 0.2  # of the cases; choices
NOISE_M, TACHOMETER_REV_S, COARSE_M = (0.002, 0.015), (0.01, 0.08), 0.02
TURBULENCE_M_S2, TURBULENCE_S = (2e-4, 2e-3), (0.5, 12.0)
WHITE = 0.2  # [ticks] correlation time below the tick: a fresh acceleration at every tick
PERIODS_S, FAST_SHARE = (0.1, 0.02), 0.2  # [s] ticks, and the share of the faster
DURATION_S, DURATIONS_S = 120.0, (30.0, 1800.0)  # [s] of half the cases, and what the others are drawn from
GIVEN = (0.1, 0.12, 0.12, 0.36, 0.1, 0.08, 0.06, 0.06)  # shares of 1 to 8 runs; choices
SAMPLES = 24_000  # most in all given runs of a case but the longest
LONG_SHARE = 0.02  # of cases of one run of the longest duration, however fast
HELD_S, REPEATED = 240.0, 2  # longest held-out run [s], and how many repeat given ones
BASE = Scenario(
    name="trial", path=Path("trial"), description="", truth="paper-ii", duration_s=DURATION_S, period_s=0.1,
    standoff_m=2.7, depth_m=DEPTH_M, n_limit_rev_s=None, hold="thrusters", seed=0,
    excitation=Excitation("speed_sine", "speed", (0.0,), (1.0,)),
)  # fmt: skip


@dataclass(frozen=True)
class Experiment:
    """The runs of one case, the held-out ones last.

    Attributes:
        family: kind of excitation of the given runs.
        scenarios: `given` runs, then held-out ones: the first of them repeat given ones with noise of their own, and
            the last is of another family.
        given: number of runs that are given.
        noise: of the sonar.
        top_rev_s: propeller speed that the amplitudes are chosen for.
    """

    family: str
    scenarios: tuple[Scenario, ...]
    given: int
    noise: Noise
    top_rev_s: float

    @property
    def durations_s(self) -> tuple[float, ...]:
        """Of all runs [s]."""
        return tuple(s.duration_s for s in self.scenarios)

    @property
    def turbulence(self) -> str:
        """One of still, white, coloured."""
        s = self.scenarios[0]
        if s.turbulence.acceleration_m_s2 == 0.0:
            return "still"
        return "white" if s.turbulence.time_s <= WHITE * s.period_s else "coloured"


def draw_experiment(random: np.random.Generator, truth: Truth, craft: Craft, familiar: bool) -> Experiment:
    """An experiment for a hull of that truth; familiar: four runs, closed-loop sinusoids and white sonar noise only."""
    given, period_s, duration_s = (4, PERIODS_S[0], DURATION_S) if familiar else _length(random)
    unseen = bool(random.random() < UNSEEN_SHARE) and not familiar
    family = str(random.choice(UNSEEN)) if unseen else "position_sine"
    others = [name for name in ("position_sine", *UNSEEN) if name != family]
    families = [family] * given + [str(random.choice(others))]
    top = random.uniform(*TOP) * truth.n_limit_rev_s
    bands = _bands(random, len(families))
    noise = draw_noise(random, familiar)
    tachometer = Tachometer(log_uniform(random, *TACHOMETER_REV_S), float(random.choice([0.0, 1.0])))
    same_place, standoff = random.random() < 0.5, random.uniform(2.2, 3.2)
    common = replace(
        BASE, sonar=replace(_sonar(random, noise), rate_hz=1.0 / period_s), tachometer=tachometer,
        turbulence=_turbulence(random, period_s), vehicle=craft.vehicle, duration_s=duration_s, period_s=period_s,
        control=Control(thrust_m_per_rev2=truth.beta_m_per_rev2),
    )  # fmt: skip
    scenarios = []
    for k, (name, rad_s) in enumerate(zip(families, bands, strict=True), 1):
        standoff = standoff if same_place else random.uniform(2.2, 3.2)
        sonar = replace(common.sonar, max_range_m=standoff + noise.beyond_m)
        excitation = _excitation(name, rad_s, top, random, truth)
        scenarios.append(replace(common, name=f"run_{k}", standoff_m=standoff, excitation=excitation, sonar=sonar))
    held = [replace(s, duration_s=min(duration_s, HELD_S)) for s in (*scenarios[: min(given, REPEATED)], scenarios[-1])]
    return Experiment(family, (*scenarios[:given], *held), given, noise, top)


def amplitude_m(rad_s: float, top_rev_s: float, truth: Truth) -> float:
    """Amplitude of a sinusoid [m] whose peak inertia and drag together take the thrust at top_rev_s, at most LARGEST_M.

    beta n^2 = ((A w^2)^2 + (alpha A^2 w^2)^2)^(1/2), since the two peak a quarter of a period apart.
    """
    square = (truth.beta_m_per_rev2 * top_rev_s**2 / rad_s**2) ** 2
    b = 0.5 / truth.alpha_per_m**2
    return min(math.sqrt(math.sqrt(b * b + square / truth.alpha_per_m**2) - b), LARGEST_M)


def _length(random: np.random.Generator) -> tuple[int, float, float]:
    """Number of runs that are given, tick [s] and duration [s]."""
    given, period_s = 1 + int(random.choice(len(GIVEN), p=GIVEN)), PERIODS_S[int(random.random() < FAST_SHARE)]
    duration_s = DURATION_S if random.random() < 0.5 else round(log_uniform(random, *DURATIONS_S))
    if random.random() < LONG_SHARE:
        return 1, period_s, DURATIONS_S[1]
    return given, period_s, float(min(duration_s, max(DURATIONS_S[0], SAMPLES * period_s // given)))


def _bands(random: np.random.Generator, count: int) -> list[float]:
    """Frequencies, one in each of `count` equal parts of the band on a log scale, shuffled [rad/s]."""
    edges = np.geomspace(*BAND_RAD_S, count + 1)
    drawn = [log_uniform(random, low, high) for low, high in zip(edges[:-1], edges[1:], strict=True)]
    return [float(rad_s) for rad_s in random.permutation(drawn)]


def _sonar(random: np.random.Generator, noise: Noise) -> Sonar:
    dropout = random.uniform(0.0, 0.08) if random.random() < 0.4 else 0.0
    dropout = 0.3 if noise.family == "missing_random" else dropout
    resolution = COARSE_M if noise.family == "coarse" else float(random.choice([0.0, 0.002, 0.005, 0.01]))
    return Sonar(noise_m=log_uniform(random, *NOISE_M), resolution_m=resolution, dropout=dropout)


def _turbulence(random: np.random.Generator, period_s: float) -> Turbulence:
    draw, level, time_s = random.random(), log_uniform(random, *TURBULENCE_M_S2), log_uniform(random, *TURBULENCE_S)
    if draw < STILL_SHARE:
        return Turbulence()
    white = draw < STILL_SHARE + WHITE_SHARE
    return Turbulence(2.0 * level if white else level, WHITE * period_s if white else time_s)


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
        speed = min(share * 0.75 * top, _within(push, truth))
        return Excitation(name, "speed", (speed,), push_s=push, coast_s=random.uniform(4.0, 12.0))
    if name == "square":
        slow = 0.1 + 0.3 * rad_s
        return Excitation(name, "position", (0.5 * share * LARGEST_M,), (slow,), phase_rad=phase)
    if name == "speed_sine":
        quick = max(rad_s, 0.35)
        speed = min(share * top, _within(1.0 / quick, truth))
        return Excitation(name, "speed", (speed,), (quick,), phase_rad=0.5 * math.pi)
    return Excitation(name, "position", (share * amplitude_m(rad_s, top, truth),), (rad_s,), 0.0, ramp, phase)


def _within(push_s: float, truth: Truth) -> float:
    """Propeller speed that moves the hull about half a metre in pushes of that length, drag left out [rev/s]."""
    return math.sqrt(0.5 / (push_s**2 * truth.beta_m_per_rev2))
