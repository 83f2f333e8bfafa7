"""The paper's identification from end to end: records in, Models I, II and III out, with everything its tables show.

range to the wall -> three-state filter -> u = -(its velocity);   propeller speed -> the same filter -> n
u, n at the regression step -> z = h C -> Kalman estimator, two-stage estimator or least squares -> a, b, gamma, tau
-> free run from n -> residual mean, deviation, mean absolute value, coherence; cross-validation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...plant.lumped import Lumped, to_feet
from ...units import FOOT_M
from ..residuals import (
    ResidualStatistics,
    free_run_beside,
    residual_coherence,
    residual_statistics,
)
from .kalman import Evolution, kalman, kalman_compiled, scales
from .least_squares import least_squares
from .regression import Array, Model, Regression, lump_all, recover, regression, unstable
from .settings import PaperSettings
from .signals import Signals, run_signals
from .two_stage import second_stage

if TYPE_CHECKING:
    from ...record.run import Run


@dataclass(frozen=True)
class PaperEstimate:
    """One model identified from one record."""

    model: Model
    signals: Signals
    rows: Regression
    evolution: Evolution  # of C, in the paper's feet; a single row for least squares
    parameters: Lumped
    simulated_m_s: Array  # (K,) free run; NaN once diverged
    statistics: ResidualStatistics  # [m/s]

    @property
    def feet(self) -> tuple[float, float, float, float]:
        """a [1/ft], b [ft/rev2], gamma [1/rev], tau [s] as in the paper's tables."""
        return to_feet(self.parameters)

    @property
    def unstable(self) -> tuple[str, ...]:
        """Parameters that would carry the paper's asterisk, at the regression step."""
        return unstable(self.parameters, self.signals.step_s)

    @property
    def diverged(self) -> bool:
        """Whether the free run on the model's own record was given up; an unstable model may not get that far."""
        return not bool(np.isfinite(self.simulated_m_s).all())

    @property
    def residuals_m_s(self) -> Array:
        """e = measured - simulated, shape (K,)."""
        return self.signals.u_m_s - self.simulated_m_s

    @property
    def coherence(self) -> tuple[Array, Array]:
        """Frequency [rad/s] and coherence between u and e, of one shape; empty if diverged."""
        if self.diverged:
            return np.empty(0), np.empty(0)
        return residual_coherence(self.signals.u_m_s, self.residuals_m_s, self.signals.step_s)

    @property
    def statistics_ft_s(self) -> ResidualStatistics:
        """Mean, deviation, mean absolute value [ft/s] as in the paper's tables."""
        s = self.statistics
        return ResidualStatistics(s.mean / FOOT_M, s.deviation / FOOT_M, s.mean_absolute / FOOT_M)

    @property
    def parameter_evolution(self) -> Array:
        """alpha [1/m], beta [m/rev2], gamma [1/rev], tau [s] after each step, shape (rows, 4)."""
        return lump_all(self.evolution.c, self.signals.step_s, self.model)


def identify_signals(signals: Signals, model: Model, settings: PaperSettings) -> PaperEstimate:
    """Estimate one model, run it free on the same record and describe the residuals."""
    rows = regression(signals.u_m_s, signals.n_rev_s, signals.step_s, model)
    evolution = estimate(rows, settings)
    parameters = recover(evolution.final, signals.step_s, model)
    simulated = free_run_beside(signals.u_m_s, signals.n_rev_s, signals.step_s, parameters)
    statistics = residual_statistics(signals.u_m_s, simulated)
    return PaperEstimate(model, signals, rows, evolution, parameters, simulated, statistics)


def identify_run(run: Run, model: Model, settings: PaperSettings) -> PaperEstimate:
    """The paper's method on a run. InputError if it is too short or lacks a channel."""
    if run.input == "thrust_N" and model == "III":
        raise InputError(f"run {run.name}: model III needs a propeller speed for its thrust loss, the run has thrust_N")
    return identify_signals(run_signals(run, settings), model, settings)


def cross_validation(parameters: Sequence[Lumped], records: Sequence[Signals]) -> list[list[ResidualStatistics]]:
    """Row i, column j: free run of parameter set i on record j, residual statistics [m/s].

    The paper shows its first row, parameters of data set 1, in Figures 9 to 11.
    """
    return [
        [residual_statistics(s.u_m_s, free_run_beside(s.u_m_s, s.n_rev_s, s.step_s, p)) for s in records]
        for p in parameters
    ]


def estimate(rows: Regression, settings: PaperSettings) -> Evolution:
    """Coefficients C of a regression by the estimator that the settings name."""
    if settings.estimator == "least_squares":
        return least_squares(rows)
    run_estimator = kalman_compiled if settings.compiled else kalman
    unit, output = scales(rows, settings.scaling)
    r = settings.r * output**2
    start, covariance = np.zeros(unit.size), np.diag(settings.initial_variance * unit**2)
    first = run_estimator(rows.z, rows.h, settings.q_ii(rows.model) * unit**2, r, start, covariance)
    if settings.estimator == "kalman":
        return first
    return second_stage(rows, first, settings.q_second_stage * unit**2, r, run_estimator)
