"""What could be missing, in groups: functions of the motion, own terms by run, windows of time, lines.

Every group is a Gaussian process of one size. Its columns are the change of all whitened innovations per unit of each
of its functions; those that go with all runs span all rows, those of one run its own rows alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from ...estimate.observed import SPEED
from ..evidence import Fitted
from .events import Events, events
from .functions import functions_of, products_of
from .motion import Motion, motions

PROBE_M_S2, PROBE_M = 1e-4, 1e-3  # size of a probing force and error, small enough to be linear
PAIRED = ("speed", "input", "place", "acceleration")  # variables that may act together
MODULATING = ("speed", "input", "place", "time", "thrust of the last 15 s")  # what may change an own term
ACTUATED = ("input", "thrust")  # words of what belongs to the actuator
BINS, SHORTEST_S = 40, 3.0  # bins of time of a run at most, and the shortest [s]; choices
SCANNED_RAD_S = np.arange(0.08, 3.2, 0.045)  # frequencies of lines; 120 s resolve about 0.05 rad/s
PERIODS = np.arange(0.5, 30.0, 0.5)  # over the whole range, of an error periodic in place; half of one is resolved
QUICK = 12  # frequencies above those at which an error of the readings is loudest, that are looked at besides; a choice
TOGETHER = 64  # columns changed at a time: about as many as a processor's cache holds
HULL, ACTUATOR, SENSOR = "hydrodynamics", "actuator", "sensor"


@dataclass(frozen=True)
class Piece:
    """Columns made in one go, of all runs together or of one run.

    Attributes:
        kind: "function", "window", "event" or "line".
        channel: where it acts.
        about: what it goes with, in words.
        force: whether a force [m/s2] at the input's stamps, else an error [m or m/s] at the measurements.
        functions: per run, shape (I, K) or (M, K); None where the run has none.
        each: columns of one group, where the piece holds several side by side.
        edges: of the bins of windows [s].
        frequencies: of lines [rad/s].
        events: where each column of short events is.
    """

    kind: str
    channel: str
    about: str
    force: bool
    functions: tuple[np.ndarray | None, ...]
    each: int
    edges: np.ndarray = field(default_factory=lambda: np.zeros(0))
    frequencies: np.ndarray = field(default_factory=lambda: np.zeros(0))
    events: Events | None = None


def pieces(fit: Fitted) -> list[Piece]:
    """All that could be missing from a fitted model."""
    moved = motions(fit)
    fed, read = [pair[0] for pair in moved], [pair[1] for pair in moved]
    return [
        *_forces(fed),
        *_errors(read),
        *(piece for k in range(len(moved)) for piece in _windows(k, moved)),
        *(piece for k in range(len(moved)) for piece in _events(k, fit)),
        _lines("force", HULL, True, SCANNED_RAD_S, [m.t for m in fed]),
        _lines("error", SENSOR, False, np.concatenate([SCANNED_RAD_S, _loudest(fit)]), [m.t for m in read]),
    ]


def _forces(fed: list[Motion]) -> Iterator[Piece]:
    single = {name: _functions([m.variables[name] for m in fed]) for name in fed[0].variables}
    for name, found in single.items():
        yield _piece(_channel(name), name, found)
    for pair in combinations(PAIRED, 2):
        both = [products_of(a, b) for a, b in zip(*(single[name] for name in pair), strict=True)]
        yield _piece(_channel(" ".join(pair)), " and ".join(pair), both)
    for term in fed[0].terms:
        for name in MODULATING:
            both = [m.terms[term][:, None] * f for m, f in zip(fed, single[name], strict=True)]
            yield _piece(HULL if term == "drag" else ACTUATOR, f"{term} over {name}", both)


def _channel(about: str) -> str:
    return ACTUATOR if any(word in about for word in ACTUATED) else HULL


def _piece(channel: str, about: str, found: list[np.ndarray]) -> Piece:
    return Piece("function", channel, about, True, tuple(found), found[0].shape[1])


def _errors(read: list[Motion]) -> Iterator[Piece]:
    """Smooth errors of the readings; of speeds ten times those of positions [m/s against m]."""
    names = ("place", "speed", "time", "acceleration")
    single = {name: _functions([m.variables[name] for m in read]) for name in names}
    single["place and speed"] = [products_of(a, b) for a, b in zip(single["place"], single["speed"], strict=True)]
    for name, found in single.items():
        yield Piece("function", SENSOR, name, False, tuple(found), found[0].shape[1])
    share = _shares([m.x for m in read])
    waves = tuple(_waves(2.0 * np.pi * np.outer(s, PERIODS)) for s in share)
    yield Piece("function", SENSOR, "place, periodic", False, waves, 2)


def _windows(k: int, moved: list[tuple[Motion, Motion]]) -> Iterator[Piece]:
    """Bins of time of one run, in which a force, an own term or a reading is off."""
    fed, read = moved[k]
    length = fed.t[-1] - fed.t[0]
    edges = np.linspace(fed.t[0], fed.t[-1], int(np.clip(length / SHORTEST_S, 1, BINS)) + 1)

    def bins(t: np.ndarray, values: np.ndarray) -> np.ndarray:
        place = np.clip(np.searchsorted(edges, t, side="right") - 1, 0, edges.size - 2)
        return np.asarray(values[:, None] * (place[:, None] == np.arange(edges.size - 1)))

    def own(found: np.ndarray) -> tuple[np.ndarray | None, ...]:
        return tuple(found if i == k else None for i in range(len(moved)))

    forces = {"force": (HULL, np.ones(fed.t.size))}
    forces |= {term: (HULL if term == "drag" else ACTUATOR, values) for term, values in fed.terms.items()}
    for about, (channel, values) in forces.items():
        yield Piece("window", channel, about, True, own(bins(fed.t, values)), 1, edges)
    for about, values in (("reading", np.ones(read.t.size)), ("latency", read.u)):
        yield Piece("window", SENSOR, about, False, own(bins(read.t, values)), 1, edges)


def _events(k: int, fit: Fitted) -> Iterator[Piece]:
    """Readings of one run that are off for a moment, shorter than the bins of windows."""
    run, (judging, off) = fit.problem.runs[k], _judging(fit, k)
    found = events(run.time_s, np.where(judging & fit.problem.used(k), off, np.nan), SHORTEST_S)
    if found.spans:
        own = tuple(found.inside if i == k else None for i in range(len(fit.problem.runs)))
        yield Piece("event", SENSOR, "reading", False, own, 1, events=found)


def _lines(about: str, channel: str, force: bool, rad_s: np.ndarray, stamps: list[np.ndarray]) -> Piece:
    """Sines and cosines of time, of a phase of its own in every run."""
    waves = tuple(_waves(np.outer(t - t[0], rad_s)) for t in stamps)
    return Piece("line", channel, about, force, waves, 2, frequencies=rad_s)


def _waves(phase: np.ndarray) -> np.ndarray:
    """Sine and cosine of every column of phases, side by side, shape (I, 2 K)."""
    out = np.empty((*phase.shape, 2))
    np.sin(phase, out=out[:, :, 0])
    np.cos(phase, out=out[:, :, 1])
    return out.reshape(phase.shape[0], -1)


def _loudest(fit: Fitted) -> np.ndarray:
    """Frequencies above the scanned at which all innovations are loudest [rad/s], shape (QUICK,) or less."""
    runs = []
    for k, run in enumerate(fit.problem.runs):
        own, off = _judging(fit, k)
        runs.append((run.time_s[own], off[own]))
    step = max(float(np.median(np.diff(t))) for t, _ in runs)
    longest = max(float(np.ptp(t)) for t, _ in runs)
    size = 2 * int(2 ** np.ceil(np.log2(max(longest / step, 2.0))))
    power = np.zeros(size // 2 + 1)
    for t, e in runs:
        even = np.interp(np.arange(t[0], t[-1], step), t, e)
        power += np.abs(np.fft.rfft(even, size)) ** 2
    rad_s = 2.0 * np.pi * np.fft.rfftfreq(size, step)
    inner = power[1:-1]
    peak = (inner >= power[:-2]) & (inner > power[2:]) & (rad_s[1:-1] > SCANNED_RAD_S[-1])
    peaks = 1 + np.flatnonzero(peak)
    return rad_s[peaks[np.argsort(-power[peaks])][:QUICK]]


def _judging(fit: Fitted, k: int) -> tuple[np.ndarray, np.ndarray]:
    """By which measurements the readings of a run are judged, range before position before speed; all innovations.

    These over their deviations; shapes (M,).
    """
    run, f = fit.problem.runs[k], fit.filtered[k]
    return run.kind == np.min(run.kind), f.innovation / np.sqrt(f.variance)


def _shares(values: list[np.ndarray]) -> list[np.ndarray]:
    """Values as shares of the range of all runs together."""
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    return [(v - low) / max(high - low, 1e-12) for v in values]


def _functions(values: list[np.ndarray]) -> list[np.ndarray]:
    return [functions_of(share) for share in _shares(values)]


def changes(fit: Fitted, made: list[Piece]) -> list[np.ndarray]:
    """Per run, the change of its whitened innovations per unit of every column of every piece, shape (M, C)."""
    problem, theta = fit.problem, fit.optimum.theta

    def of(k: int) -> np.ndarray:
        run, f = problem.runs[k], fit.filtered[k]
        sides = [[own for piece in made if piece.force is force and (own := piece.functions[k]) is not None]
                 for force in (True, False)]  # fmt: skip
        out = np.empty((run.time_s.size, sum(own.shape[1] for side in sides for own in side)))
        base, done = (f.innovation / np.sqrt(f.variance))[:, None], 0
        for force, columns in zip((True, False), map(np.hstack, sides), strict=True):
            for first in range(0, columns.shape[1], TOGETHER):
                some = columns[:, first : first + TOGETHER]
                size = np.max(np.abs(some), axis=0) + 1e-300
                if force:
                    there, probe = problem.varied(theta, f, k, forcing=PROBE_M_S2 * some / size), PROBE_M_S2
                else:
                    scaled = np.where((run.kind == SPEED)[:, None], 10.0, 1.0) * some
                    there = problem.varied(theta, f, k, value=run.value[:, None] - PROBE_M * scaled / size)
                    probe = PROBE_M
                np.multiply(there - base, size / probe, out=out[:, done : (done := done + some.shape[1])])
        return out

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(of, range(len(problem.runs))))
