"""Everything the paper's method depends on; what the paper leaves unsaid has a guess as default, which says so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .kalman import Scaling
from .regression import Model

Estimator = Literal["kalman", "two_stage", "least_squares"]
ESTIMATORS: tuple[Estimator, ...] = ("kalman", "two_stage", "least_squares")


@dataclass(frozen=True)
class PaperSettings:
    """The paper's numbers, and guesses where it gives none."""

    estimator: Estimator = "kalman"
    q_model_i: float = 1.0  # q_ii, Table 1
    q_model_ii: float = 1.0  # q_ii, Table 2
    q_model_iii: float = 3.0  # q_ii, Table 3
    q_second_stage: float = 0.0032  # q_ii, Table 4; the print has 0.0032, 0.0032, 0.005 for three of its four sets
    r: float = 0.01  # R, section V
    scaling: Scaling = (
        "literal"  # units of q_ii and R; "normalised" settles at q_ii of 1e-4 to 1e-6, "literal" not at 1
    )
    initial_variance: float = 1.0  # P before the first step is this times I; guess
    filter_q_ft2_s5: float = 1.0  # guess: the "almost unitary gain" of section IV needs about this or more
    filter_r_ft2: float = 0.01  # section V: R is "the same value used by the sonar filter"
    filter_propeller: bool = True  # section IV: "the filter was also applied to the propeller speeds"
    regression_step_s: float = 0.5  # T of (6)-(7); guess: the paper does not give it, and a and tau hang on it
    settle_s: float = 2.0  # dropped while the filter settles; guess
    compiled: bool = False  # the numba twins in place of filterpy: the same within rounding, for Monte Carlo

    def q_ii(self, model: Model) -> float:
        """Diagonal of Q for a model's first stage."""
        return {"I": self.q_model_i, "II": self.q_model_ii, "III": self.q_model_iii}[model]
