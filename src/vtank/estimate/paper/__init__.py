"""The paper's own estimators: regression on filtered signals, two-stage and Kalman forms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .estimate import PaperEstimate, cross_validation, estimate, identify_signals
    from .linear import fit_linear
    from .regression import MODELS, Array, Model, Regression, lump_all, regression
    from .settings import ESTIMATORS, Estimator, PaperSettings
    from .signals import Signals, decimated, run_signals
    from .sonar_filter import sonar_filter_compiled

__all__ = facade(__name__)
