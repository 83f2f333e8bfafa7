"""Random laws: what a simulator may lack, drawn and not listed, so that nobody can tune a diagnosis to it.

A law of everywhere is a product of one to three random factors; a law of some windows is a burst, a bump, a step of
gain, a random law for a while, or a sensor that stalls; an error of a sensor goes with a narrow band, a place, or time.
Ranges are choices: each factor is about one in size where the vehicle usually is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...plant import Truth
from .laws import (
    ABOVE,
    BEHIND,
    DAY,
    DELAYED,
    EVEN,
    GAP,
    LAGGED,
    NOW,
    ODD,
    ONE_SIDED,
    PLAY,
    SINE,
    SUMMED,
    THRUST,
    A,
    Factor,
    Law,
    N,
    T,
    U,
    X,
)

ACTS = {"force": 0.45, "thrust": 0.25, "range": 0.2, "tachometer": 0.1}  # share of each; choices
IN_TIME = {NOW: 0.6, LAGGED: 0.12, BEHIND: 0.07, DELAYED: 0.07, SUMMED: 0.04, PLAY: 0.1}
BENT = {ODD: 0.35, EVEN: 0.2, ABOVE: 0.15, ONE_SIDED: 0.15, SINE: 0.15}
SIGNALS = {U: 0.3, N: 0.25, X: 0.12, GAP: 0.08, T: 0.1, A: 0.15}
FACTORS = {1: 0.35, 2: 0.45, 3: 0.2}
PUSH, GAIN, RANGE_M, READING = 0.1, 0.1, 0.01, 0.05  # size 1: of the usual thrust, of the thrust, m, of the usual speed


@dataclass(frozen=True)
class Scene:
    """What a law is drawn for: hull, usual propeller speed [rev/s], duration of every run [s], number of runs given."""

    truth: Truth
    n_rev_s: float
    durations_s: tuple[float, ...]
    given: int

    @property
    def usual(self) -> dict[float, float]:
        """Usual size of each signal, in its unit."""
        thrust = self.truth.beta_m_per_rev2 * self.n_rev_s**2
        speed = 0.6 * float(np.sqrt(thrust / abs(self.truth.alpha_per_m)))
        return {U: speed, N: self.n_rev_s, X: 0.3, GAP: 2.5, T: 60.0, DAY: 600.0, A: 0.6 * thrust, THRUST: thrust}

    def unit(self, acts: str) -> float:
        """Size 1 of a law that acts there."""
        sizes = {"force": PUSH * self.usual[THRUST], "thrust": GAIN, "range": RANGE_M}
        return sizes.get(acts, READING * self.n_rev_s)


Random = np.random.Generator
Windows = tuple[tuple[tuple[float, float], ...], ...]  # of every run


def draw_law(name: str, random: Random, scene: Scene) -> Law:
    """A law of that family."""
    return FAMILIES[name](random, scene)


def anything(random: Random, scene: Scene) -> Law:
    """A product of random factors, anywhere."""
    acts = choose(random, ACTS)
    factors = tuple(_factor(random, scene) for _ in range(choose(random, FACTORS)))
    return _law("random", acts, random, scene, factors)


def burst(random: Random, scene: Scene) -> Law:
    """Waves for a while."""
    wave = Factor(T, 1.0, bent=SINE, c=random.uniform(1.0, 6.0), w=random.uniform(0.0, 6.0))
    return replace(_law("burst", "force", random, scene, (wave,)), windows=_windows(random, scene, 8.0, 25.0))


def bump(random: Random, scene: Scene) -> Law:
    """Something pushes once, one way."""
    law = _law("bump", "force", random, scene, (), largest=20.0)
    return replace(law, windows=_windows(random, scene, 1.5, 8.0), swells=True)


def gain_step(random: Random, scene: Scene) -> Law:
    """The thrust is another from an instant on, in this run."""
    law = _law("gain_step", "thrust", random, scene, ())
    starts = (random.uniform(0.3, 0.7) * duration_s for duration_s in scene.durations_s)
    spans = [((start, end),) for start, end in zip(starts, scene.durations_s, strict=True)]
    return replace(law, windows=_some(random, scene, spans))


def for_a_while(random: Random, scene: Scene) -> Law:
    """A random law, but only for a while."""
    law = anything(random, scene)
    return replace(law, name="for_a_while", windows=_windows(random, scene, 15.0, 50.0))


def stall(acts: str) -> Callable[[Random, Scene], Law]:
    """A sensor that repeats its last reading now and then."""

    def drawn(random: Random, scene: Scene) -> Law:
        windows = _windows(random, scene, 0.3, 4.0)
        return Law(f"stall_{acts}", acts, 1.0, 1.0, windows=windows, stalls=True, solved=False)

    return drawn


def narrow_band(random: Random, scene: Scene) -> Law:
    """Range goes to and fro by itself, in a narrow band."""
    line = Factor(DAY, 1.0, bent=SINE, c=random.uniform(1.5, 25.0), w=random.uniform(0.0, 6.0))
    swell = Factor(DAY, 1.0, bent=SINE, c=random.uniform(6.0, 30.0) * line.c, w=random.uniform(0.0, 6.0))
    return _law("narrow_band", "range", random, scene, (line, swell) if random.random() < 0.5 else (line,), 15.0)


def place(random: Random, scene: Scene) -> Law:
    """Range is wrong by where the vehicle is."""
    wave = Factor(GAP, 1.0, bent=SINE, c=random.uniform(0.08, 0.6), w=random.uniform(0.0, 6.0))
    bend = Factor(X, 0.3, bent=choose(random, {ODD: 0.5, EVEN: 0.5}), c=random.uniform(1.5, 3.5))
    edge = Factor(X, 1.0, bent=ONE_SIDED, c=random.uniform(-0.15, 0.15), w=random.uniform(0.02, 0.08))
    return _law("place", "range", random, scene, ((wave, bend, edge)[random.integers(3)],), 15.0)


def drift(random: Random, scene: Scene) -> Law:
    """Range drifts with time since switched on, or through the day."""
    power = Factor(T, scene.durations_s[0], bent=EVEN, c=random.uniform(0.4, 2.5))
    slow = Factor(DAY, 1.0, bent=SINE, c=random.uniform(0.7, 4.0) * scene.durations_s[0], w=random.uniform(0.0, 6.0))
    return _law("drift", "range", random, scene, (power if random.random() < 0.5 else slow,), 15.0)


EVERYWHERE: dict[str, Callable[[Random, Scene], Law]] = {"random": anything}
SENSOR: dict[str, Callable[[Random, Scene], Law]] = {"narrow_band": narrow_band, "place": place, "drift": drift}
LOCAL: dict[str, Callable[[Random, Scene], Law]] = {
    "burst": burst,
    "bump": bump,
    "gain_step": gain_step,
    "for_a_while": for_a_while,
    "stall_range": stall("range"),
    "stall_tachometer": stall("tachometer"),
}
FAMILIES = EVERYWHERE | SENSOR | LOCAL


def _law(name: str, acts: str, random: Random, scene: Scene, factors: tuple[Factor, ...], largest: float = 8.0) -> Law:
    """A law of either sign; one in the thrust multiplies it, lag and all."""
    if acts == "thrust":
        tau = scene.truth.tau_s
        factors = (Factor(THRUST, 1.0, LAGGED if tau > 0.0 else NOW, tau), *factors)
    sign = float(random.choice([-1.0, 1.0]))
    return Law(name, acts, sign * scene.unit(acts), largest, factors)


def _factor(random: Random, scene: Scene) -> Factor:
    """A random factor, about one in size."""
    signal, bent, in_time = (choose(random, shares) for shares in (SIGNALS, BENT, IN_TIME))
    if signal in (GAP, T):  # always positive: no memory, and a sine or a power
        in_time = NOW
        bent = bent if bent in (EVEN, SINE) else SINE
    if signal == A and in_time == NOW:  # as it is, it would answer to itself within a tick
        in_time = LAGGED
    scale, c, w = scene.usual[signal], random.uniform(0.5, 3.0), 1.0
    time = random.uniform(0.3, 6.0) if in_time != PLAY else random.uniform(0.1, 0.6)
    if in_time == SUMMED:
        bent, scale = SINE, 1.0 if signal != N else 10.0
    if bent == SINE:
        long = {SUMMED: (0.3, 3.0), NOW: (0.2, 2.5)}.get(in_time, (0.5, 2.5))
        c, w = random.uniform(*long), random.uniform(0.0, 6.0)
    elif bent in (ABOVE, ONE_SIDED):
        c, w = (
            random.uniform(0.2, 1.0) * (1.0 if bent == ABOVE else random.choice([-0.5, 0.5])),
            random.uniform(0.02, 0.2),
        )
        w = w if random.random() < 0.5 else -w
    return Factor(signal, scale, in_time, time, bent, float(c), float(w))


def _windows(random: Random, scene: Scene, shortest_s: float, longest_s: float) -> Windows:
    """One to three windows in some of the runs, apart from one another; none in runs held back."""
    spans = []
    for duration_s in scene.durations_s:
        count = int(random.integers(1, 4))
        room = duration_s / count
        lengths = [min(random.uniform(shortest_s, longest_s), 0.6 * room) for _ in range(count)]
        starts = [i * room + random.uniform(0.0, room - length) for i, length in enumerate(lengths)]
        spans.append(tuple((s, s + length) for s, length in zip(starts, lengths, strict=True)))
    return _some(random, scene, spans)


def _some(random: Random, scene: Scene, spans: Sequence[tuple[tuple[float, float], ...]]) -> Windows:
    """These windows in one or more of the runs that are given, and in no other."""
    hit = random.permutation(scene.given)[: random.integers(1, scene.given + 1)]
    return tuple(tuple((round(a, 2), round(b, 2)) for a, b in span) if k in hit else () for k, span in enumerate(spans))


def choose(random: Random, shares: dict[Any, float]) -> Any:
    """One of the keys, as likely as its share of all values."""
    names, weights = list(shares), np.array(list(shares.values()))
    return names[int(random.choice(len(names), p=weights / weights.sum()))]
