"""Identification: the paper's estimators and the maximum-likelihood one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .cramer_rao import cramer_rao, rounded_variance
    from .first_guess import first_guesses
    from .innovations import innovations
    from .maximum_likelihood import MODELS, NORMAL95, Estimate, beforehand, fit, identify, refit
    from .observed import RANGE, SPEED, Observed, observe
    from .optimum import descend
    from .problem import Filtered, Noise, Problem
    from .process_noise import noise_level
    from .residuals import ResidualStatistics, free_run_beside, residual_coherence, residual_statistics

__all__ = facade(__name__)
