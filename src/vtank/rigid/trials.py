"""Filters of a run at several noises side by side, linear about the path that another filter has gone.

WIDTH noises go through one pass for little more than the price of one: the search for the likeliest tries them so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..compiled import law, lean
from ..lanes import WIDTH, load, store
from .filtered import Filtered, Left, Noise, memories
from .kalman import Told, pushing, through
from .kernels import SIZE, lasting
from .recorded import Recorded
from .steps import FIRST


class Levels(NamedTuple):
    """Noises, one to a lane: variances of C columns, (C, W), deviations of the disturbance and its memory, (6, W).

    which: slow error of each column, (C,), -1 for none in any lane. slow, slow_s: their deviations, memories, (S, W).
    timing: deviations of when inputs turn, (1, W).
    """

    variance: np.ndarray
    sigma: np.ndarray
    memory: np.ndarray
    which: np.ndarray
    slow: np.ndarray
    slow_s: np.ndarray
    timing: np.ndarray


def tried(run: Recorded, f: Filtered, noises: Sequence[Noise]) -> list[Left]:
    """What filters at up to WIDTH noises leave of a run, linear about the path of f."""
    told = Told(*np.empty((5, run.time_s.size, WIDTH)))
    beside(f.way, run.steps, run.spread, run.column, _levels(run, noises), run.rough, f.gains, f.told, told)
    return [Left(Told(*(part[:, lane] for part in told)), f.wall) for lane in range(len(noises))]


def _levels(run: Recorded, noises: Sequence[Noise]) -> Levels:
    """In lanes, of which those that are left over have the last noise."""
    every = [*noises, *[noises[-1]] * (WIDTH - len(noises))]
    variance, sigma, slow, slow_s = (
        np.ascontiguousarray(np.transpose([getattr(noise, part) for noise in every]))
        for part in ("variance", "sigma", "slow", "slow_s")
    )
    has = (slow > 0.0).any(axis=1)
    which = np.where(has, np.cumsum(has) - 1, -1)
    memory = np.ascontiguousarray(np.transpose([memories(run, noise) for noise in every]))
    timing = np.array([[noise.timing for noise in every]])
    return Levels(variance, sigma * run.disturbed[:, None], memory, which, slow[has], slow_s[has], timing)


@lean
def row(a, b, size):
    """Of the covariance of two states: what lies below the diagonal is not kept."""
    return min(a, b) * size + max(a, b)


@lean
def carried(F, h, levels, rough, stir, step, keep, mean, G, P, A):
    """As `kalman.carry`, in lanes: covariance P, (n n, W), as of `row`, after a step of h [s]; A, (n n, W): scratch.

    G: of `pushing`, (12, 6); keep, (6 + S, W): what is left of disturbances and slow errors; mean: of `lasting`.
    """
    size = SIZE + levels.slow.shape[0]
    none = 0.0 * load(levels.memory, 0)
    for i in range(size):  # A = P T'
        for k in range(12):
            moves = none
            for q in range(12):
                if F[k, q] != 0.0:
                    moves = moves + F[k, q] * load(P, row(i, q, size))
            for c in range(6):
                if G[k, c] != 0.0:
                    moves = moves + G[k, c] * (load(mean, c) * load(P, row(i, 12 + c, size)))
            store(A, i * size + k, moves)
        for k in range(12, size):
            store(A, i * size + k, load(keep, k - 12) * load(P, row(i, k, size)))
    for i in range(12):  # P = T A
        for k in range(i, size):
            moves = none
            for q in range(12):
                if F[i, q] != 0.0:
                    moves = moves + F[i, q] * load(A, q * size + k)
            for c in range(6):
                if G[i, c] != 0.0:
                    moves = moves + G[i, c] * (load(mean, c) * load(A, (12 + c) * size + k))
            store(P, i * size + k, moves)
    for i in range(12, size):
        for k in range(i, size):
            store(P, i * size + k, load(keep, i - 12) * load(A, i * size + k))
    for i in range(SIZE, size):
        left, slow = load(keep, i - 12), load(levels.slow, i - SIZE)
        store(P, i * size + i, load(P, i * size + i) + slow * slow * (1.0 - left * left))
    early = load(levels.timing, 0)
    for a in range(6):
        sigma, memory, left, (v, d) = load(levels.sigma, a), load(levels.memory, a), load(keep, a), (6 + a, 12 + a)
        both = memory * (1.0 - left) * (1.0 - left)
        gust = memory * memory * max(2.0 * h / memory - 3.0 + 4.0 * left - left * left, 0.0)
        store(P, v * size + v, load(P, v * size + v) + early * early * (h * rough[step, a]))
        store(P, d * size + d, load(P, d * size + d) + sigma * sigma * (1.0 - left * left))
        if a >= 3 or stir.shape[0] == 0:
            store(P, v * size + v, load(P, v * size + v) + sigma * sigma * gust)
            store(P, v * size + d, load(P, v * size + d) + sigma * sigma * both)
        else:
            for b in range(6):
                by, at = stir[step, b, a], 6 + b
                store(P, at * size + d, load(P, at * size + d) + by * (sigma * sigma * both))
                for c in range(b, 6):
                    to = at * size + 6 + c
                    store(P, to, load(P, to) + by * stir[step, c, a] * (sigma * sigma * gust))


@lean
def weighed(P, H, own, noise_var, C, gain, m, told):
    """As `kalman.weigh`, in lanes: noise_var: of the measurement; C, gain: (n, W)."""
    size = gain.shape[0]
    explained = 0.0 * noise_var
    for a in range(size):
        shared = explained * 0.0
        if own >= 0:
            shared = load(P, row(SIZE + own, a, size))
        for b in range(SIZE):
            if H[b] != 0.0:
                shared = shared + H[b] * load(P, row(b, a, size))
        store(C, a, shared)
    for a in range(SIZE):
        if H[a] != 0.0:
            explained = explained + H[a] * load(C, a)
    apart = explained + noise_var
    if own >= 0:
        slow = load(C, SIZE + own)
        explained = explained + slow
        apart = apart + load(P, (SIZE + own) * size + SIZE + own) - slow
    variance = explained + noise_var
    store(told.apart, m, apart)
    store(told.explained, m, explained)
    store(told.variance, m, variance)
    for a in range(size):
        store(gain, a, load(C, a) / variance)
    for a in range(size):
        for b in range(a, size):
            store(P, a * size + b, load(P, a * size + b) - load(gain, b) * load(C, a))


@law
def beside(way, steps, spread, column, levels, rough, then, before, told):
    """Filters at the noises of `levels`, linear about a path, into `told`, of (M, W).

    spread: of the start, (12,); column: of each measurement, (M,); rough: of the run, (N, 6); then: gains, before: what
    they told, of the filter that went the path.
    """
    size, wide = SIZE + levels.slow.shape[0], levels.sigma.shape[1]
    P, A, G = np.zeros((size * size, wide)), np.empty((size * size, wide)), np.empty((12, 6))
    C, gain, x, new = np.empty((size, wide)), np.empty((size, wide)), np.zeros((size, wide)), np.empty((12, wide))
    keep, mean, meant, H = np.empty((size - 12, wide)), np.empty((6, wide)), np.empty(6), np.empty(SIZE)
    on_the_way(
        way, steps, spread, column, levels, rough, then, before, told, P, A, G, C, gain, x, new, keep, mean, meant, H
    )  # fmt: skip


@lean
def on_the_way(
    way, steps, spread, column, levels, rough, then, before, told, P, A, G, C, gain, x, new, keep, mean, meant, H
):  # fmt: skip
    """As `beside`; P, x: covariance and state, of zeros; the others: to use."""
    size, i = SIZE + levels.slow.shape[0], FIRST
    for a in range(12):
        store(P, a * size + a, spread[a] ** 2)
    for a in range(6):
        store(P, (12 + a) * size + 12 + a, load(levels.sigma, a) * load(levels.sigma, a))
    for a in range(levels.slow.shape[0]):
        store(P, (SIZE + a) * size + SIZE + a, load(levels.slow, a) * load(levels.slow, a))
    for q in range(steps.which.size):
        m = steps.which[q]
        while i < steps.upto[q]:  # x: of the motion, what it is off the path; of the rest, itself
            h, F = steps.length[i], way.F[i]
            if i == 0 or h != steps.length[i - 1]:
                for c in range(6):
                    left, over = lasting(h, load(levels.memory, c))
                    store(keep, c, left)
                    store(mean, c, over)
                    _, meant[c] = lasting(h, then.memory[c])
                for c in range(levels.slow.shape[0]):
                    store(keep, 6 + c, math.exp(-h / load(levels.slow_s, c)))
            for a in range(12):
                on = 0.0 * load(levels.memory, 0)
                for c in range(12):
                    on = on + F[a, c] * load(x, c)
                for c in range(6):
                    G[a, c] = pushing(F, h, then.stir, i, a, c)
                    on = on + G[a, c] * (load(mean, c) * load(x, 12 + c) - meant[c] * way.states[i, 12 + c])
                store(new, a, on)
            for a in range(12):
                store(x, a, load(new, a))
            for a in range(12, size):
                store(x, a, load(keep, a - 12) * load(x, a))
            carried(F, h, levels, rough, then.stir, i, keep, mean, G, P, A)
            i += 1
        own = levels.which[column[m]]
        for a in range(12):
            H[a] = way.H[m, a]
        for a in range(6):
            H[12 + a] = through(way.H[m], then.stir, max(i - 1, 0), a)
        e = before.innovation[m] + before.slow[m] + 0.0 * load(levels.memory, 0)
        for a in range(12):
            e = e - H[a] * load(x, a)
        for a in range(12, SIZE):
            e = e - H[a] * (load(x, a) - way.before[m, a])
        if own >= 0:
            e = e - load(x, SIZE + own)
            store(told.slow, m, load(x, SIZE + own))
        else:
            store(told.slow, m, 0.0)
        store(told.innovation, m, e)
        weighed(P, H, own, load(levels.variance, column[m]), C, gain, m, told)
        for a in range(12):
            store(x, a, load(x, a) + load(gain, a) * e - then.of[m, a] * before.innovation[m])
        for a in range(12, size):
            store(x, a, load(x, a) + load(gain, a) * e)
