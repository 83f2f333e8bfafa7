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
from .refit import ITERATIONS, NUISANCE, Fit, Recording, parameters, refit

Array = NDArray[np.float64]
FEW = 3  # iterations of each first fit, of which only the best is finished; a choice
NEAR = 0.1  # where a fit begins, over the effect's typical size; a choice


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
            rest.append(best_fit(effect, clean, left, top).whole)
    gram = np.array(rest) @ np.array(rest).T
    return {"names": names, "gram": [[float(f"{value:.6g}") for value in row] for row in gram]}


def best_fit(effect: Effect, clean: Sequence[Recording], left: Fit, top_rev_s: float) -> Fit:
    """The best refit of the hull's own parameters and one effect, from several starts around the refit without it."""
    free = (*NUISANCE, *parameters([effect]))
    starts = list(_starts(effect, left.p, top_rev_s))
    fits = [refit(clean, p, free, FEW if len(starts) > 1 else ITERATIONS, left.start) for p in starts]
    best = min(fits, key=lambda fit: fit.size)
    if len(starts) > 1:
        best = min(best, refit(clean, best.p, free, ITERATIONS, best.start), key=lambda fit: fit.size)
    return min(best, left, key=lambda fit: fit.size)


def _starts(effect: Effect, p: Array, top_rev_s: float) -> Iterator[Array]:
    """Parameters near the null, from which the first step is linear; several where a shape decides."""
    if effect.name == "thrust_saturation":
        for share in (0.9, 0.7):
            yield _set(p, {"thrust_saturation.n_max": share * top_rev_s})
    elif effect.name == "seiche":
        for rad_s in (0.2, 0.4, 0.8, 1.4):
            yield _set(p, {"seiche.amplitude": 0.002, "seiche.frequency": rad_s})
    elif effect.name == "wake_memory":
        for time_s in (2.0, 12.0):
            yield _set(p, {"wake_memory.k": 0.05, "wake_memory.T": time_s})
    else:
        signs = {q.name: 1.0 if q.bounds[1] > 0.0 else -1.0 for q in effect.parameters}
        yield _set(p, {f"{effect.name}.{q.name}": NEAR * signs[q.name] * q.scale for q in effect.parameters})


def _set(p: Array, values: dict[str, float]) -> Array:
    p = p.copy()
    for name, value in values.items():
        p[:, slot(name)] = value
    return p
