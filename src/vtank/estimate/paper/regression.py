"""The paper's Models I, II and III as linear regressions z = h C, its equations (10) to (13).

From the discrete surge model (6)-(7), with f = u|u|, m = u|n|, p = n|n| and the step T,

    u_{k+2} - 2 u_{k+1} + u_k =  C1 (f_{k+1} - f_k) + C2 (u_k - u_{k+1}) + C3 f_k
                               + C4 p_k + C5 (m_{k+1} - m_k) + C6 m_k              (Model III; II: no C5, C6)
    C1 = T a    C2 = T / tau    C3 = C1 C2    C4 = T^2 b / tau    C5 = T gamma    C6 = C5 C2

    u_{k+1} - u_k = C1 f_k + C2 p_k,    C1 = T a    C2 = T b                           (Model I)

C3 and C6 follow from the others; the estimators leave them free, as the paper does. Misprints of the paper set right:
gamma multiplies u|n| (not n|n|, equations (4) and (6)), and b in (10) stands for b / tau (8).

Arguments and parameters are SI; z, h and C are in the paper's feet, since its q_ii and R are bare numbers in feet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...plant.lumped import Lumped
from ...units import FOOT_M

Array = NDArray[np.float64]
Model = Literal["I", "II", "III"]
MODELS: tuple[Model, ...] = ("I", "II", "III")
COEFFICIENTS: dict[Model, int] = {"I": 2, "II": 4, "III": 6}


@dataclass(frozen=True)
class Regression:
    """z = h C in feet, one row per step; rows that touch a missing sample are NaN."""

    model: Model
    step_s: float
    z: Array  # (K,) [ft/s]
    h: Array  # (K, p)

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Rows without a missing sample, shape (K,)."""
        return np.isfinite(self.z) & np.isfinite(self.h).all(axis=1)


def regression(u_m_s: Array, n_rev_s: Array, step_s: float, model: Model) -> Regression:
    """Regressors of a record of surge speed and propeller speed, both shape (K,), sampled at the step T [s].

    InputError if fewer rows are complete than twice the number of coefficients.
    """
    u = np.asarray(u_m_s, dtype=float) / FOOT_M
    n = np.asarray(n_rev_s, dtype=float)
    f, m, p = u * np.abs(u), u * np.abs(n), n * np.abs(n)
    if model == "I":
        rows = Regression(model, step_s, np.diff(u), np.column_stack([f[:-1], p[:-1]]))
    else:
        lagged = [np.diff(f)[:-1], -np.diff(u)[:-1], f[:-2], p[:-2]]
        loss = [np.diff(m)[:-1], m[:-2]] if model == "III" else []
        rows = Regression(model, step_s, np.diff(u, 2), np.column_stack(lagged + loss))
    if (found := int(rows.complete.sum())) < (needed := 2 * COEFFICIENTS[model]):
        raise InputError(f"model {model} needs at least {needed} steps of {step_s:g} s with u and n, found {found}")
    return rows


def unstable(parameters: Lumped, step_s: float = 0.0) -> tuple[str, ...]:
    """Names of the parameters whose value makes the free model unstable: the paper's asterisk.

    a > 0, tau < 0, and, with a step T [s], a lag too short for (7) to follow: tau < T / 2.
    """
    tau = parameters.tau_s
    wrong = {"a": not parameters.alpha_per_m <= 0.0, "tau": tau != 0.0 and not tau >= step_s / 2.0}
    return tuple(name for name, is_wrong in wrong.items() if is_wrong)


def lump_all(c: Array, step_s: float, model: Model) -> Array:
    """alpha [1/m], beta [m/rev2], gamma [1/rev], tau [s] of coefficients C, shape (..., p) -> (..., 4).

    C3 and C6 are not used, as in the paper. A C2 of zero gives infinite tau and beta.
    """
    c = np.asarray(c, dtype=float)
    zero = np.zeros(c.shape[:-1])
    alpha = c[..., 0] / (step_s * FOOT_M)
    if model == "I":
        return np.stack([alpha, c[..., 1] / step_s * FOOT_M, zero, zero], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        tau = step_s / c[..., 1]
        beta = c[..., 3] / (step_s * c[..., 1]) * FOOT_M
    gamma = c[..., 4] / step_s if model == "III" else zero
    return np.stack([alpha, beta, gamma, tau], axis=-1)


def recover(c: Array, step_s: float, model: Model) -> Lumped:
    """The lumped parameters of one coefficient vector C, shape (p,)."""
    return Lumped(*(float(value) for value in lump_all(c, step_s, model)))
