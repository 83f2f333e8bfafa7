"""The parameter vector of the surge equation: which number stands where.

One float64 vector p serves the surge model, the MuJoCo tank and the diagnosis. Its slots are the plain surge
parameters followed by the parameters of every effect in catalogue order; `slot("linear_drag.c")` gives the index.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..effects import linear_drag, thrust_lag, thrust_loss
from ..effects.catalogue import CATALOGUE, PARAMETERS
from ..effects.effect import Dependence, Effect
from ..errors import InputError
from ..record.toml import meant
from . import law

# Plain parameters: name -> (unit, value where nothing is stated)
PLAIN: dict[str, tuple[str, float]] = {
    "alpha": ("1/m", 0.0),  # quadratic drag per unit of moving mass, negative
    "beta": ("m/rev2", 0.0),  # bollard thrust per unit of moving mass and n|n|
    "force_offset": ("N", 0.0),  # what a transducer or amplifier reads where there is no force
    "linear_input": ("-", 0.0),  # share of thrust that goes with the input, not its square: 1 where it is a thrust
    "standoff": ("m", 3.048),  # distance from sonar to wall at x = 0: 10 ft, the paper's section IV (confidence H)
    **law.SLOTS,  # a law that is data
}

# What stands for a unit with revolutions in it where the input is no propeller speed
INPUT_UNITS = {
    "command": {"rev/s": "-", "m/rev2": "m/s2", "1/rev": "1/s"},
    "thrust_N": {"rev/s": "N", "m/rev2": "1/kg"},
}

NAMES: tuple[str, ...] = (*PLAIN, *PARAMETERS)
SIZE = len(NAMES)

(LINEAR_DRAG,), (LOSS,), (LAG,) = (of.EFFECT.slots() for of in (linear_drag, thrust_loss, thrust_lag))
LUMPED = ("alpha", "beta", LOSS, LAG)  # the simulator's own parameters, in the order of Model III


def slot(name: str) -> int:
    """Index of a parameter in the vector; InputError lists the names that exist."""
    try:
        return NAMES.index(name)
    except ValueError:
        raise InputError(f"no surge parameter '{name}'{meant(name, NAMES)}") from None


def indices(effect: Effect) -> tuple[int, ...]:
    """Indices of an effect's parameters in the vector, in their order."""
    return tuple(slot(name) for name in effect.slots())


def unit_of(name: str, input_name: str = "n_rev_s") -> str:
    """Unit of a slot, where the input is a propeller speed (as the catalogue has it), a command or a force."""
    unit = PLAIN[name][0] if name in PLAIN else PARAMETERS[name].unit
    return INPUT_UNITS.get(input_name, {}).get(unit, unit)


def switched_on(p: np.ndarray) -> tuple[Effect, ...]:
    """Effects of which a size differs from its null in the vector p, shape (SIZE,)."""
    differs = {name for name, q in PARAMETERS.items() if not q.shape and p[slot(name)] != q.null}
    return tuple(effect for effect in CATALOGUE if differs & set(effect.slots()))


def depending_on(what: Dependence) -> tuple[int, ...]:
    """Indices of the sizes of all effects whose law depends on the place, or on time."""
    return tuple(
        slot(name)
        for effect in CATALOGUE if what in effect.depends_on
        for name in effect.slots() if not PARAMETERS[name].shape
    )  # fmt: skip


def null_vector() -> np.ndarray:
    """Vector, shape (SIZE,), with every effect at its null value and no drag or thrust."""
    return np.array([value for _, value in PLAIN.values()] + [q.null for q in PARAMETERS.values()])


def vector(values: Mapping[str, float], base: np.ndarray | None = None) -> np.ndarray:
    """A copy of `base` (default: the null vector) with the named slots set."""
    p = null_vector() if base is None else base.copy()
    for name, value in values.items():
        p[slot(name)] = value
    return p
