"""How good a vehicle file is, only recordings tell: priors of own parameters as wide as these make likely."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...rigid.filtered import Filtered
from .model import Model, refit
from .own import Unknown

WIDTHS = (1.0, 0.3, 0.1, 0.03, 0.01, 0.001)  # of priors of own parameters that are tried, as a share of the widest
CLEARLY = 2.0  # log evidence by which widths are less likely than others; a choice
SWEEPS = 2  # through the kinds of own parameters


def trusted(model: Model, own: Sequence[Unknown]) -> list[Unknown]:
    """Own parameters with priors as wide as this fit makes likely.

    Those of a kind are trusted alike: masses, drags, gains, lags; the widest that together are not clearly less likely,
    lest one number that happens to agree be taken for exact. own: with their widest priors. The evidence at other
    widths is that of the quadratic about the optimum.
    """
    if not own or model.information is None:
        return list(own)
    scale = np.array([u.scale for u in model.unknowns])
    A, pull = model.information - np.diag(scale**-2.0), scale**-2.0 * model.theta
    rest, kinds = scale[len(own) :], [_quantity(u) for u in own]

    def narrower(widths: Mapping[str, float]) -> list[Unknown]:
        return [replace(u, scale=widths[kind] * u.scale) for u, kind in zip(own, kinds, strict=True)]

    def evidence(widths: Mapping[str, float]) -> float:
        s = np.concatenate([[u.scale for u in narrower(widths)], rest])
        H = A + np.diag(s**-2.0)
        end = np.linalg.solve(H, A @ model.theta + pull)
        move = end - model.theta
        cost = 0.5 * float(move @ A @ move + np.sum((end / s) ** 2)) - float(pull @ move)
        return -cost - 0.5 * float(np.linalg.slogdet(np.eye(s.size) + A * np.outer(s, s))[1])

    stated = dict.fromkeys(kind for u, kind in zip(own, kinds, strict=True) if u.stated)
    alike = [{kind: width if kind in stated else 1.0 for kind in kinds} for width in WIDTHS]
    widths = max(alike, key=evidence)
    for kind in [*stated] * SWEEPS:
        widths = max((widths | {kind: width} for width in WIDTHS), key=evidence)
    enough = evidence(widths) - CLEARLY
    for kind in stated:
        wide = (widths | {kind: width} for width in WIDTHS)
        widths = next(tried for tried in wide if tried == widths or evidence(tried) > enough)
    return narrower(widths)


def retrusted(model: Model, found: Sequence[Filtered], own: Sequence[Unknown]) -> Model:
    """The refit with priors of own parameters as wide as it makes likely; own: with their widest."""
    unknowns = (*trusted(model, own), *model.unknowns[len(own) :])
    return refit(replace(model, unknowns=unknowns), found, model.theta)


def _quantity(unknown: Unknown) -> str:
    """What an own parameter is of a vehicle."""
    name = unknown.name.partition("@")[0]
    if not unknown.stated:
        return unknown.name
    return "mass" if name.startswith("added_mass") else "drag" if name.endswith("drag") else name
