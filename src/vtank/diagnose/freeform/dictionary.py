"""What could be missing, in groups: functions of the motion, own terms by run, windows of time, lines.

Every group is a Gaussian process of one size. Its columns are the change of all whitened innovations per unit of each
of its functions; those that go with all runs span all rows, those of one run its own rows alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from ...estimate.observed import SPEED, Observed
from ..evidence import Fitted
from ..lines import Lines, bands, judging, loudest
from ..outliers import resolution
from .events import Events, events, packets, waves
from .functions import functions_of, products_of, ways_of
from .motion import Motion, motions, rate, rung, simulated, thrust_along
from .stalls import bridged, stalls

PROBE_M_S2, PROBE_M = 1e-4, 1e-3  # size of a probing force and error, small enough to be linear
FASTER = 10.0  # [1/s] error of a speed beforehand over that of a position; a choice
PAIRED = ("speed", "input", "place", "acceleration")  # variables that may act together
MODULATING = ("speed", "input", "place", "time", "thrust of the last 15 s")  # what may change an own term
STICKY = ("input", "speed")  # variables that a force may drag behind with play
ACTUATED = ("input", "thrust")  # words of what belongs to the actuator
BINS, SHORTEST_S = 40, 3.0  # bins of time of a run at most, and the shortest [s]; choices
SHARPER = 8  # finer bins to one, where a window begins or ends; a choice
PERIODS = np.arange(0.5, 30.0, 0.5)  # over the whole range, of an error periodic in place; half of one is resolved
PITCHED_M = 5e-4  # [m] that a hull held by thrusters pitches a sonar to and fro: 0.1 degrees at 0.3 m; a guess
RESOLVED = 2.0  # of these, from which a force is no smooth function; a choice
COARSE = 2.0  # steps of a coarse reading to the shortest period in place that is not of its own making; a choice
TOGETHER = 64  # columns changed at a time: about as many as a processor's cache holds
CHANNELS = HULL, ACTUATOR, SENSOR = "hydrodynamics", "actuator", "sensor"
SWINGING = "error in a band"  # of frequencies: what it goes with, in words


@dataclass(frozen=True)
class Piece:
    """Columns made in one go, of all runs together or of one run.

    Attributes:
        kind: "function", "window", "event", "stall" or "line".
        channel: where it acts.
        about: what it goes with, in words.
        force: whether a force [m/s2] at the input's stamps, else an error [m or m/s] at the measurements.
        functions: per run, shape (I, K) or (M, K); None where the run has none.
        each: columns of one group, where the piece holds several side by side.
        edges: of the bins of windows [s].
        lines: their frequencies.
        rounding: amplitude of a line at each of these that the rounding of the readings may make, in the unit of the
            functions.
        events: what each group of columns is, of short events.
    """

    kind: str
    channel: str
    about: str
    force: bool
    functions: tuple[np.ndarray | None, ...]
    each: int
    edges: np.ndarray = field(default_factory=lambda: np.zeros(0))
    lines: Lines | None = None
    rounding: np.ndarray = field(default_factory=lambda: np.zeros(0))
    events: Events | None = None


def pieces(fit: Fitted, swell: float | None = None) -> list[Piece]:
    """All that could be missing from a fitted model; swell: frequency of a wave that may be one [rad/s].

    Else an error of the readings in a band about it.
    """
    moved, alone = motions(fit), simulated(fit.problem, fit.optimum.theta)
    fed, read, lines = [pair[0] for pair in moved], [pair[1] for pair in moved], loudest(fit)
    step = max(resolution(run.value[run.kind == np.min(run.kind)]) for run in fit.problem.runs)
    of_forces, of_errors = _roundings(fit, lines, read, step)
    return [
        *_forces(fed),
        *_errors(read, step),
        *(piece for k in range(len(moved)) for piece in _local(k, moved, fit)),
        *(piece for k, f in enumerate(alone) for piece in _stalled(k, fit, f.innovation)),
        _lines("force", HULL, True, lines, [m.t for m in fed], of_forces),
        _lines("error", SENSOR, False, lines, [m.t for m in read], of_errors),
        _late(fit, read, step),
        *(_bands(fit, swell, [m.t for m in read]) if swell else ()),
    ]


def _roundings(fit: Fitted, lines: Lines, read: list[Motion], step: float) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes of lines that rounding may make, as of forces [m/s2] and of errors before they are scaled, (L,)."""
    most = _rounded(fit, lines, read, step)
    return (most * lines.rad_s, most / FASTER) if _judged(fit) == SPEED else (most * lines.rad_s**2, most)


def _rounded(fit: Fitted, lines: Lines, read: list[Motion], step: float) -> np.ndarray:
    """Amplitudes of lines that rounding may make of the readings that are judged, (L,) [their unit]."""
    kind = _judged(fit)
    speeds = [m.variables["acceleration"] if kind == SPEED else m.u for m in read]
    rates = np.concatenate([rate(m.t, some) for m, some in zip(read, speeds, strict=True)])
    return rounded_lines(lines.rad_s, step, fit.problem.noise.variance[kind], np.concatenate(speeds), rates)


def _judged(fit: Fitted) -> int:
    """The channel by which runs are judged, of all runs the first."""
    return min(int(np.min(run.kind)) for run in fit.problem.runs)


def rounded_lines(
    rad_s: np.ndarray, step: float, variance: float, speeds: np.ndarray, rates: np.ndarray
) -> np.ndarray:  # fmt: skip
    """Amplitudes of lines that rounding to a step makes of readings, at most, shape (L,) [their unit].

    Readings that move evenly, a step in each period or slower, are off by a saw-tooth, whose first line is that of
    step / pi; less where noise moves them from step to step, and for the share of time at which they move so slowly.
    Where they turn round, for sqrt(step / rate) as the stationary phase of the saw-tooth has it, they make a line of
    any period if the motion repeats itself, as long as they are slower than sqrt(step rate); all lines of the saw-tooth
    do, of 1 / k of the size and for 1 / sqrt(k) of the time.
    variance: of white errors, rounding among them. speeds: of the readings, shape (N,) [their unit per s]; rates: of
    these, whose peak is taken for that of a sine. Widrow, Kollar, Quantization Noise (2008), ch. 4 and 20.
    """
    if step == 0.0:
        return np.zeros(rad_s.size)
    noise, k = max(variance - step**2 / 12.0, 0.0), np.arange(1, 51)
    left = np.exp(-2.0 * np.pi**2 * k**2 * noise / step**2) / k
    even, turning = rad_s * step / (2.0 * np.pi), np.sqrt(step * np.sqrt(2.0 * np.mean(rates**2)))
    shares = np.searchsorted(np.sort(np.abs(speeds)), [even, np.full(even.size, turning)], side="right") / speeds.size
    return np.asarray(step / np.pi * np.maximum(left[0] * shares[0], np.sum(left / np.sqrt(k)) * shares[1]))


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
            acts = _channel(name) if term == "drag" else ACTUATOR  # a drag that goes with the input: the thrust's loss
            yield _piece(acts, f"{term} over {name}", both)
    for name in STICKY:
        about = f"which way the {name} went last"
        yield _piece(_channel(name), about, [ways_of(share) for share in _shares([m.variables[name] for m in fed])])
    for name, after in (("acceleration", [m.variables["acceleration"] for m in fed]), ("thrust", [m.z for m in fed])):
        ringing = tuple(rung(m.t, values) for m, values in zip(fed, after, strict=True))
        yield Piece("function", _channel(name), f"ringing after the {name}", True, ringing, 2)
    ones = [np.ones(m.t.size) for m in fed]
    yield _ripples(HULL, "place", [m.x for m in fed], ones)
    yield _ripples(ACTUATOR, "thrust over input", [np.abs(m.n) for m in fed], [m.terms["thrust"] for m in fed])


def _ripples(channel: str, about: str, over: list[np.ndarray], terms: list[np.ndarray]) -> Piece:
    """A force periodic in something: what goes by posts, teeth or slots, or resonates, faster than a smooth function.

    terms: what it is a share of.
    """
    periods = PERIODS[PERIODS >= RESOLVED]
    columns = tuple(term[:, None] * waves(2.0 * np.pi * np.outer(share, periods))
                    for term, share in zip(terms, _shares(over), strict=True))  # fmt: skip
    return Piece("function", channel, f"{about}, periodic", True, columns, 2)


def _channel(about: str) -> str:
    return ACTUATOR if any(word in about for word in ACTUATED) else HULL


def _piece(channel: str, about: str, found: list[np.ndarray]) -> Piece:
    return Piece("function", channel, about, True, tuple(found), found[0].shape[1])


def _errors(read: list[Motion], step: float) -> Iterator[Piece]:
    """Smooth errors of the readings, see `scaled`.

    step: of a coarse reading [m or m/s], which is off by a period of its own, and known.
    """
    names = ("place", "speed", "time", "acceleration", "input")
    single = {name: _functions([m.variables[name] for m in read]) for name in names}
    single["place and speed"] = [products_of(a, b) for a, b in zip(single["place"], single["speed"], strict=True)]
    single["which way the place went last"] = [ways_of(share) for share in _shares([m.x for m in read])]
    for name, found in single.items():
        yield Piece("function", SENSOR, name, False, tuple(found), found[0].shape[1])
    share, whole = _shares([m.x for m in read]), np.ptp(np.concatenate([m.x for m in read]))
    periods = PERIODS[PERIODS * COARSE * step < whole]
    if periods.size:
        columns = tuple(waves(2.0 * np.pi * np.outer(s, periods)) for s in share)
        yield Piece("function", SENSOR, "place, periodic", False, columns, 2)


def pitching(fit: Fitted) -> Piece:
    """What a sonar off the axis reads of a hull that thrust and drag pitch, each of root mean square PITCHED_M.

    With the forces, as the hull rights itself faster than a drive turns them round; thrust is what accelerates it and
    what overcomes its drag.
    """
    read = [pair[1] for pair in motions(fit)]
    columns = [np.column_stack([m.variables["acceleration"], m.u * np.abs(m.u)]) for m in read]
    usual = np.sqrt(np.mean(np.concatenate(columns) ** 2, axis=0)) + 1e-12
    return Piece("pitch", SENSOR, "pitch", False, tuple(PITCHED_M * some / usual for some in columns), 2)


def _local(k: int, moved: list[tuple[Motion, Motion]], fit: Fitted) -> Iterator[Piece]:
    """What is off in one run for a while: in bins of time, in short events, in packets of waves."""
    fed, read = moved[k]
    width_s = max((fed.t[-1] - fed.t[0]) / BINS, SHORTEST_S)
    edges = np.linspace(fed.t[0], fed.t[-1], int(max((fed.t[-1] - fed.t[0]) / width_s, 1.0)) + 1)

    def bins(t: np.ndarray) -> np.ndarray:
        place = np.clip(np.searchsorted(edges, t, side="right") - 1, 0, edges.size - 2)
        return np.asarray(place[:, None] == np.arange(edges.size - 1))

    run, (own, off) = fit.problem.runs[k], judging(fit, k)
    off = np.where(own & fit.problem.used(k), off, np.nan)
    short, swinging = events(run.time_s, off, width_s), packets(run.time_s, off)
    for channel, about, force, values in _terms(fed, read):
        t = (fed if force else read).t
        made: list[tuple[str, np.ndarray, int, Events | None]] = [("window", bins(t), 1, None)]
        if about != "latency":
            made.append(("event", short.functions(t), 1, short))
        if about in ("force", "reading"):
            made.append(("event", swinging.functions(t), 2, swinging))
        for kind, functions, each, found in made:
            if functions.size:
                columns = tuple(values[:, None] * functions if i == k else None for i in range(len(moved)))
                yield Piece(kind, channel, about, force, columns, each, edges, events=found)


def _terms(fed: Motion, read: Motion) -> Iterator[tuple[str, str, bool, np.ndarray]]:
    """What may be off for a while: channel, words, whether it is a force, and its course [m/s2, m or m/s]."""
    yield HULL, "force", True, np.ones(fed.t.size)
    for term, values in fed.terms.items():
        yield HULL if term == "drag" else ACTUATOR, term, True, values
    yield SENSOR, "reading", False, np.ones(read.t.size)
    yield SENSOR, "latency", False, read.u


def _stalled(k: int, fit: Fitted, off: np.ndarray) -> Iterator[Piece]:
    """Readings of one run that repeat themselves in place of what they would be.

    off: measured less simulated, shape (M,).
    """
    run, (p, _), runs = fit.problem.runs[k], fit.problem.model(fit.optimum.theta, k), len(fit.problem.runs)
    counts = np.flatnonzero(judging(fit, k)[0])
    ranges, inputs = stalls(run.value[counts], (run.value - off)[counts]), stalls(run.input)
    error, force = np.zeros((off.size, len(ranges))), np.zeros((run.input.size, len(inputs)))
    for e, span in enumerate(ranges):
        error[counts, e] = off[counts] - bridged(off[counts], span)
    for e, span in enumerate(inputs):
        there, held = (thrust_along(run.input_time_s, n, p) for n in (bridged(run.input, span), run.input))
        force[:, e] = there - held
    for is_force, t, spans, functions in (
        (False, run.time_s[counts], ranges, error),
        (True, run.input_time_s, inputs, force),
    ):
        if spans:
            events = Events.known(tuple((float(t[a + 1]), float(t[b])) for a, b in spans))
            own = tuple(functions if i == k else None for i in range(runs))
            yield Piece("stall", SENSOR, "repeated reading", is_force, own, 1, events=events)


def _lines(
    about: str, channel: str, force: bool, lines: Lines, stamps: list[np.ndarray], rounding: np.ndarray
) -> Piece:  # fmt: skip
    """Sines and cosines of time, of a phase of its own in every run; rounding: as of `Piece`."""
    columns = tuple(waves(np.outer(t - t[0], lines.rad_s)) for t in stamps)
    return Piece("line", channel, about, force, columns, 2, lines=lines, rounding=rounding)


def _late(fit: Fitted, read: list[Motion], step: float) -> Piece:
    """Readings that are late by a sine of time: two clocks that beat, a delay that comes and goes in turn.

    Rounding makes the line of a period where readings move a step in it, and seems to be late there.
    """
    rates = [np.where(run.kind == SPEED, m.variables["acceleration"], m.u)
             for run, m in zip(fit.problem.runs, read, strict=True)]  # fmt: skip
    lines, usual = loudest(fit, rates), float(np.sqrt(np.mean(np.concatenate(rates) ** 2))) + 1e-300
    rounding = _rounded(fit, lines, read, step) / usual
    even = _lines("latency, periodic", SENSOR, False, lines, [m.t for m in read], rounding)
    late = tuple(some[:, None] * wave for some, wave in zip(rates, even.functions, strict=True) if wave is not None)
    return replace(even, functions=late)


def _bands(fit: Fitted, rad_s: float, stamps: list[np.ndarray]) -> Iterator[Piece]:
    """An error of the readings in a band of frequencies about one: a swinging instrument, not of one phase for long."""
    for band, share in bands(fit.problem.runs, rad_s):
        columns = tuple(waves(np.outer(t - t[0], band)) for t in stamps)
        line = Lines(np.array([rad_s]), np.array([share]), np.ones(1))
        yield Piece("line", SENSOR, SWINGING, False, columns, 2 * band.size, lines=line, rounding=np.zeros(1))


def sharper(piece: Piece, k: int, start: float, stop: float, width: float, fit: Fitted) -> Piece:
    """A term of run k in finer bins about both ends of a window, as far as `width` off them [s]; in between, in one.

    The run's own ends stay where they are.
    """
    functions, run = piece.functions[k], fit.problem.runs[k]
    assert functions is not None
    stamps, whole, middle = run.input_time_s if piece.force else run.time_s, piece.edges, 0.5 * (start + stop)
    left = np.linspace(start - width, min(start + width, middle), 2 * SHARPER + 1) if start > whole[0] else whole[:1]
    right = np.linspace(max(stop - width, middle), stop + width, 2 * SHARPER + 1) if stop < whole[-1] else whole[-1:]
    finer = np.unique(np.clip(np.concatenate([whole[[0, -1]], left, right]), whole[0], whole[-1]))
    place = np.clip(np.searchsorted(finer, stamps, side="right") - 1, 0, finer.size - 2)
    own = functions.sum(axis=1)[:, None] * (place[:, None] == np.arange(finer.size - 1))
    return replace(piece, functions=tuple(own if f is not None else None for f in piece.functions), edges=finer)


def _shares(values: list[np.ndarray]) -> list[np.ndarray]:
    """Values as shares of the range of all runs together."""
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    return [(v - low) / max(high - low, 1e-12) for v in values]


def _functions(values: list[np.ndarray]) -> list[np.ndarray]:
    return [functions_of(share) for share in _shares(values)]


def scaled(run: Observed, functions: np.ndarray) -> np.ndarray:
    """Errors of a run's readings for functions, shape (M, K) [m or m/s]: of speeds ten times those of positions."""
    return np.where((run.kind == SPEED)[:, None], FASTER, 1.0) * functions


def changes(fit: Fitted, made: list[Piece]) -> list[np.ndarray]:
    """Per run, the change of its whitened innovations per unit of every column of every piece, shape (M, C)."""
    problem, theta = fit.problem, fit.optimum.theta

    def of(k: int) -> np.ndarray:
        run, f = problem.runs[k], fit.filtered[k]
        sides = [[own for piece in made if piece.force is force and (own := piece.functions[k]) is not None]
                 for force in (True, False)]  # fmt: skip
        out = np.empty((run.time_s.size, sum(own.shape[1] for side in sides for own in side)))
        base, done = (f.innovation / np.sqrt(f.variance))[:, None], 0
        for force, side in zip((True, False), sides, strict=True):
            columns = np.hstack(side) if side else np.empty((0, 0))
            for first in range(0, columns.shape[1], TOGETHER):
                some = columns[:, first : first + TOGETHER]
                size = np.max(np.abs(some), axis=0) + 1e-300
                if force:
                    there, probe = problem.varied(theta, f, k, forcing=PROBE_M_S2 * some / size), PROBE_M_S2
                else:
                    error = scaled(run, some)
                    there = problem.varied(theta, f, k, value=run.value[:, None] - PROBE_M * error / size)
                    probe = PROBE_M
                np.multiply(there - base, size / probe, out=out[:, done : (done := done + some.shape[1])])
        return out

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(of, range(len(problem.runs))))
