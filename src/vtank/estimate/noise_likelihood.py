"""Likelihood of a noise level at known parameters, quick enough to search for it.

The surge model is linearised once along its simulation; what the measurements lie off it is then the output of a linear
system with four states, driven by turbulence alone: errors of place [m], speed [m/s], the disturbance [m/s2] and the
coloured error of the sonar [m]. The covariance recursion is that of `innovations.kalman`, without the model in it
(Anderson and Moore, Optimal Filtering, 1979, ch. 8: the linearised filter).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..compiled import law
from ..lanes import WIDTH
from .innovations import Noise, steps
from .kernels import kernels
from .problem import Problem


class Linear(NamedTuple):
    """A run linearised along its simulation, in the order in which its measurements were true.

    Attributes:
        error: measurement less simulation, shape (M,) [m or m/s].
        gap_s: time since the measurement before, shape (M,) [s].
        transition: of place, speed and by a unit acceleration in that time, shape (M, 2, 3).
        row: derivative of the measurement with respect to place, speed and the sonar's error, shape (M, 3).
        kind: channel, shape (M,).
        weight: factor on the variance of the measurement, shape (M,).
        used: whether it counts, shape (M,) of bool.
    """

    error: np.ndarray
    gap_s: np.ndarray
    transition: np.ndarray
    row: np.ndarray
    kind: np.ndarray
    weight: np.ndarray
    used: np.ndarray


def linearised(problem: Problem, theta: np.ndarray) -> list[Linear]:
    """All runs of a problem along their simulations at theta."""
    out = []
    for k, run in enumerate(problem.runs):
        p, start = (np.repeat(part[:, None], WIDTH, axis=1) for part in problem.model(theta, k))
        plan, size = steps(run, p[:, 0]), run.time_s.size
        error, gap, transition, row = np.empty(size), np.empty(size), np.zeros((size, 2, 3)), np.zeros((size, 3))
        kernels(run.plant).linearise(p, start, plan, run.record, error, gap, transition, row)
        weight = np.ones(size) if problem.weight is None else problem.weight[k]
        order = plan.which
        out.append(Linear(error, gap, transition, row, run.kind[order], weight[order], problem.used(k)[order]))
    return out


def squares_and_logs(runs: Sequence[Linear], noise: Noise) -> tuple[float, float, int]:
    """Sum of squared innovations over their variances, sum of the logarithms of these, and the number that counts."""
    squares, logs, count = 0.0, 0.0, 0
    variance = np.array(noise.variance)
    memory = np.array([noise.sigma, noise.correlation_time, noise.colour_sigma, noise.colour_time])
    for run in runs:
        own = whiten(run, variance, memory)
        squares, logs, count = squares + own[0], logs + own[1], count + own[2]
    return squares, logs, count


@law
def whiten(run, variances, noise):
    """Sum of squared innovations of the linear system over their variances, of the logarithms of these, and how many.

    variances: of the white error by channel, shape (C,); noise: deviation and memory of the disturbance and of the
    sensor's coloured error, shape (4,).
    """
    sigma, memory, colour_sigma, colour_time = noise[0], noise[1], noise[2], noise[3]
    xx, xu, uu, xd, ud, dd = 0.0, 0.0, 0.0, 0.0, 0.0, sigma * sigma
    xb, ub, db, bb = 0.0, 0.0, 0.0, colour_sigma * colour_sigma
    x, u, d, b = 0.0, 0.0, 0.0, 0.0
    last, keep, fade, mean, fed, met = 0.0, 1.0, 1.0, 1.0, 0.0, 0.0
    squares, logs, count = 0.0, 0.0, 0
    for k in range(run.error.size):
        h = run.gap_s[k]
        if h > 0.0:
            if h != last:
                last, keep, fade = h, math.exp(-h / memory), math.exp(-h / colour_time)
                mean = (1.0 - keep) * memory / h
                fed = (sigma * memory) ** 2 * max(2.0 * h / memory - 3.0 + 4.0 * keep - keep * keep, 0.0)
                met = sigma * sigma * memory * (1.0 - keep) * (1.0 - keep)
            T = run.transition[k]
            f00, f01, f02 = T[0, 0], T[0, 1], T[0, 2] * mean
            f10, f11, f12 = T[1, 0], T[1, 1], T[1, 2] * mean
            x, u, d, b = f00 * x + f01 * u + f02 * d, f10 * x + f11 * u + f12 * d, keep * d, fade * b
            p0, p1, p2 = f00 * xx + f01 * xu + f02 * xd, f00 * xu + f01 * uu + f02 * ud, f00 * xd + f01 * ud + f02 * dd
            q0, q1, q2 = f10 * xx + f11 * xu + f12 * xd, f10 * xu + f11 * uu + f12 * ud, f10 * xd + f11 * ud + f12 * dd
            xb, ub = fade * (f00 * xb + f01 * ub + f02 * db), fade * (f10 * xb + f11 * ub + f12 * db)
            db *= fade * keep
            xx, xu, uu = p0 * f00 + p1 * f01 + p2 * f02, p0 * f10 + p1 * f11 + p2 * f12, q0 * f10 + q1 * f11 + q2 * f12
            xd, ud, dd = keep * p2, keep * q2, keep * keep * dd
            bb = fade * fade * bb + (1.0 - fade * fade) * colour_sigma * colour_sigma
            xx, xu, uu = xx + 3.0 / 20.0 * h * h * fed, xu + 3.0 / 8.0 * h * fed, uu + fed
            xd, ud, dd = xd + h / 3.0 * met, ud + met, dd + sigma * sigma * (1.0 - keep * keep)
        r0, r1, r2 = run.row[k, 0], run.row[k, 1], run.row[k, 2]
        e = run.error[k] - r0 * x - r1 * u - r2 * b
        cx, cu = r0 * xx + r1 * xu + r2 * xb, r0 * xu + r1 * uu + r2 * ub
        cd, cb = r0 * xd + r1 * ud + r2 * db, r0 * xb + r1 * ub + r2 * bb
        S = r0 * cx + r1 * cu + r2 * cb + variances[run.kind[k]] * run.weight[k]
        weight = 1.0 / S
        if run.used[k]:
            squares, logs, count = squares + e * e * weight, logs + math.log(S), count + 1
        gx, gu, gd, gb = cx * weight, cu * weight, cd * weight, cb * weight
        x, u, d, b = x + gx * e, u + gu * e, d + gd * e, b + gb * e
        xx, xu, uu, xd, ud, dd = xx - gx * cx, xu - gx * cu, uu - gu * cu, xd - gx * cd, ud - gu * cd, dd - gd * cd
        xb, ub, db, bb = xb - gx * cb, ub - gu * cb, db - gd * cb, bb - gb * cb
    return squares, logs, count
