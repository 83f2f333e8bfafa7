"""How far a case lies from every wrong explanation: each effect of the catalogue refitted to the noise-free runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dynamics.parameters import slot
from ..effects.catalogue import CATALOGUE
from ..effects.effect import Effect
from .case import Case, tied
from .cause import CHANCE
from .refit import NUISANCE, Fit, Recording, parameters, refit

Array = NDArray[np.float64]
FEW = 6  # iterations of each first fit, of which only the best is finished


def rivals(case: Case, clean: Sequence[Recording], left: Fit) -> dict[str, Any]:
    """Names of the rivals and the Gram matrix of what they leave, whitened; `parameters` stands first.

    The root of a diagonal element is the separation from that rival: the part of the signal that it cannot imitate.
    """
    top = max(float(np.max(np.abs(r.n_read))) for r in clean)
    names, rest = ["parameters"], [left.whole]
    for effect in CATALOGUE:
        if tied(effect.name) in [tied(c.name) for c in case.causes] or effect.name in (*CHANCE, "thrust_lag"):
            continue
        if effect.standing != "absorbed" and tied(effect.name) == effect.name:
            names.append(effect.name)
            rest.append(best_fit(effect, clean, case.truth.vector(), top).whole)
    gram = np.array(rest) @ np.array(rest).T
    return {"names": names, "gram": [[float(f"{value:.6g}") for value in row] for row in gram]}


def best_fit(effect: Effect, clean: Sequence[Recording], p: Array, top_rev_s: float) -> Fit:
    """The best refit of the hull's own parameters and one effect, from several starts."""
    free = (*NUISANCE, *parameters([effect]))
    fits = [refit(clean, start, free, FEW) for start in _starts(effect, p, top_rev_s)]
    best = min(fits, key=lambda fit: fit.size)
    again = refit(clean, best.p, free)
    return min(best, again, key=lambda fit: fit.size)


def _starts(effect: Effect, p: Array, top_rev_s: float) -> Iterator[Array]:
    if effect.name == "thrust_saturation":
        for share in (0.95, 0.8, 0.6):
            yield _set(p, {"thrust_saturation.n_max": share * top_rev_s})
    elif effect.name == "seiche":
        for rad_s in (0.2, 0.35, 0.6, 1.0, 1.6):
            yield _set(p, {"seiche.amplitude": 0.002, "seiche.frequency": rad_s})
    elif effect.name == "wake_memory":
        for time_s in (1.5, 5.0, 15.0):
            yield _set(p, {"wake_memory.k": 0.1, "wake_memory.T": time_s})
    else:
        for share in (0.3, -0.3):
            values = {
                f"{effect.name}.{q.name}": float(np.clip(share * q.scale, *q.bounds)) for q in effect.parameters
            }
            if any(value != 0.0 for value in values.values()):
                yield _set(p, values)


def _set(p: Array, values: dict[str, float]) -> Array:
    p = p.copy()
    for name, value in values.items():
        p[slot(name)] = value
    return p
