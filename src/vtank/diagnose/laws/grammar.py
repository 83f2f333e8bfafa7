"""The grammar: which factors a law may have, and where the search for their numbers begins.

A law is a *core*, which carries the unit (a force that goes with speed, thrust, propeller speed, acceleration, or a
constant), times one or two *modulators* (powers, thresholds, ramps, waves, decays, memories). Numbers of modulators lie
on grids that the recorded motion spans; nothing here knows any law.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from ...plant.formula import Factor, Memory
from .motion import Motion

SHARES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)  # of the motion's samples that a threshold cuts off
SHARP = {"u": 0.01, "speed": 0.01}  # [m/s] over which a threshold goes from 0 to 1
SOFT = 0.03  # the same over the span of any other variable; choices
SIGN = 0.01  # [SI, or the input's unit] over which a sign changes
LAGS_S = (0.25, 0.7, 2.0, 5.0, 12.0, 30.0)  # [s] memories that are tried
DELAYS_S = (0.35, 0.7, 1.4, 2.8, 5.6)  # [s] delays that are tried
PLAYS = (0.03, 0.07, 0.15, 0.3)  # of the span of a quantity, half the play that is tried
MOST_CYCLES = 60  # of a wave within the span of its variable; a choice
Modulator = tuple[Factor, Memory | None]

POWERS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
SIGNED = {"u": POWERS, "n": POWERS, "z": (1.0,), "a": (1.0,), "x": (1.0, 2.0, 3.0)}
EVEN = {"speed": (1.0, 2.0), "turning": (1.0, 2.0)}
CORES: tuple[tuple[Factor, ...], ...] = (
    (),
    *((Factor(v, "signed", k, SIGN),) for v, powers in SIGNED.items() for k in powers),
    *((Factor(v, "power", k),) for v, powers in EVEN.items() for k in powers),
)
RANGE_CORES = tuple(core for core in CORES if not core or core[0].variable in ("u", "speed", "x"))


def modulators(runs: Sequence[Motion], thrust: bool) -> Iterator[Modulator]:
    """All single modulators but waves; thrust: whether thrust and propeller may be among them."""
    names = ("u", "speed", "x", "gap", "t", *(("n", "turning") if thrust else ()))
    spread = {name: seen(runs, name) for name in names}
    yield from ((Factor(v, "power", k), None) for v in names if v not in "uxnt" for k in (0.5, 1.0, 2.0))
    yield from ((Factor("gap", "power", -k), None) for k in (1.0, 2.0, 3.0))
    yield from ((Factor(v, "signed", 1.0), None) for v in ("u", "x", "t", *("n" * thrust)))
    yield from ((Factor(v, "power", k), None) for v, k in (("x", 1.0), ("x", 2.0), ("t", 2.0)))
    for v in names:
        if v != "gap":
            span = float(np.ptp(np.quantile(spread[v], (0.02, 0.98))))
            edges = np.quantile(spread[v], SHARES) if v not in "un" else (0.0, *np.quantile(spread[v], SHARES))
            for edge, way in product(edges, (1.0, -1.0)):
                yield Factor(v, "above", float(edge), way * SHARP.get(v, SOFT * span)), None
                if v != "t":
                    yield Factor(v, "beyond", float(edge), way), None
    yield from ((Factor("gap", "decay", share * float(np.ptp(spread["gap"]))), None) for share in (0.15, 0.4, 1.0))
    longest = float(max(run.t[-1] - run.t[0] for run in runs))
    yield from ((Factor("t", "decay", share * longest), None) for share in (0.05, 0.1, 0.2, 0.4))
    if thrust:
        yield from _memories(spread)


def _memories(spread: dict[str, np.ndarray]) -> Iterator[Modulator]:
    """What was, and what is new."""
    kept = [Factor("u", "signed", k) for k in (0.0, 1.0, 2.0)] + [Factor("x", "signed", 1.0)]
    kept += [Factor("n", "signed", k) for k in (0.0, 1.0, 2.0)]
    kept += [Factor("turning", "power", k) for k in (1.0, 2.0, 3.0)] + [Factor("speed", "power", 1.0)]
    for q, lag in product(kept, LAGS_S):
        memory = Memory("follows", q, lag)
        yield Factor("w", "signed", 1.0), memory
        yield Factor("fresh", "signed", 1.0), memory
        if q.variable == "x":
            span = float(np.ptp(spread["x"]))
            yield from ((Factor("w", "decay", way * share * span), memory) for way in (1, -1) for share in (0.15, 0.4))
    yield from ((Factor("w", "signed", 1.0), Memory("delays", q, delay)) for q, delay in product(kept, DELAYS_S))
    for v, share in product(("u", "n", "x"), PLAYS):
        memory = Memory("plays", Factor(v, "signed", 1.0), share * float(np.ptp(spread[v])))
        yield from ((Factor(part, "signed", 1.0), memory) for part in ("w", "fresh"))
    for v in ("speed", "x", "u", "turning", "n"):
        levels = np.quantile(spread[v], (0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95))
        for low, high in product(levels, levels):
            if low < high:
                memory = Memory("latches", Factor(v, "signed", 1.0), float(high), float(low))
                yield Factor("w", "power", 1.0), memory
                yield Factor("w", "from", 1.0), memory


def waves(runs: Sequence[Motion], thrust: bool) -> Iterator[tuple[Factor, Factor, Memory | None]]:
    """Sine and cosine of place, time, way gone and turns made."""
    sums = [Memory("sums", Factor(v, "signed" if v == "n" else "power", 1.0)) for v in ("speed", "n", "turning")]
    for v, memory in [("x", None), ("t", None), *(("w", m) for m in sums * thrust)]:
        values = [run.remembered(memory)[0] if memory else getattr(run, v) for run in runs]
        span = float(max(np.ptp(value) for value in values))
        quickest = max(float(np.quantile(np.abs(np.diff(value) / np.diff(run.t)), 0.9)) for value, run in
                       zip(values, runs, strict=True))  # fmt: skip
        top = min(MOST_CYCLES, 1.2 * span / max(2.0 * quickest, 1e-9))  # [cycles] no quicker than 0.6 Hz
        for cycles in np.arange(0.5, max(top, 0.75), 0.5):
            w = float(2.0 * np.pi * cycles / span)
            yield Factor(v, "sine", w, 0.0), Factor(v, "sine", w, 0.5 * np.pi), memory


def seen(runs: Sequence[Motion], name: str, memory: Memory | None = None) -> np.ndarray:
    """Values of a variable over all runs."""
    if memory and name in ("w", "fresh"):
        return np.concatenate([run.remembered(memory)[int(name == "fresh")] for run in runs])
    name, size = {"speed": ("u", True), "turning": ("n", True)}.get(name, (name, False))
    values = np.concatenate([getattr(run, name) for run in runs])
    return np.abs(values) if size else values
