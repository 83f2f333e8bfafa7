"""A model without some of its effects, whose own parameters take up what they can of these, and are trusted anew."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...rigid.filtered import Filtered
from ...rigid.layout import Layout
from ...rigid.places import Placed
from .model import Model, blank, refit
from .own import Unknown, own_unknowns
from .trust import retrusted


def without(model: Model, layout: Layout, gone: Sequence[Placed], found: Sequence[Filtered]) -> Model:
    """The refit without some effects, own parameters trusted as they were or anew: whichever is likelier.

    Beside an effect a file may be trusted far more than without it.
    """
    if not gone:
        return model
    stay = [placed for placed in model.effects if placed not in gone]
    mine = trusted_in(model)
    names = {u.name for u in mine}
    own = [u for u in own_unknowns(layout, model.fit.runs) if u.name in names]
    as_it_was = lessened(model, layout, stay, mine, found)
    anew = retrusted(lessened(model, layout, stay, own, found), found, own)
    return max(anew, as_it_was, key=lambda fitted: fitted.log_evidence)


def trusted_in(model: Model) -> list[Unknown]:
    """Own parameters of a model, with their priors there."""
    return [u for u in model.unknowns if u.name.rpartition(".")[0] not in model.names]


def lessened(
    model: Model, layout: Layout, effects: Sequence[Placed], own: Sequence[Unknown], found: Sequence[Filtered]
) -> Model:
    """The refit with some of its effects and of its own unknowns, whose priors may differ.

    From where they are, or where they are likeliest once the others are nothing, as far as the fit is linear: what
    stood beside a large effect is no place to begin from without it.
    """
    left = blank(model.fit, layout, effects, own)
    at = {u.name: i for i, u in enumerate(model.unknowns)}
    stay = [at[u.name] for u in left.unknowns]
    gone = sorted(set(at.values()) - set(stay))
    begins = [model.theta[stay]]
    scale, low, high = (np.array([getattr(u, part) for u in left.unknowns]) for part in ("scale", "low", "high"))
    if stay and model.information is not None:
        before = np.array([u.scale for u in model.unknowns]) ** -2.0
        A = model.information - np.diag(before)
        pull = (before * model.theta)[stay] - scale**-2.0 * begins[0] + A[np.ix_(stay, gone)] @ model.theta[gone]
        moved = np.linalg.solve(A[np.ix_(stay, stay)] + np.diag(scale**-2.0), pull)
        begins.append(np.clip(begins[0] + moved, low, high))
    e = model.fit.residuals([left.vector(theta) for theta in begins], found)
    cost = [float(row @ row + np.sum((theta / scale) ** 2)) for row, theta in zip(e.T, begins, strict=True)]
    return refit(left, found, begins[int(np.argmin(cost))])
