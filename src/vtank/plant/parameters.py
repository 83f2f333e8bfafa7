"""The parameter vector of the surge equation: which number stands where.

One float64 vector p serves the surge model, the MuJoCo tank and the diagnosis. Its slots are the plain surge
parameters followed by the parameters of every effect in catalogue order; `slot("linear_drag.c")` gives the index.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..effects.catalogue import CATALOGUE
from ..errors import InputError

# Plain parameters: name -> (unit, value where nothing is stated)
PLAIN: dict[str, tuple[str, float]] = {
    "alpha": ("1/m", 0.0),  # quadratic drag per unit of moving mass, negative
    "beta": ("m/rev2", 0.0),  # bollard thrust per unit of moving mass and n|n|
    "linear_input": ("-", 0.0),  # 1 where the input is a thrust already, so that thrust = beta * input
    "standoff": ("m", 3.048),  # distance from sonar to wall at x = 0: 10 ft, the paper's section IV (confidence H)
}

NAMES: tuple[str, ...] = (*PLAIN, *(name for effect in CATALOGUE for name in effect.slots()))
SIZE = len(NAMES)


def slot(name: str) -> int:
    """Index of a parameter in the vector; InputError lists the names that exist."""
    try:
        return NAMES.index(name)
    except ValueError:
        raise InputError(f"no surge parameter '{name}'; there are: {', '.join(NAMES)}") from None


def null_vector() -> np.ndarray:
    """Vector, shape (SIZE,), with every effect at its null value and no drag or thrust."""
    values = [value for _, value in PLAIN.values()]
    values += [parameter.null for effect in CATALOGUE for parameter in effect.parameters]
    return np.array(values)


def vector(values: Mapping[str, float], base: np.ndarray | None = None) -> np.ndarray:
    """A copy of `base` (default: the null vector) with the named slots set."""
    p = null_vector() if base is None else base.copy()
    for name, value in values.items():
        p[slot(name)] = value
    return p
