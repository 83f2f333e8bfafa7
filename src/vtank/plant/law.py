"""A law that is data: a size times up to three factors of the motion, interpreted in the surge equation.

    force [m/s2] or range error [m] = size * f1 * f2 * f3,   f = operation(variable; a, b)

Which variable and which operation is told by numbers in the parameter vector, so that a formula found in recordings is
obeyed by everything that reads the vector: surge model, tank, fits, predictions. One memory can be had beside it: a
value w that follows a quantity q, sums it up, latches on it, is what it was a while ago or drags behind it with play.
It takes the place of the hull's wake among the states.
`formula.py` writes these numbers and says in words what they mean.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import law, term
from ..lanes import where

# "": no factor; speed: |u|; turning: |n|; a: acceleration by all other forces; z: thrust; w: memory; fresh: q - w
VARIABLES = ("", "u", "n", "x", "gap", "t", "a", "z", "w", "fresh", "speed", "turning")
OPERATIONS = ("power", "signed", "above", "beyond", "sine", "decay", "from")
KINDS = ("", "follows", "sums", "latches", "delays", "plays")
FACTORS = 3
LATCH_S = 0.1  # [s] in which a latch falls over and play is taken up: a tick, nothing quicker is seen; a choice
TINY = 1e-9  # below this a power of a variable is that of this; keeps negative powers finite

# Slots of the parameter vector: name -> (unit, value where nothing is stated)
SLOTS: dict[str, tuple[str, float]] = {
    "law.force": ("m/s2", 0.0),  # size of a force per unit of moving mass; the unit is that of the whole product
    "law.range": ("m", 0.0),  # size of an error of the range
    **{f"law.{part}{i}": ("-", 0.0) for i in range(1, FACTORS + 1) for part in ("variable", "operation", "a", "b")},
    **{f"law.memory_{part}": ("-", 0.0) for part in ("kind", "variable", "operation", "power", "a", "b")},
}


@term
def _variable(which, t, x, u, z, w, n, gap, acc):
    """The variable of that number."""
    y = 0.0 * u + t
    if which == 1.0:
        y = u
    if which == 2.0:
        y = n + 0.0 * u
    if which == 3.0:
        y = x + 0.0 * u
    if which == 4.0:
        y = gap + 0.0 * u
    if which == 6.0:
        y = acc + 0.0 * u
    if which == 7.0:
        y = z + 0.0 * u
    if which == 8.0:
        y = w + 0.0 * u
    if which == 10.0:
        y = abs(u)
    if which == 11.0:
        y = abs(n) + 0.0 * u
    return y


@term
def _power(y, a):
    """|y|^a; the usual exponents without a logarithm."""
    q = abs(y)
    if a == 0.0:
        return 0.0 * q + 1.0
    if a == 1.0:
        return q
    if a == 2.0:
        return q * q
    if a == 0.5:
        return math.sqrt(q)
    if a == 1.5:
        return q * math.sqrt(q)
    return math.exp(a * math.log(max(q, TINY)))


@law
def operated(operation, y, a, b):
    """One factor: the operation of that number on a variable."""
    if operation == 0.0:
        return _power(y, a)
    if operation == 1.0:
        if a == 0.0:
            return math.tanh(y / b)
        return _power(y, a) * where(y < 0.0, -1.0, 1.0)
    if operation == 2.0:
        return 0.5 + 0.5 * math.tanh((y - a) / b)
    if operation == 3.0:
        return max((y - a) * where(b < 0.0, -1.0, 1.0), 0.0 * y)
    if operation == 4.0:
        return math.sin(a * y + b)
    if operation == 5.0:
        return math.exp(-y / a)
    return y - a


@law
def factor(which, operation, a, b, t, x, u, z, w, n, gap, acc, fresh):
    """One factor of the product; 1 where there is none."""
    if which == 0.0:
        return 0.0 * u + 1.0
    return operated(operation, where(which == 9.0, fresh, _variable(which, t, x, u, z, w, n, gap, acc)), a, b)


@law
def product(t, x, u, z, w, n, gap, acc, fresh, f):
    """Product of the factors f, four numbers each: variable, operation, a, b."""
    y = factor(f[0], f[1], f[2], f[3], t, x, u, z, w, n, gap, acc, fresh)
    y = y * factor(f[4], f[5], f[6], f[7], t, x, u, z, w, n, gap, acc, fresh)
    return y * factor(f[8], f[9], f[10], f[11], t, x, u, z, w, n, gap, acc, fresh)


@law
def driven(t, x, u, z, n, m):
    """The quantity that a memory m = (kind, variable, operation, power, a, b) keeps."""
    return operated(m[2], _variable(m[1], t, x, u, z, 0.0, n, 0.0, 0.0), m[3], 0.01)


@law
def memory_rate(t, x, u, z, w, n, m):
    """d/dt of a memory w."""
    q = driven(t, x, u, z, n, m)
    if m[0] == 1.0:
        return (q - w) / m[4]
    if m[0] == 2.0:
        return q
    if m[0] == 4.0:
        return 2.0 * (q - w) / m[4]
    if m[0] == 5.0:
        return (max(q - w - m[4], 0.0 * q) - max(w - q - m[4], 0.0 * q)) / LATCH_S
    up = where(q > m[4], 1.0 + 0.0 * q, where(q < m[5], 0.0 * q, where(w > 0.5, 1.0 + 0.0 * q, 0.0 * q)))
    return (up - w) / LATCH_S


@law
def recalled(w, q, m):
    """What a memory gives as w: its state, but for a delay, which is Pade's first: 2 w - q with half its lag."""
    if m[0] == 4.0:
        return 2.0 * w - q
    return w


@law
def remember(t, x, u, z, n, m):
    """What a memory holds along samples, and what is new in its quantity, shape (2, I)."""
    out, w = np.empty((2, t.size)), 0.0
    for i in range(t.size):
        q = driven(t[i], x[i], u[i], z[i], n[i], m)
        out[0, i], out[1, i] = recalled(w, q, m), q - w
        h = t[i + 1] - t[i] if i + 1 < t.size else 0.0
        for _ in range(2):  # two half steps by the midpoint rule: stable for a latch at 5 Hz
            g = 0.5 * h
            middle = w + 0.5 * g * memory_rate(t[i], x[i], u[i], z[i], w, n[i], m)
            w = w + g * memory_rate(t[i] + 0.5 * g, x[i], u[i], z[i], middle, n[i], m)
    return out


@law
def tabulate(code, t, x, u, z, w, n, gap, a, fresh):
    """Values of one factor along samples, shape (I,)."""
    out = np.empty(t.size)
    for i in range(t.size):
        out[i] = factor(code[0], code[1], code[2], code[3], t[i], x[i], u[i], z[i], w[i], n[i], gap[i], a[i], fresh[i])
    return out
