"""What the known effects leave of a cause of no catalogue, refitted to the noise-free runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...effects import Effect
from ...plant import slot
from .case import Case, able, tied
from .refit import ITERATIONS, Fit, Recording, own_parameters, parameters, refit

Array = NDArray[np.float64]
LEADERS = 2  # single effects beside which a second is looked for; a choice
FEW = 3  # iterations of each first fit, of which only the best is finished; a choice
NEAR = 0.1  # where a fit begins, over the effect's typical size; a choice
# Where a fit begins, by unit, of a shape and of the size beside it, and a limit over the top speed; choices
SHAPES = {"rad/s": (0.2, 0.4, 0.8, 1.4), "s": (2.0, 12.0)}
SMALL = {"-": 0.05}
LIMITS = (0.9, 0.7)


def others(case: Case) -> list[Effect]:
    """Effects of the catalogue that are not the cause, of tied ones the first."""
    causes = [tied(c.name) for c in case.causes]
    return [e for e in able(case.nominal) if e.standing != "absorbed" and tied(e.name) == e.name
            and e.name not in causes and not e.outliers]  # fmt: skip


def best_pair(case: Case, clean: Sequence[Recording], left: Fit) -> dict[str, Any]:
    """Two effects that together leave the least, each being looked for beside the best single ones; what they leave."""
    singles = sorted(((best_fit([e], clean, left), e) for e in others(case)), key=lambda found: found[0].size)
    found: list[tuple[float, tuple[str, ...]]] = [(fit.size, (leader.name,)) for fit, leader in singles[:1]]
    for fit, leader in singles[:LEADERS]:
        for second in (e for e in others(case) if e is not leader):
            found.append((best_fit([leader, second], clean, fit).size, (leader.name, second.name)))
    size, names = min(found)
    return {"names": list(names), "d": size}


def best_fit(effects: Sequence[Effect], clean: Sequence[Recording], left: Fit) -> Fit:
    """The best refit of the hull's own parameters and some effects, from several starts of the last around `left`."""
    top = max(float(np.max(np.abs(r.n_read))) for r in clean)
    free = tuple(dict.fromkeys((*own_parameters(left.p), *parameters(effects))))
    starts = list(_starts(effects[-1], left.p, top))
    fits = [refit(clean, p, free, FEW if len(starts) > 1 else ITERATIONS, left.start) for p in starts]
    best = min(fits, key=lambda fit: fit.size)
    if len(starts) > 1:
        best = min(best, refit(clean, best.p, free, ITERATIONS, best.start), key=lambda fit: fit.size)
    return min(best, left, key=lambda fit: fit.size)


def _starts(effect: Effect, p: Array, top_rev_s: float) -> Iterator[Array]:
    """Parameters near the null, from which the first step is linear; several where a shape decides."""
    shaped = any(q.shape for q in effect.parameters)
    values: dict[str, tuple[float, ...]] = {}
    for name, q in zip(effect.slots(), effect.parameters, strict=True):
        if q.limit:
            values[name] = tuple(share * top_rev_s for share in LIMITS)
        elif q.shape and not q.per_run:
            values[name] = SHAPES.get(q.unit, (q.null,))
        elif not q.shape:
            near = NEAR * q.scale if q.bounds[1] > 0.0 else -NEAR * q.scale
            values[name] = (SMALL.get(q.unit, near) if shaped else near,)
    for point in product(*values.values()):
        start = p.copy()
        start[:, [slot(name) for name in values]] = point
        yield start
