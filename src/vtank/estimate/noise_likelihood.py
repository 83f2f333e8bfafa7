"""Likelihood of a noise level at known parameters, quick enough to search for it.

The surge model is linearised once along its simulation; what the measurements lie off it is then the output of a linear
system with four states, driven by turbulence alone: errors of place [m], speed [m/s], the disturbance [m/s2] and the
coloured error of the sonar [m]. The covariance recursion is that of `innovations.kalman`, without the model in it
(Anderson and Moore, Optimal Filtering, 1979, ch. 8: the linearised filter). All runs are gone through side by side, at
several noise levels where lanes are left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..compiled import law
from ..lanes import WIDTH, load, store, where
from .innovations import Noise, steps
from .kernels import kernels
from .observed import CHANNELS
from .problem import Problem

LONG = 8000  # measurements beyond which a run may be gone through in parts; a choice
BEFORE_S = 60.0  # [s] in which a filter forgets where it began: some memories of what disturbs; a choice
TOGETHER = 8  # variances multiplied before a logarithm is taken: far from what a double holds


class Linear(NamedTuple):
    """Runs linearised along their simulations, one to a lane, in the order in which their measurements were true.

    The runs come again and again until all lanes are full. Lanes whose run has ended count for nothing any more.

    Attributes:
        error: measurement less simulation, shape (M, W) [m or m/s].
        gap_s: time since the measurement before, shape (M, W) [s].
        transition: of place, speed and by a unit acceleration in that time, row by row, shape (6 M, W).
        row: derivative of the measurement with respect to place, speed and the sonar's error, shape (3 M, W).
        share: of the variance of each of C channels in that of the measurement, shape (C M, W).
        used: 1 where it counts, else 0, shape (M, W).
        loud: the disturbance since the measurement before over what it is elsewhere, shape (M, W).
    """

    error: np.ndarray
    gap_s: np.ndarray
    transition: np.ndarray
    row: np.ndarray
    share: np.ndarray
    used: np.ndarray
    loud: np.ndarray

    def louder(self, loud: np.ndarray) -> Linear:
        """The same under a disturbance that is as loud, shape (M, W)."""
        return Linear(*self[:-1], loud=np.ascontiguousarray(loud))


def apart(problem: Problem, theta: np.ndarray) -> list[Linear]:
    """Every run of a problem along its simulation at theta, by itself, in all lanes."""
    return [_stacked([_along(problem, theta, k)]) for k in range(len(problem.runs))]


def linearised(problem: Problem, theta: np.ndarray) -> list[tuple[int, Linear]]:
    """All runs of a problem along their simulations at theta: how many, and these, for every WIDTH of them.

    Lanes that few long runs leave empty take parts of them: a filter soon forgets where it began.
    """
    runs, each = [_along(problem, theta, k) for k in range(len(problem.runs))], WIDTH // len(problem.runs)
    runs = [part for run in runs for part in (_parts(run, each) if run[0].size > LONG else [run])]
    return [(len(some), _stacked(some)) for some in (runs[i : i + WIDTH] for i in range(0, len(runs), WIDTH))]


def _along(problem: Problem, theta: np.ndarray, k: int) -> tuple[np.ndarray, ...]:
    """The fields of `Linear` for one run, shapes (M, K)."""
    run = problem.runs[k]
    p, start = (np.repeat(part[:, None], WIDTH, axis=1) for part in problem.model(theta, k))
    plan, size = steps(run, p[:, 0]), run.time_s.size
    error, gap, transition, row = np.empty(size), np.empty(size), np.zeros((size, 2, 3)), np.zeros((size, 3))
    kernels(run.plant).linearise(p, start, plan, run.record, error, gap, transition, row)
    transition[gap <= 0.0] = np.eye(2, 3)
    weight = np.ones(size) if problem.weight is None else problem.weight[k]
    share = weight[:, None] * (run.kind[:, None] == np.arange(len(CHANNELS)))
    order = plan.which
    used, loud = problem.used(k)[order, None], np.full((size, 1), run.loud)
    return error[:, None], gap[:, None], transition.reshape(size, 6), row, share[order], used, loud


def _parts(run: tuple[np.ndarray, ...], count: int) -> list[tuple[np.ndarray, ...]]:
    """A run in parts, each with BEFORE_S of what was before it, which counts for nothing."""
    if count < 2:
        return [run]
    gap, *_, used, loud = run[1:]
    time_s, found = np.cumsum(gap[:, 0]), []
    for rows in np.array_split(np.arange(time_s.size), count):
        begin = int(np.searchsorted(time_s, time_s[rows[0]] - BEFORE_S)) if rows[0] else 0
        there = slice(begin, rows[-1] + 1)
        counts = used[there].copy()
        counts[: rows[0] - begin] = 0.0
        found.append((*(part[there] for part in run[:-2]), counts, loud[there]))
    return found


def _stacked(runs: Sequence[tuple[np.ndarray, ...]]) -> Linear:
    """Runs side by side, until all lanes are full."""
    most = max(own[0].shape[0] for own in runs)
    fields = []
    for parts in zip(*runs, strict=True):
        lanes = np.zeros((most, parts[0].shape[1], WIDTH))
        for lane in range(WIDTH):
            part = parts[lane % len(parts)]
            lanes[: len(part), :, lane] = part
            lanes[len(part) :, :, lane] = part[-1]
        fields.append(lanes.reshape(-1, WIDTH))
    found = Linear(*fields)
    for lane in range(WIDTH):
        found.used[runs[lane % len(runs)][0].shape[0] :, lane] = 0.0
    return found


def squares_and_logs(runs: Sequence[tuple[int, Linear]], noises: Sequence[Noise]) -> tuple[np.ndarray, np.ndarray, int]:
    """At each of L noise levels, the sum of squared innovations over their variances and that of these' logarithms.

    Shapes (L,); and the number of innovations that count.
    """
    levels = rows_of(noises)
    total, count = np.zeros((2, len(noises))), 0
    for size, linear in runs:
        count += int(linear.used[:, :size].sum())
        each = WIDTH // size
        for first in range(0, len(noises), each):
            some = np.minimum(first + np.arange(WIDTH) // size, len(noises) - 1)
            found, here = np.empty((2, WIDTH)), slice(first, first + each)
            whiten(linear, np.ascontiguousarray(levels[some].T), found)
            total[:, here] += found[:, : each * size].reshape(2, each, size).sum(axis=2)[:, : len(noises) - first]
    return total[0], total[1], count


def rows_of(noises: Sequence[Noise]) -> np.ndarray:
    """Noise levels as `whiten` takes them, shape (L, 4 + C)."""
    return np.array([(n.sigma, n.correlation_time, n.colour_sigma, n.colour_time, *n.variance) for n in noises])


@law
def whiten(runs, noise, found):
    """Sums of squared innovations of the linear systems over their variances, and of the logarithms of these, (2, W).

    noise: deviation and memory of the disturbance and of the sensor's coloured error, and the variance of the white
    error of each of C channels, shape (4 + C, W).
    """
    sigma, memory, colour_sigma, colour_time = load(noise, 0), load(noise, 1), load(noise, 2), load(noise, 3)
    channels, none, one = noise.shape[0] - 4, 0.0 * sigma, 0.0 * sigma + 1.0
    xx, xu, uu, xd, ud, dd = none, none, none, none, none, sigma * sigma
    xb, ub, db, bb = none, none, none, colour_sigma * colour_sigma
    x, u, d, b = none, none, none, none
    last, keep, fade, mean, fed, met = none, one, one, one, none, none
    squares, logs, product = none, none, one
    for k in range(runs.error.shape[0]):
        h = load(runs.gap_s, k)
        if h > 0.0:
            if h != last:
                last, keep, fade = h, math.exp(-h / memory), math.exp(-h / colour_time)
                mean = where(h > 0.0, (1.0 - keep) * memory / h, none)
                fed = sigma * sigma * memory * memory * max(2.0 * h / memory - 3.0 + 4.0 * keep - keep * keep, 0.0)
                met = sigma * sigma * memory * (1.0 - keep) * (1.0 - keep)
            T, i = runs.transition, 6 * k
            f00, f01, f02 = load(T, i), load(T, i + 1), load(T, i + 2) * mean
            f10, f11, f12 = load(T, i + 3), load(T, i + 4), load(T, i + 5) * mean
            x, u, d, b = f00 * x + f01 * u + f02 * d, f10 * x + f11 * u + f12 * d, keep * d, fade * b
            p0, p1, p2 = f00 * xx + f01 * xu + f02 * xd, f00 * xu + f01 * uu + f02 * ud, f00 * xd + f01 * ud + f02 * dd
            q0, q1, q2 = f10 * xx + f11 * xu + f12 * xd, f10 * xu + f11 * uu + f12 * ud, f10 * xd + f11 * ud + f12 * dd
            xb, ub = fade * (f00 * xb + f01 * ub + f02 * db), fade * (f10 * xb + f11 * ub + f12 * db)
            db = db * fade * keep
            xx, xu, uu = p0 * f00 + p1 * f01 + p2 * f02, p0 * f10 + p1 * f11 + p2 * f12, q0 * f10 + q1 * f11 + q2 * f12
            xd, ud, dd = keep * p2, keep * q2, keep * keep * dd
            bb = fade * fade * bb + (1.0 - fade * fade) * colour_sigma * colour_sigma
            times = load(runs.loud, k) * load(runs.loud, k)
            xx, xu, uu = xx + 3.0 / 20.0 * h * h * times * fed, xu + 3.0 / 8.0 * h * times * fed, uu + times * fed
            xd, ud = xd + h / 3.0 * times * met, ud + times * met
            dd = dd + times * sigma * sigma * (1.0 - keep * keep)
        r0, r1, r2 = load(runs.row, 3 * k), load(runs.row, 3 * k + 1), load(runs.row, 3 * k + 2)
        e = load(runs.error, k) - r0 * x - r1 * u - r2 * b
        cx, cu = r0 * xx + r1 * xu + r2 * xb, r0 * xu + r1 * uu + r2 * ub
        cd, cb = r0 * xd + r1 * ud + r2 * db, r0 * xb + r1 * ub + r2 * bb
        S = r0 * cx + r1 * cu + r2 * cb
        for c in range(channels):
            S = S + load(noise, 4 + c) * load(runs.share, channels * k + c)
        weight, used = 1.0 / S, load(runs.used, k)
        squares = squares + where(used > 0.0, e * e * weight, none)
        product = product * where(used > 0.0, S, one)
        if k % TOGETHER == TOGETHER - 1:
            logs, product = logs + math.log(product), one
        gx, gu, gd, gb = cx * weight, cu * weight, cd * weight, cb * weight
        x, u, d, b = x + gx * e, u + gu * e, d + gd * e, b + gb * e
        xx, xu, uu, xd, ud, dd = xx - gx * cx, xu - gx * cu, uu - gu * cu, xd - gx * cd, ud - gu * cd, dd - gd * cd
        xb, ub, db, bb = xb - gx * cb, ub - gu * cb, db - gd * cb, bb - gb * cb
    store(found, 0, squares)
    store(found, 1, logs + math.log(product))
