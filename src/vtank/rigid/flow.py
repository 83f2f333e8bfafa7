"""What water does to a hull beyond drag along each axis, as a sum of terms of its velocity; a table of them is data.

Drag that grows with the speed in all directions, lift in oblique flow, moments of them: functions of first and second
degree of the velocity, the latter up to the third harmonic of its direction, as ellipsoids, boxes and strips have them,
and of that of a direction with more of what goes slowly, since a slender hull meets the water otherwise soon; and the
square of turning times a speed, which a coarse integration adds.
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
SPEED, PRODUCT, SIZED, SWIFT, TURNED, SPUN = range(6)  # a; a b; |a| b; V a; a a b; W a
OBLIQUE, SLENDER, SHARP = range(6, 9)  # a b c / V; a b c / S; V a b c / S^2
CREEP = 1e-6  # share of the usual speed below which no direction is told


class Flow(NamedTuple):
    """Forces of the water for the kernels.

    terms: kind and axes a, b, c of each term, (Q, 4). sizes: of each on each axis [N, N m], (6, Q). usual: speed of
    each axis [m/s, rad/s] that is one, (6,), alike for all that goes along. most: speeds over usual beyond which a term
    stays as it is, (6,). slower: times by which each axis along goes more slowly than that, (3,). centre: of the hull,
    where the water is met [m], (3,).
    """

    terms: NDArray[np.int64]
    sizes: Array
    usual: Array
    most: Array
    slower: Array
    centre: Array

    def sized(self, sizes: Array) -> Flow:
        """The same terms with other sizes, (6, Q)."""
        return Flow(self.terms, sizes, self.usual, self.most, self.slower, self.centre)

    def about(self, centre: Array) -> Flow:
        """The same flow, met at another centre of the hull [m], (3,)."""
        return Flow(self.terms, self.sizes, self.usual, self.most, self.slower, centre)

    def times(self, factors: Array) -> Flow:
        """The flow with the forces along and about each axis multiplied, factors (6,)."""
        return self.sized(self.sizes * factors[:, None]) if self.sizes.size else self


STILL = Flow(np.zeros((0, 4), np.int64), np.zeros((6, 0)), np.ones(6), np.ones(6), np.ones(3), np.zeros(3))


def terms(axes: Sequence[int]) -> NDArray[np.int64]:
    """All terms of the velocities of these axes, (Q, 4)."""
    ahead, turns = [a for a in axes if a < 3], [a for a in axes if a > 2]
    found = [(SPEED, a, a, a) for a in axes]
    found += [(PRODUCT, a, b, b) for a, b in combinations_with_replacement(axes, 2)]
    found += [(SIZED, a, b, b) for a in axes for b in axes] + [(SWIFT, a, a, a) for a in axes]
    found += [(q, *abc) for q in (OBLIQUE, SLENDER, SHARP) for abc in combinations_with_replacement(ahead, 3)]
    found += [(TURNED, a, b, b) for a in turns for b in axes] + [(SPUN, a, a, a) for a in turns]
    return np.array(found, np.int64).reshape(-1, 4)


@lean
def met(nu, c):
    """Velocity, 6 numbers, of a point c of the hull."""
    u, v, w = (
        nu[0] + nu[4] * c[2] - nu[5] * c[1],
        nu[1] + nu[5] * c[0] - nu[3] * c[2],
        nu[2] + nu[3] * c[1] - nu[4] * c[0],
    )
    return u, v, w, nu[3], nu[4], nu[5]


@lean
def held(nu, usual, most, a):
    """Velocity of axis a over its usual one, within what is known of it."""
    return min(max(nu[a] / usual[a], -most[a]), most[a])


@lean
def value(kind, u, v, w, V, S, W):
    """A term of the velocities u, v, w of its axes, and of the speeds `speeds`."""
    if kind == SPEED:
        return u
    if kind == PRODUCT:
        return u * v
    if kind == SIZED:
        return abs(u) * v
    if kind == SWIFT:
        return V * u
    if kind == TURNED:
        return u * u * v
    if kind == SPUN:
        return W * u
    if kind == OBLIQUE:
        return u * v * w / V
    if kind == SLENDER:
        return u * v * w / S
    return V * u * v * w / (S * S)


@lean
def speeds(nu, usual, most, slower):
    """V along, S along by what each axis usually does, W about all axes, over the usual."""
    u, v, w = held(nu, usual, most, 0), held(nu, usual, most, 1), held(nu, usual, most, 2)
    p, q, r = held(nu, usual, most, 3), held(nu, usual, most, 4), held(nu, usual, most, 5)
    a, b, c = slower[0] * u, slower[1] * v, slower[2] * w
    V, S = math.sqrt(u * u + v * v + w * w), math.sqrt(a * a + b * b + c * c)
    return V + CREEP, S + CREEP, math.sqrt(p * p + q * q + r * r)


@lean
def pushed(nu, flow):
    """Wrench of the water at a velocity through it, 6 numbers each."""
    X, Y, Z, K, M, N = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    nu = met(nu, flow.centre)
    V, S, W = speeds(nu, flow.usual, flow.most, flow.slower)
    for q in range(flow.terms.shape[0]):
        u = held(nu, flow.usual, flow.most, flow.terms[q, 1])
        v = held(nu, flow.usual, flow.most, flow.terms[q, 2])
        w = held(nu, flow.usual, flow.most, flow.terms[q, 3])
        f = value(flow.terms[q, 0], u, v, w, V, S, W)
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
        there = met(nu[i], flow.centre)
        V, S, W = speeds(there, flow.usual, flow.most, flow.slower)
        for q in range(flow.terms.shape[0]):
            u = held(there, flow.usual, flow.most, flow.terms[q, 1])
            v = held(there, flow.usual, flow.most, flow.terms[q, 2])
            w = held(there, flow.usual, flow.most, flow.terms[q, 3])
            out[i, q] = value(flow.terms[q, 0], u, v, w, V, S, W)
