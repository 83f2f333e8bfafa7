"""Heavy tails: Student's t as a normal error whose variance differs from measurement to measurement.

A measurement that lies far off is given a larger variance, and the fit is repeated, until both agree: expectation and
maximisation for the t (Lange, Little, Taylor, J. American Statistical Association 84, 1989). Its degrees of freedom are
the likeliest. Nothing is done where the residuals have no more outliers than normal ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from .problem import Filtered, Problem, student

SUSPICIOUS = 5.0  # deviations of a normal sample's kurtosis from which tails are looked at; a choice
FREEDOM = (1.0, 50.0)  # degrees of freedom that are told from lone freaks and from a normal; choices


def standardised(problem: Problem, filtered: Sequence[Filtered]) -> np.ndarray:
    """Innovations that count, over the deviations that they would have without weights, shape (N,)."""
    parts = enumerate(filtered)
    return np.concatenate([(f.innovation / np.sqrt(problem.unweighted(k, f)))[problem.used(k)] for k, f in parts])


@np.errstate(over="ignore", invalid="ignore")  # beyond all numbers no tails are told
def heavy(residual: np.ndarray) -> bool:
    """Whether residuals, shape (N,), have more outliers than normal ones: by their fourth moment."""
    square = residual**2
    kurtosis = float(np.mean(square**2) / max(float(np.mean(square)) ** 2, 1e-300))
    return (kurtosis - 3.0) * float(np.sqrt(residual.size / 24.0)) > SUSPICIOUS


def likeliest_freedom(residual: np.ndarray) -> tuple[float, float]:
    """Degrees of freedom and scale of the likeliest Student's t of residuals, shape (N,)."""

    def scale(freedom: float) -> float:
        square, s = residual**2, float(np.median(residual**2))
        for _ in range(20):
            s = float(np.mean(square * (freedom + 1.0) / (freedom + square / s)))
        return float(np.sqrt(s))

    def cost(log: float) -> float:
        s = scale(float(np.exp(log)))
        return residual.size * float(np.log(s)) - student(residual / s, float(np.exp(log)))

    best = float(np.exp(minimize_scalar(cost, bounds=np.log(FREEDOM), options={"xatol": 0.05}).x))
    return best, scale(best)


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def information(residual: np.ndarray, freedom: float) -> float:
    """Information that residuals over their scales, shape (N,), hold of their centre, over that of the weights' sum.

    As they are themselves, whether or not they follow the t (Huber, Robust Statistics, 1981, ch. 7): less than one,
    since weights that answer to a residual take part of it back.
    """
    pull = (freedom + 1.0) / (freedom + residual**2)
    slope = pull * (freedom - residual**2) / (freedom + residual**2)
    return float(np.mean(slope) ** 2 / (np.mean((pull * residual) ** 2) * np.mean(pull)))


def reweighted(problem: Problem, filtered: Sequence[Filtered]) -> Problem:
    """The problem with the likeliest degrees of freedom and scale of its white error, and the weights they imply."""
    freedom, scale = likeliest_freedom(standardised(problem, filtered))
    noise = replace(problem.noise, freedom=freedom, variance=tuple(v * scale**2 for v in problem.noise.variance))
    weight = []
    for k, f in enumerate(filtered):
        square = f.innovation**2 / (problem.unweighted(k, f) * scale**2)
        weight.append((freedom + square) / (freedom + 1.0))
    return replace(problem, noise=noise, weight=tuple(weight))
