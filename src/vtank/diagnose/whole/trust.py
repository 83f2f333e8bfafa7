"""How good a vehicle file is, only recordings tell: priors of own parameters as wide as these make likely."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .model import Model
from .own import Unknown

Array = NDArray[np.float64]
WIDTHS = (1.0, 0.3, 0.1, 0.03, 0.01, 0.001)  # of priors of own parameters that are tried, as a share of the widest
CLEARLY = 2.0  # log evidence by which a width is less likely than another; a choice
SWEEPS = 2  # through the kinds of own parameters


@dataclass(frozen=True, eq=False)
class _About:
    """A fit's own parameters and its quadratic: evidence at other widths of their priors, by kind.

    own: with their widest priors; they are the first of the model's unknowns.
    """

    model: Model
    own: Sequence[Unknown]

    @cached_property
    def kinds(self) -> list[str]:
        """Masses, drags, gains, lags are trusted alike; what no file states, as it is."""
        return [_quantity(u) for u in self.own]

    @cached_property
    def stated(self) -> list[str]:
        return list(dict.fromkeys(kind for u, kind in zip(self.own, self.kinds, strict=True) if u.stated))

    @cached_property
    def _quadratic(self) -> tuple[Array, Array, Array]:
        scale = np.array([u.scale for u in self.model.unknowns])
        assert self.model.information is not None
        return scale, self.model.information - np.diag(scale**-2.0), scale**-2.0 * self.model.theta

    def narrower(self, widths: Mapping[str, float]) -> list[Unknown]:
        return [replace(u, scale=widths[kind] * u.scale) for u, kind in zip(self.own, self.kinds, strict=True)]

    def evidence(self, widths: Mapping[str, float]) -> float:
        scale, A, pull = self._quadratic
        theta = self.model.theta
        s = np.concatenate([[u.scale for u in self.narrower(widths)], scale[len(self.own) :]])
        H = A + np.diag(s**-2.0)
        end = np.linalg.solve(H, A @ theta + pull)
        move = end - theta
        cost = 0.5 * float(move @ A @ move + np.sum((end / s) ** 2)) - float(pull @ move)
        return -cost - 0.5 * float(np.linalg.slogdet(np.eye(s.size) + A * np.outer(s, s))[1])


def trusted(model: Model, own: Sequence[Unknown]) -> list[Unknown]:
    """Own parameters with priors as wide as this fit makes likely.

    The widest of each kind that is not clearly less likely, lest one number that happens to agree be taken for exact.
    own: with their widest priors.
    """
    if not own or model.information is None:
        return list(own)
    about = _About(model, own)
    widths = dict.fromkeys(about.kinds, 1.0)
    for _ in range(SWEEPS):
        for kind in about.stated:
            tried = [(about.evidence(widths | {kind: width}), width) for width in WIDTHS]
            widths[kind] = max(width for likely, width in tried if likely > max(tried)[0] - CLEARLY)
    return about.narrower(widths)


def _quantity(unknown: Unknown) -> str:
    """What an own parameter is of a vehicle."""
    name = unknown.name.partition("@")[0]
    if not unknown.stated:
        return unknown.name
    return "mass" if name.startswith("added_mass") else "drag" if name.endswith("drag") else name
