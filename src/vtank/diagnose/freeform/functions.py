"""Smooth functions of one or two variables as Gaussian processes: few columns, one size.

A Matern process over the range of the data, cut to the functions that carry its variance. Rasmussen and Williams,
Gaussian Processes for Machine Learning (2006), ch. 4.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ...compiled import law

KNOTS = 33  # of the range, between which functions are straight
LENGTH = 0.3  # [-] over which a function changes, as a share of the range; a choice
PLAYS = (0.01, 0.03, 0.1, 0.3)  # of the range, half the play of what drags behind a variable; choices
FUNCTIONS, PRODUCTS = 8, 16  # columns kept of one variable and of two; the rest carries under 1 and 8 % of the variance


@cache
def _process() -> tuple[np.ndarray, np.ndarray]:
    """Deviations of the process' own functions, shape (F,), and these over the knots, shape (KNOTS, F)."""
    knots = np.linspace(0.0, 1.0, KNOTS)
    d = np.sqrt(3.0) * np.abs(knots[:, None] - knots) / LENGTH
    values, vectors = np.linalg.eigh((1.0 + d) * np.exp(-d))
    keep = np.argsort(values)[::-1][:FUNCTIONS]
    return np.sqrt(values[keep]), vectors[:, keep]


def functions_of(share: np.ndarray) -> np.ndarray:
    """Functions of one variable, given as its share of the range, shape (I,); shape (I, FUNCTIONS)."""
    deviation, vectors = _process()
    place = np.clip(share, 0.0, 1.0) * (KNOTS - 1)
    low = np.minimum(place.astype(int), KNOTS - 2)
    part = (place - low)[:, None]
    return np.asarray(((1.0 - part) * vectors[low] + part * vectors[low + 1]) * deviation)


def products_of(first: np.ndarray, second: np.ndarray, count: int = PRODUCTS) -> np.ndarray:
    """Functions of two variables, given as columns of `functions_of`; shape (I, count)."""
    deviation, _ = _process()
    pairs = np.argsort(-np.outer(deviation, deviation), axis=None)[:count]
    i, j = np.unravel_index(pairs, (FUNCTIONS, FUNCTIONS))
    return np.asarray(first[:, i] * second[:, j])


def ways_of(share: np.ndarray) -> np.ndarray:
    """Functions of which way a variable went last, given as its share of the range, shape (I,); shape (I, 8).

    What play takes off it, by itself and as it grows with the variable: sums of plays make every hysteresis that has no
    rate. Visintin, Differential Models of Hysteresis (1994), ch. III: Prandtl and Ishlinskii.
    """
    ways = np.column_stack([(share - dragged(share, half)) / half for half in PLAYS])
    return np.hstack([ways, ways * np.abs(share - 0.5)[:, None] * 2.0])


@law
def dragged(values: np.ndarray, half: float) -> np.ndarray:
    """What drags behind values with play of so much to either side, from the first on, shape (I,)."""
    out = values.copy()
    for k in range(1, values.size):
        out[k] = min(max(out[k - 1], values[k] - half), values[k] + half)
    return out
