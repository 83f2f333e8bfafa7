"""What water does to a hull beyond drag along each axis, as a sum of terms of its velocity; a table of them is data.

Drag that grows with the speed in all directions, lift in oblique flow, moments of them: functions of first and second
degree of the velocity, the latter up to the third harmonic of its direction, as ellipsoids, boxes and strips have them;
and the square of turning times a speed, which a coarse integration adds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compiled import law, lean

Array = NDArray[np.float64]
SPEED, PRODUCT, SIZED, SWIFT, OBLIQUE, TURNED, SPUN = range(7)  # a; a b; |a| b; V a; a b c / V; a a b; W a
CREEP = 1e-6  # share of the usual speed below which no direction is told


class Flow(NamedTuple):
    """Forces of the water for the kernels.

    terms: kind and axes a, b, c of each term, (Q, 4). sizes: of each on each axis [N, N m], (6, Q). usual: speed of
    each axis [m/s, rad/s] that is one, (6,), alike for all that goes along. most: speeds over usual beyond which a term
    stays as it is, (6,).
    """

    terms: NDArray[np.int64]
    sizes: Array
    usual: Array
    most: Array

    def times(self, factors: Array) -> Flow:
        """The flow with the forces along and about each axis multiplied, factors (6,)."""
        return Flow(self.terms, self.sizes * factors[:, None], self.usual, self.most) if self.sizes.size else self


STILL = Flow(np.zeros((0, 4), np.int64), np.zeros((6, 0)), np.ones(6), np.ones(6))


def terms(axes: Sequence[int]) -> NDArray[np.int64]:
    """All terms of the velocities of these axes, (Q, 4)."""
    ahead, turns = [a for a in axes if a < 3], [a for a in axes if a > 2]
    found = [(SPEED, a, a, a) for a in axes]
    found += [(PRODUCT, a, b, b) for a, b in combinations_with_replacement(axes, 2)]
    found += [(SIZED, a, b, b) for a in axes for b in axes] + [(SWIFT, a, a, a) for a in axes]
    found += [(OBLIQUE, a, b, c) for a, b, c in combinations_with_replacement(ahead, 3)]
    found += [(TURNED, a, b, b) for a in turns for b in axes] + [(SPUN, a, a, a) for a in turns]
    return np.array(found, np.int64).reshape(-1, 4)


@lean
def held(nu, usual, most, a):
    """Velocity of axis a over its usual one, within what is known of it."""
    return min(max(nu[a] / usual[a], -most[a]), most[a])


@lean
def value(kind, u, v, w, V, W):
    """A term of the velocities u, v, w of its axes, and of the speeds V along and W about all axes."""
    if kind == SPEED:
        return u
    if kind == PRODUCT:
        return u * v
    if kind == SIZED:
        return abs(u) * v
    if kind == SWIFT:
        return V * u
    if kind == OBLIQUE:
        return u * v * w / V
    if kind == SPUN:
        return W * u
    return u * u * v


@lean
def swift(nu, usual, most, a):
    """Speed along or about the axes a to a + 2, over the usual one."""
    u, v, w = held(nu, usual, most, a), held(nu, usual, most, a + 1), held(nu, usual, most, a + 2)
    return math.sqrt(u * u + v * v + w * w) + CREEP


@lean
def pushed(nu, flow):
    """Wrench of the water at a velocity through it, 6 numbers each."""
    X, Y, Z, K, M, N = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    V, W = swift(nu, flow.usual, flow.most, 0), swift(nu, flow.usual, flow.most, 3)
    for q in range(flow.terms.shape[0]):
        u = held(nu, flow.usual, flow.most, flow.terms[q, 1])
        v = held(nu, flow.usual, flow.most, flow.terms[q, 2])
        w = held(nu, flow.usual, flow.most, flow.terms[q, 3])
        f = value(flow.terms[q, 0], u, v, w, V, W)
        X += flow.sizes[0, q] * f
        Y += flow.sizes[1, q] * f
        Z += flow.sizes[2, q] * f
        K += flow.sizes[3, q] * f
        M += flow.sizes[4, q] * f
        N += flow.sizes[5, q] * f
    return X, Y, Z, K, M, N


@law
def values(nu, flow, out):
    """All terms along velocities, (N, 6), into (N, Q)."""
    for i in range(nu.shape[0]):
        V, W = swift(nu[i], flow.usual, flow.most, 0), swift(nu[i], flow.usual, flow.most, 3)
        for q in range(flow.terms.shape[0]):
            u = held(nu[i], flow.usual, flow.most, flow.terms[q, 1])
            v = held(nu[i], flow.usual, flow.most, flow.terms[q, 2])
            w = held(nu[i], flow.usual, flow.most, flow.terms[q, 3])
            out[i, q] = value(flow.terms[q, 0], u, v, w, V, W)
