"""Predictions and innovations along a run: pure simulation, given Kalman gains, and the filter that finds them.

Everything that compiled kernels need of a run is laid out here, so that the rest deals in runs, parameters and noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..lanes import WIDTH
from .kernels import Steps, kernels
from .observed import CHANNELS, Observed

KEPT = 8  # step plans kept per run: one for every combination of delays that a fit tries at a time


@dataclass(frozen=True)
class Noise:
    """Noise shared by all runs: variance of the white error of each channel [unit squared], and the disturbance.

    sigma [m/s2] and correlation_time [s] are the stationary deviation and the memory of the disturbing acceleration
    (turbulence, wake); colour_sigma [m] and colour_time [s] are those of a coloured error of the sonar beside the white
    one. Both zero is white measurement noise, the output-error case. freedom: degrees of freedom of Student's t, as
    which the white error is distributed; inf is normal.
    """

    variance: tuple[float, ...] = (1e-4,) * len(CHANNELS)
    sigma: float = 0.0
    correlation_time: float = 1.0
    colour_sigma: float = 0.0
    colour_time: float = 1.0
    freedom: float = np.inf

    def calm(self) -> Noise:
        """The same white measurement noise alone."""
        return replace(self, sigma=0.0, colour_sigma=0.0)

    @property
    def quiet(self) -> bool:
        """Whether the innovations are those of pure simulation: white measurement noise and nothing else."""
        return self.sigma == 0.0 and self.colour_sigma == 0.0

    @property
    def memory(self) -> np.ndarray:
        """Memory of the disturbance and of the coloured error [s], shape (2,)."""
        return np.array([self.correlation_time, self.colour_time])


@dataclass(frozen=True)
class Filtered:
    """Innovations, their variances and the gains of one run, shapes (M,), (M,) and (M, S + A + 1)."""

    innovation: np.ndarray
    variance: np.ndarray
    gain: np.ndarray


def no_gain(run: Observed) -> np.ndarray:
    """Gains of pure simulation, shape (M, S + A + 1)."""
    return np.zeros((run.time_s.size, run.plant.size + 1))


def steps(run: Observed, p: np.ndarray) -> Steps:
    """The steps of a run at parameters p, shape (P,), which matter only where they shift instants."""
    shift = tuple(p[run.plant.parameters.slots(run.plant.shifting)].tolist())
    plan = run.plans.get(shift)  # another thread may drop it meanwhile
    if plan is None:
        if len(run.plans) >= KEPT:
            run.plans.clear()
        plan = run.plans[shift] = kernels(run.plant).plan(run.record, p)
    return plan


def innovations(
    run: Observed,
    p: np.ndarray,
    start: np.ndarray,
    noise: Noise,
    gain: np.ndarray,
    value: np.ndarray | None = None,
    forcing: np.ndarray | None = None,
    track: np.ndarray | None = None,
) -> np.ndarray:
    """Measured less predicted with given gains, for one model or for L of them, shape (M,) or (M, L).

    Args:
        run: the run.
        p: parameters, shape (P,) or (P, L).
        start: states at the first measurement, shape (S,) or (S, L).
        noise: for the memory of its coloured parts.
        gain: shape (M, S + A + 1); zeros for pure simulation (`no_gain`).
        value: measurements in place of the run's, shape (M,) or (M, L).
        forcing: known acceleration on the first axis, held like the input [m/s2], shape (I,) or (I, L).
        track: where given, shape (M, S + A), the states of the first model at each measurement are written into it.
    """
    value = run.value if value is None else value
    count = max((a.shape[1] for a in (p, start, value, forcing) if a is not None and a.ndim == 2), default=0)
    P, S = (a if a.ndim == 2 else np.repeat(a[:, None], max(count, 1), axis=1) for a in (p, start))
    groups, out = _alike(run, P), np.empty((run.time_s.size, P.shape[1]))
    for lanes, shared in groups:
        for first in range(0, lanes.size, WIDTH):
            block = lanes[first : first + WIDTH]
            given = (a if a is None or a.ndim == 1 else _filled(a, block) for a in (value, forcing))
            found = np.empty((run.time_s.size, WIDTH))
            kernels(run.plant).simulate(
                _filled(P, block), _filled(S, block), shared, run.record, *given, gain, noise.memory, found,
                track if block[0] == 0 else None,
            )  # fmt: skip
            if block.size == P.shape[1]:
                return found[:, :count] if count else found[:, 0]
            out[:, block] = found[:, : block.size]
    return out


def simulated(run: Observed, p: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Measured less simulated from parameters and initial states alone, shapes as for `innovations`."""
    return innovations(run, p, start, Noise(), no_gain(run))


def _simulated_once(run: Observed, p: np.ndarray, start: np.ndarray, forcing: np.ndarray | None) -> np.ndarray:
    """The same, shape (M,), read-only: kept until another is worked out, since an optimum's is asked for repeatedly."""
    found = run.residuals.get(_asked(p, start, forcing))  # another thread may drop it meanwhile
    if found is None:
        found = keep(run, p, start, forcing, innovations(run, p, start, Noise(), no_gain(run), forcing=forcing))
    return found


def keep(run: Observed, p: np.ndarray, start: np.ndarray, forcing: np.ndarray | None, found: np.ndarray) -> np.ndarray:
    """Errors of a pure simulation, shape (M,), read-only, kept in the place of the one before."""
    found = found.copy()
    found.flags.writeable = False
    run.residuals.clear()
    run.residuals[_asked(p, start, forcing)] = found
    return found


def _asked(p: np.ndarray, start: np.ndarray, forcing: np.ndarray | None) -> tuple[bytes | None, ...]:
    return p.tobytes(), start.tobytes(), None if forcing is None else forcing.tobytes()


def _filled(a: np.ndarray, lanes: np.ndarray) -> np.ndarray:
    """Those columns of an array, shape (N, L), filled up to WIDTH by the last one."""
    return np.take(a, lanes[np.minimum(np.arange(WIDTH), lanes.size - 1)], axis=1)


def _alike(run: Observed, p: np.ndarray) -> list[tuple[np.ndarray, Steps]]:
    """Lanes that share their instants, and the steps they share."""
    shift = p[run.plant.parameters.slots(run.plant.shifting)]
    if np.all(shift == shift[:, :1]):
        return [(np.arange(p.shape[1]), steps(run, p[:, 0]))]
    groups: dict[tuple[float, ...], list[int]] = {}
    for lane in range(p.shape[1]):
        groups.setdefault(tuple(shift[:, lane].tolist()), []).append(lane)
    return [(np.array(lanes), steps(run, p[:, lanes[0]])) for lanes in groups.values()]


def filtered(
    run: Observed,
    p: np.ndarray,
    start: np.ndarray,
    noise: Noise,
    variance: np.ndarray,
    start_sd: np.ndarray | None = None,
    forcing: np.ndarray | None = None,
) -> Filtered:
    """Extended Kalman filter along a run, or pure simulation where the noise is quiet and the start is certain.

    Args:
        run: the run.
        p: parameters, shape (P,).
        start: states at the first measurement, shape (S,).
        noise: disturbance and coloured error.
        variance: of each measurement's white error, shape (M,); inf skips it.
        start_sd: standard deviations of the start, shape (S,); certain by default.
        forcing: see `innovations`.
    """
    gain = no_gain(run)
    if noise.quiet and start_sd is None:
        return Filtered(_simulated_once(run, p, start, forcing), variance, gain)
    size = run.time_s.size
    found = Filtered(np.empty(size), np.empty(size), gain)
    kernels(run.plant).kalman(
        np.repeat(p[:, None], WIDTH, axis=1), start, np.zeros(start.size) if start_sd is None else start_sd,
        steps(run, p), run.record,
        forcing, variance, np.full(len(run.plant.axes), run.loud * noise.sigma), noise.memory, noise.colour_sigma,
        found.innovation, found.variance, gain,
    )  # fmt: skip
    return found
