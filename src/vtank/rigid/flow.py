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
FACTORS = 18  # of which terms are products: velocity of each axis over the usual one, its size, and these
SIZE, ONE, V, W, OBLIQUE, SLENDER, SHARP = 6, 12, 13, 14, 15, 16, 17  # |velocity|, 1, V, W, 1 / V, 1 / S, V / S^2
CREEP = 1e-6  # share of the usual speed below which no direction is told


class Flow(NamedTuple):
    """Forces of the water for the kernels.

    terms: the four factors of each term, (Q, 4). sizes: of each on each axis [N, N m], (6, Q). usual: speed of
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
    found = [(a, ONE, ONE, ONE) for a in axes]
    found += [(a, b, ONE, ONE) for a, b in combinations_with_replacement(axes, 2)]
    found += [(SIZE + a, b, ONE, ONE) for a in axes for b in axes] + [(V, a, ONE, ONE) for a in axes]
    found += [(by, *abc) for by in (OBLIQUE, SLENDER, SHARP) for abc in combinations_with_replacement(ahead, 3)]
    found += [(a, a, b, ONE) for a in turns for b in axes] + [(W, a, ONE, ONE) for a in turns]
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
def factors(nu, flow, x):
    """All factors of terms at a velocity through the water into x, (18,).

    V is the speed along, S that along by what each axis usually does, W that about all axes.
    """
    there = met(nu, flow.centre)
    for a in range(6):
        x[a] = min(max(there[a] / flow.usual[a], -flow.most[a]), flow.most[a])  # within what is known of it
        x[SIZE + a] = abs(x[a])
    u, v, w = flow.slower[0] * x[0], flow.slower[1] * x[1], flow.slower[2] * x[2]
    along = math.sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) + CREEP
    slowly = math.sqrt(u * u + v * v + w * w) + CREEP
    x[ONE], x[V], x[W] = 1.0, along, math.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5])
    x[OBLIQUE], x[SLENDER], x[SHARP] = 1.0 / along, 1.0 / slowly, along / (slowly * slowly)


@lean
def pushed(nu, flow, x):
    """Wrench of the water at a velocity through it, 6 numbers each; x, (18,): scratch."""
    X, Y, Z, K, M, N = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    factors(nu, flow, x)
    for q in range(flow.terms.shape[0]):
        f = x[flow.terms[q, 0]] * x[flow.terms[q, 1]] * x[flow.terms[q, 2]] * x[flow.terms[q, 3]]
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
    x = np.empty(FACTORS)
    for i in range(nu.shape[0]):
        factors(nu[i], flow, x)
        for q in range(flow.terms.shape[0]):
            out[i, q] = x[flow.terms[q, 0]] * x[flow.terms[q, 1]] * x[flow.terms[q, 2]] * x[flow.terms[q, 3]]
