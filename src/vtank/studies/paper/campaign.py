"""One campaign: the paper's four experiments with one truth, and everything that is identified from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...estimate import Estimate, Observed, ResidualStatistics, identify, observe, residual_statistics
from ...estimate.paper import MODELS, Array, Model, PaperEstimate, PaperSettings, Signals, identify_signals, run_signals
from ...experiment import Result
from ...plant import LUMPED, Lumped, Truth

SCENARIOS = ("paper-ds1", "paper-ds2", "paper-ds3", "paper-ds4")
PIECES = len(MODELS) * (len(SCENARIOS) + 1)  # how often `identify_campaign` tells what it has done

LITERAL = PaperSettings()
SETTLING = replace(  # guess: a Q at which the estimates settle; the second stage's is smaller by the print's own ratio
    LITERAL, scaling="normalised", q_model_i=1e-6, q_model_ii=1e-6, q_model_iii=1e-6, q_second_stage=3.2e-9
)
METHODS: dict[str, PaperSettings] = {
    "kalman": LITERAL,
    "kalman_settling": SETTLING,
    "two_stage": replace(LITERAL, estimator="two_stage"),
    "two_stage_settling": replace(SETTLING, estimator="two_stage"),
    "least_squares": replace(LITERAL, estimator="least_squares"),
}


@dataclass(frozen=True)
class Likelihood:
    """A maximum-likelihood estimate in the terms of the paper's tables.

    sd: of alpha [1/m], beta [m/rev2], gamma [1/rev], tau [s]; zero where the model has no such parameter.
    simulated_m_s: free run at the times of the paper's signals, shape (K,); empty for several runs together.
    """

    parameters: Lumped
    sd: Lumped
    simulated_m_s: Array
    statistics: ResidualStatistics | None


@dataclass(frozen=True)
class Campaign:
    """Four runs and what was identified from them; data sets count from 0 here, from 1 in tables and figures."""

    truth: Truth
    results: tuple[Result, ...]
    paper: dict[tuple[str, Model, int], PaperEstimate]  # by method, model, data set
    likelihood: dict[tuple[Model, int], Likelihood]
    joint: dict[Model, Likelihood]  # all runs together

    def signals(self, data_set: int) -> Signals:
        """What the paper's regressions see of a data set."""
        return self.paper["kalman", "II", data_set].signals

    def true_u_m_s(self, data_set: int) -> Array:
        """True surge speed at the times of the signals, shape (K,) [m/s]."""
        result = self.results[data_set]
        return np.interp(self.signals(data_set).time_s, result.run.time_s, result.true["surge_m_s"])

    def truth_statistics(self, data_set: int) -> ResidualStatistics:
        """What a perfect model would leave of the measured speed: the sonar filter's own error [m/s]."""
        return residual_statistics(self.signals(data_set).u_m_s, self.true_u_m_s(data_set))


def identify_campaign(results: Sequence[Result], advance: Callable[[str], None] = lambda note: None) -> Campaign:
    """Everything the tables and figures need of four results; `advance` is called PIECES times."""
    truth = results[0].plan.truth
    runs = [observe(result.run) for result in results]
    paper: dict[tuple[str, Model, int], PaperEstimate] = {}
    likelihood: dict[tuple[Model, int], Likelihood] = {}
    joint: dict[Model, Likelihood] = {}
    signals = [run_signals(result.run, LITERAL) for result in results]  # the methods differ in what follows only
    for model in MODELS:
        for i, seen in enumerate(signals):
            for method, settings in METHODS.items():
                paper[method, model, i] = identify_signals(seen, model, settings)
            likelihood[model, i] = most_likely([runs[i]], model, seen)
            advance(f"{truth.name}, Model {model}, data set {i + 1}")
        joint[model] = most_likely(runs, model)
        advance(f"{truth.name}, Model {model}, all data sets together")
    return Campaign(truth, tuple(results), paper, likelihood, joint)


def most_likely(runs: Sequence[Observed], model: Model, signals: Signals | None = None) -> Likelihood:
    """Maximum likelihood on one or several runs; with the signals of a single run also its free run."""
    estimate = identify(runs, model)
    values, sd = (Lumped(*(of.get(name, 0.0) for name in LUMPED)) for of in (estimate.values, estimate.sd))
    if signals is None:
        return Likelihood(values, sd, np.empty(0), None)
    simulated = np.interp(signals.time_s, runs[0].time_s - runs[0].time_s[0], _free_run(estimate))
    return Likelihood(values, sd, simulated, residual_statistics(signals.u_m_s, simulated))


def _free_run(estimate: Estimate) -> Array:
    """Surge speed of the first run from the propeller speed and the estimated start alone, shape (M,) [m/s]."""
    undisturbed = estimate.problem.with_noise(replace(estimate.problem.noise, sigma=0.0))
    return undisturbed.track(estimate.theta, undisturbed.filter(estimate.theta))[0][:, 1]
