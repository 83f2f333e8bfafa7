"""One model identified from a data set by every method: likelihood, the paper's estimators, the linear model.

The likelihood takes all runs together, and each run alone for comparison; the paper's methods take a run each, as the
paper does. What cannot be done is a sentence in place of a result.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..record.run import Run
from .maximum_likelihood import Estimate, identify, refit
from .observed import CHANNELS, Observed, observe, stretches
from .paper.estimate import PaperEstimate, identify_run
from .paper.linear import LinearModel, fit_linear
from .paper.regression import Array, Model
from .paper.settings import ESTIMATORS, Estimator, PaperSettings
from .paper.signals import Signals, run_signals
from .problem import Problem
from .residuals import ResidualStatistics, residual_coherence, residual_statistics, whiteness

MOTION = 0.01  # [-] spectral density of the speed over its peak, below which a frequency does not count; a choice
FEWEST = 60  # samples from which coherence and whiteness are looked at; a choice


@dataclass(frozen=True)
class RunResiduals:
    """What the joint estimate leaves of one channel of one run.

    Attributes:
        run, channel: names.
        samples: how many.
        free_run: measured less simulated from the input and the estimated start alone [m or m/s].
        innovation_rms: measured less predicted from the measurements before [m or m/s].
        whiteness_p: chance of so much correlation in white innovations (Ljung-Box); NaN for short runs.
        coherence, coherence_rad_s: highest value between simulated speed and free-run residual, and where; or NaN.
    """

    run: str
    channel: str
    samples: int
    free_run: ResidualStatistics
    innovation_rms: float
    whiteness_p: float
    coherence: float
    coherence_rad_s: float


@dataclass(frozen=True)
class Linear:
    """The paper's linear model (23) of a run, and its free run's residuals [m/s]."""

    model: LinearModel
    statistics: ResidualStatistics


@dataclass(frozen=True)
class Comparison:
    """Everything found for one model.

    Attributes:
        model: "I", "II" or "III".
        runs: the runs as observed.
        joint: likelihood of all runs together.
        simulated: the same without process noise, least squares on the simulated output.
        single: likelihood of each run alone by name, at the joint noise level.
        on_speed: by run, free-run residual of `single` on the speed that the paper's methods see [m/s].
        paper: by method and run.
        linear: by run.
        residuals: of the joint estimate.
        validation: free-run rms of the first channel [m or m/s], shape (R + 2, R): rows are the parameters of each run
            alone, of all by simulation and of all together, columns the runs.
    """

    model: Model
    runs: tuple[Observed, ...]
    joint: Estimate
    simulated: Estimate
    single: dict[str, Estimate]
    on_speed: dict[str, ResidualStatistics | None]
    paper: dict[Estimator, dict[str, PaperEstimate | str]]
    linear: dict[str, Linear | str]
    residuals: tuple[RunResiduals, ...]
    validation: Array


def compare(
    recorded: Sequence[Run],
    model: Model,
    estimators: Sequence[Estimator] = ESTIMATORS,
    process_noise: bool | None = None,
    advance: Callable[[str], None] = lambda note: None,
) -> Comparison:
    """Identify one model by likelihood and by the paper's estimators; `advance` is called per run and once."""
    recorded = stretches(recorded)
    runs = tuple(observe(run) for run in recorded)
    joint = identify(runs, model, process_noise=process_noise)
    calm = joint.problem.noise.quiet
    simulated = joint if calm else identify(runs, model, process_noise=False)
    single: dict[str, Estimate] = {}
    paper: dict[Estimator, dict[str, PaperEstimate | str]] = {estimator: {} for estimator in estimators}
    for k, run in enumerate(recorded):
        alone = joint.problem.alone(k)
        single[run.name] = refit(alone, alone.initial(joint.vector()))
        for estimator, found in paper.items():
            found[run.name] = _paper(run, model, estimator)
        advance(f"Model {model}, {run.name}")
    speeds = {run.name: _seen(run) for run in recorded if estimators}
    linear = {name: seen if isinstance(seen, str) else _linear(seen) for name, seen in speeds.items()}
    on_speed = {n: None if isinstance(seen, str) else _on_speed(seen, single[n]) for n, seen in speeds.items()}
    table = validation([*single.values(), simulated, joint], runs)
    advance(f"Model {model}, validation")
    return Comparison(
        model, runs, joint, simulated, single, on_speed, paper, linear,
        residuals=tuple(_residuals(joint)), validation=table,
    )  # fmt: skip


def compare_all(
    recorded: Sequence[Run],
    models: Sequence[Model],
    paper: bool = True,
    process_noise: bool | None = None,
    advance: Callable[[str], None] = lambda note: None,
) -> tuple[list[Comparison], list[str]]:
    """The models that these runs can carry, and for the others a sentence why not; InputError where none can.

    paper: by the paper's estimators besides.
    """
    found: list[Comparison] = []
    skipped: list[str] = []
    for model in models:
        try:
            found.append(compare(recorded, model, ESTIMATORS if paper else (), process_noise, advance))
        except InputError as error:
            skipped.append(f"Model {model} skipped: {error}")
    if not found:
        raise InputError(skipped[0])
    return found, skipped


def _paper(run: Run, model: Model, estimator: Estimator) -> PaperEstimate | str:
    try:
        return identify_run(run, model, PaperSettings(estimator=estimator))
    except InputError as error:
        return str(error)


def _seen(run: Run) -> Signals | str:
    try:
        return run_signals(run, PaperSettings())
    except InputError as error:
        return str(error)


def _linear(seen: Signals) -> Linear:
    model = fit_linear(seen.u_m_s, seen.n_rev_s, seen.step_s)
    return Linear(model, residual_statistics(seen.u_m_s, model.free_run(seen.n_rev_s, seen.u_m_s)))


def _on_speed(seen: Signals, estimate: Estimate) -> ResidualStatistics:
    """Like the residuals in the paper's tables: speed by its filter less the free run's."""
    observed, track = estimate.problem.runs[0], estimate.free_tracks()[0]
    simulated = np.interp(seen.time_s, observed.time_s - observed.time_s[0], track[:, 1])
    return residual_statistics(seen.u_m_s, simulated)


def _residuals(joint: Estimate) -> list[RunResiduals]:
    out = []
    parts = zip(joint.problem.runs, joint.filtered, joint.free_runs(), joint.free_tracks(), strict=True)
    for run, filtered, free, track in parts:
        for channel, kind in CHANNELS.items():
            chosen = run.kind == kind
            if chosen.any():
                step = float(np.median(np.diff(run.time_s[chosen])))
                seen = free.innovation[chosen], filtered.innovation[chosen], track[chosen, 1]
                out.append(_channel_residuals(run.name, channel, step, *seen))
    return out


def _channel_residuals(
    run: str, channel: str, step_s: float, free: Array, innovation: Array, speed: Array
) -> RunResiduals:
    white, peak, where = np.nan, np.nan, np.nan
    if free.size >= FEWEST:
        white = whiteness(innovation)
        peak, where = coherence_peak(speed, free, step_s)
    rms = float(np.sqrt(np.mean(innovation**2)))
    return RunResiduals(run, channel, free.size, residual_statistics(free, 0.0 * free), rms, white, peak, where)


def coherence_peak(speed: Array, residual: Array, step_s: float) -> tuple[float, float]:
    """Highest coherence between speed and residual, shapes (K,), and its frequency [rad/s].

    Only where there is motion to speak of: beyond it a pilot on the sonar makes the hull follow the sonar's noise.
    """
    from scipy.signal import welch

    frequency, coherence = residual_coherence(speed, residual, step_s)
    _, power = welch(speed, fs=1.0 / step_s, nperseg=2 * frequency.size - 2)
    moving = power[: frequency.size] > MOTION * power[1:].max()
    moving[0] = False
    best = int(np.argmax(np.where(moving, coherence, -1.0)))
    return float(coherence[best]), float(frequency[best])


def validation(estimates: Sequence[Estimate], runs: Sequence[Observed]) -> Array:
    """Free-run rms of every run (columns) under the parameters of every estimate (rows)."""
    return np.array([[free_run_rms(estimate, run) for run in runs] for estimate in estimates])


def free_run_rms(estimate: Estimate, run: Observed) -> float:
    """Rms [m or m/s] that the estimate's parameters leave of the first channel of a run; only its start is fitted."""
    problem = Problem((run,), estimate.vector(), (), estimate.problem.per_run)
    return refit(problem, problem.initial()).rms(min(run.first))
