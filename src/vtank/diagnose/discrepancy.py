"""None of these: what a discrepancy without a name would have to look like, and how well it explains the rest.

Families of unnamed discrepancies are laid on top of the best named explanation: an unknown force (smooth functions of
speed, propeller speed, place and time; lines at multiples of each run's drive frequency), an unknown smooth error of
the sensor, and outliers on one side. Where one of them gains evidence, the named explanation leaves something out.
Each family is a Gaussian process of few degrees of freedom, so that its evidence is closed form: the innovations are
linear in the coefficients, whose common size is integrated over a grid. Brynjarsdottir, O'Hagan, Inverse Problems 30
(2014), on what such a discrepancy can mean.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag
from scipy.ndimage import uniform_filter1d

from ..estimate.observed import SPEED, Observed
from ..estimate.problem import Filtered, Problem
from . import outliers
from .evidence import Fitted, Setting
from .holdout import held
from .hypothesis import largest_input
from .score import Linearised, linearise

WANDERS = 12  # frequencies from 0.05 to 1.5 rad/s at which the thrust gain may wander; a choice
HARMONICS = (2, 3, 4, 5)  # multiples of the drive frequency at which a force line is looked for
EVENED = 21  # samples over which speed is averaged, twice, before its rate is taken: noise of the tachometer shakes the
# simulated hull, not the true one, and would make any error of the range look like one that follows the acceleration
TAKEN_UP = 1e-4  # share of a function's square that must survive the refit; less is rounding of the derivatives
UNHEARD = -50.0  # log evidence of a family that cannot be weighed, since the model runs away when pushed: next to none
PROBES = (1e-4, 1e-3)  # of the finite differences in a force and in a sensor error, small enough to be linear
BEYOND = 1e12  # [-] change of an innovation, in deviations, that only a model running away shows
SIZES = tuple(np.logspace(-2.0, 1.0, 7))  # coefficient size over the size that would just be seen; a grid


@dataclass(frozen=True)
class Discrepancy:
    """An unnamed discrepancy of one family.

    Attributes:
        channel: "hydrodynamics" (a force), "sensor" (an error of range or tachometer).
        family: which functions it is made of.
        gain: log evidence over that of the named explanation alone.
        fitted: the discrepancy that explains most, per run, over the input stamps [m/s2] or measurements [m or m/s].
    """

    channel: str
    family: str
    gain: float
    fitted: tuple[np.ndarray, ...] = ()


def unnamed(setting: Setting, named: Fitted) -> list[Discrepancy]:
    """Gain of every family of unnamed discrepancies on top of a fitted hypothesis."""
    near, runs, top = linearise(named), setting.runs, largest_input(setting.runs)
    tracks = list(zip(runs, simulated_tracks(named.problem, named.optimum.theta), strict=True))
    families = [
        ("hydrodynamics", "smooth force", [_force_shapes(run, top, track) for run, track in tracks]),
        ("hydrodynamics", "force lines", [_force_lines(run) for run in runs]),
        ("actuator", "wandering thrust", [_thrust_lines(run, top) for run in runs]),
        ("sensor", "smooth error", [_sensor_shapes(run, track) for run, track in tracks]),
    ]
    out = []
    for channel, family, basis in families:
        changes, shared = _changes(named, basis, channel), family.startswith("smooth")
        gain, found = _evidence(near, np.vstack(changes) if shared else block_diag(*changes))
        own = [found] * len(basis) if shared else np.split(found, len(basis))
        fitted = tuple(functions @ part for functions, part in zip(basis, own, strict=True))
        out.append(Discrepancy(channel, family, gain, fitted))
    return [*out, _outliers(setting, named), _lone_speeds(named, near)]


def simulated(problem: Problem, theta: np.ndarray) -> list[Filtered]:
    """Pure simulation at theta: functions of the filtered state would carry the sonar's noise and explain it."""
    return [replace(f, innovation=held(f.innovation)) for f in problem.simulate(theta)]


def simulated_tracks(problem: Problem, theta: np.ndarray) -> list[np.ndarray]:
    """States at the measurements in the same simulation, shapes (M, 5)."""
    return [held(track) for track in problem.track(theta, simulated(problem, theta))]


def _evidence(near: Linearised, columns: np.ndarray) -> tuple[float, np.ndarray]:
    """Log Bayes factor of Gaussian coefficients on `columns` (sum M, K) against none, and the best coefficients."""
    if not np.all(np.abs(columns) < BEYOND):
        return UNHEARD, np.zeros(columns.shape[1])
    rest = near.remaining(columns)
    A, b = columns.T @ rest, -rest.T @ near.residual
    kept = np.diag(A) > TAKEN_UP * np.sum(columns**2, axis=0)
    scale = np.sqrt(np.diag(A)[kept])
    values, vectors = np.linalg.eigh(A[np.ix_(kept, kept)] / np.outer(scale, scale))
    values, projected = np.maximum(values, 0.0), vectors.T @ (b[kept] / scale)
    gains = []
    for size in (10.0 * s for s in SIZES):
        shrink = size**2 / (1.0 + size**2 * values)
        gains.append(0.5 * float(np.sum(projected**2 * shrink) - np.sum(np.log1p(size**2 * values))))
    best = 10.0 * SIZES[int(np.argmax(gains))]
    coefficients = np.zeros(columns.shape[1])
    coefficients[kept] = vectors @ (projected * best**2 / (1.0 + best**2 * values)) / scale
    gain = float(np.logaddexp.reduce(gains) - np.log(len(gains)))
    return gain if np.isfinite(gain) else UNHEARD, coefficients


def _changes(named: Fitted, basis: list[np.ndarray], channel: str) -> list[np.ndarray]:
    """Change of all whitened innovations per unit of each force or sensor error, per run, shape (M, K)."""
    problem, theta, out = named.problem, named.optimum.theta, []
    for k, (run, f, functions) in enumerate(zip(problem.runs, named.filtered, basis, strict=True)):
        base, size = (f.innovation / np.sqrt(f.variance))[:, None], PROBES[channel == "sensor"]
        if channel == "sensor":
            there = problem.varied(theta, f, k, value=run.value[:, None] - size * functions)
        else:
            there = problem.varied(theta, f, k, forcing=size * functions)
        out.append((there - base) / size)
    return out


def _force_shapes(run: Observed, top: float, track: np.ndarray) -> np.ndarray:
    """Smooth force functions at a run's input stamps, each of unit size over all runs, shape (I, K)."""
    t = run.input_time_s
    x, u, z = (np.interp(t, run.time_s, track[:, i]) for i in (0, 1, 2))
    a = _rate(t, u)
    n = run.input / top
    slow, late = _smooth(t, u, 4.0), _smooth(t, u, 15.0)
    s, v = t / 60.0, u / 0.3  # [-] time and speed over typical sizes
    columns = [np.ones_like(t), v, v * np.abs(v), v**3, np.tanh(u / 0.02), v**2, x, x * v * np.abs(v), x * x,
               n, n * np.abs(n), n**3, n**2, n * np.abs(v), v * np.abs(n), s * v * np.abs(v), s * n * np.abs(n), s,
               slow / 0.3, late / 0.3, z / 0.1, a * v * v / 0.1, a * x / 0.1]  # fmt: skip
    return 1e-2 * np.column_stack(columns)


def _rate(t: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Acceleration behind an evened speed [m/s2]."""
    even = uniform_filter1d(uniform_filter1d(u, EVENED), EVENED)
    return np.asarray(np.gradient(even, t, edge_order=1)) if np.all(np.diff(t) > 0) else np.zeros_like(u)


def _smooth(t: np.ndarray, values: np.ndarray, constant: float) -> np.ndarray:
    """First-order low-pass of `values` with the given time constant [s]."""
    out = np.empty_like(values)
    state = 0.0
    steps = np.diff(t, append=t[-1])
    for i, value in enumerate(values):
        out[i] = state
        state += (value - state) * min(steps[i] / constant, 1.0)
    return out


def drive_frequency(time: np.ndarray, values: np.ndarray) -> float:
    """Frequency [rad/s] at which a run's input is strongest, from its periodogram on an even grid."""
    grid = np.linspace(time[0], time[-1], time.size)
    even = np.interp(grid, time, values - np.mean(values))
    spectrum = np.abs(np.fft.rfft(even * np.hanning(even.size), 8 * even.size)) ** 2
    frequency = 2.0 * np.pi * np.fft.rfftfreq(8 * even.size, grid[1] - grid[0])
    inside = frequency < 5.0
    return float(frequency[inside][int(np.argmax(spectrum[inside]))])


def _force_lines(run: Observed) -> np.ndarray:
    """Sines and cosines at multiples of the drive frequency and on a coarse grid, shape (I, K)."""
    drive = drive_frequency(run.input_time_s, run.input)
    return _waves(run, np.concatenate([np.multiply(HARMONICS, drive), np.geomspace(0.1, 2.5, 14)]))


def _thrust_lines(run: Observed, top: float) -> np.ndarray:
    """Thrust times sines and cosines on a coarse grid, shape (I, K): a thrust gain that wanders."""
    n = run.input / top
    return (n * np.abs(n))[:, None] * _waves(run, np.geomspace(0.05, 1.5, WANDERS))


def _waves(run: Observed, rad_s: np.ndarray) -> np.ndarray:
    """Sines and cosines at a run's input stamps, shape (I, K)."""
    phases = np.outer(run.input_time_s - run.input_time_s[0], rad_s)
    return 1e-2 * np.hstack([np.sin(phases), np.cos(phases)])


def _sensor_shapes(run: Observed, track: np.ndarray) -> np.ndarray:
    """Smooth sensor errors at a run's measurements, shape (M, K); errors of position read the other way as a range."""
    t, x, u = run.time_s, track[:, 0], track[:, 1]
    a = _rate(t, u)
    s, v = t / 60.0, u / 0.3
    columns = [v, v * np.abs(v), v**2, a / 0.2, x * x, x**3, s, s * s, s * v, np.tanh(u / 0.02), x * v]
    basis = 1e-2 * np.column_stack(columns)
    return np.where((run.kind == SPEED)[:, None], 10.0 * basis, basis)


def _lone_speeds(named: Fitted, near: Linearised) -> Discrepancy:
    """Lone readings of the input, each wrong by some share of what it lies off; nothing beside named spikes."""
    gain, problem = 0.0, named.problem
    if "n_rev_s" not in named.hypothesis.outliers and any(np.any(run.lone) for run in problem.runs):
        runs = tuple(replace(run, input=run.input - run.lone) for run in problem.runs)
        change = replace(problem, runs=runs).residuals(named.optimum.theta, named.filtered) - near.residual
        gain = _evidence(near, change[:, None])[0]
    return Discrepancy("sensor", "lone speeds", gain)


def _outliers(setting: Setting, named: Fitted) -> Discrepancy:
    """Lone ranges that prefer a side, where the named explanation has none."""
    off = np.concatenate([f.innovation[flag] for f, flag in zip(named.filtered, setting.flags, strict=True)])
    late, early = int(np.sum(off > 0.0)), int(np.sum(off < 0.0))
    gain = 0.0 if "range_m" in named.hypothesis.outliers else outliers.one_sidedness(late, early)
    return Discrepancy("sensor", "lone ranges", gain)
