"""Fisher information of a plan: bounds, correlations, and how far apart effects stay once all else is refitted.

Runs are independent, so their information adds once each run's own unknowns, its initial state, are eliminated.
Cramer, Mathematical Methods of Statistics (1946); Eriksson, Frisk, Krysander, Automatica 49 (2013) for separations:
the length, in deviations of the noise, of what is left of an effect's signature after the refit of everything else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .flown import Array
from .sensitivity import WAVE, Quantity, Sensitivity

NOTHING = 1e-13  # of the largest eigenvalue: a direction with less information has none


@dataclass(frozen=True, eq=False)
class Information:
    """About all quantities, each in units of its reference size.

    Attributes:
        quantities: what the rows stand for.
        matrix: with the runs' initial states eliminated, shape (C, C).
        in_seiche: with a seiche of any size and phase in every run eliminated as well, shape (C, C).
        raw: squared length of each signature before any refit, shape (C, C).
        minutes: of all runs [min].
    """

    quantities: tuple[Quantity, ...]
    matrix: Array
    in_seiche: Array
    raw: Array
    minutes: float

    def __add__(self, other: Information) -> Information:
        minutes = self.minutes + other.minutes
        matrix, in_seiche = self.matrix + other.matrix, self.in_seiche + other.in_seiche
        return Information(self.quantities, matrix, in_seiche, self.raw + other.raw, minutes)

    def index(self, names: Sequence[str]) -> list[int]:
        """Rows of these slots."""
        known = [q.name for q in self.quantities]
        return [known.index(name) for name in names]

    def sizes(self, names: Sequence[str]) -> Array:
        """Reference sizes of these slots [their units]."""
        return np.array([self.quantities[i].size for i in self.index(names)])

    def covariance(self, free: Sequence[str]) -> Array:
        """Cramer-Rao bound of these parameters, nothing else being unknown, shape (F, F), over their sizes."""
        at = self.index(free)
        return np.asarray(inverse(self.matrix[np.ix_(at, at)]))

    def separation(self, of: Sequence[str], refitted: Sequence[str]) -> float:
        """Deviations left of these quantities together, at their sizes, after the refit of the others."""
        matrix = self.in_seiche if WAVE in refitted else self.matrix
        here, others = self.index(of), self.index([name for name in refitted if name != WAVE])
        shared = matrix[np.ix_(others, here)].sum(axis=1)
        change = matrix[np.ix_(here, here)].sum()
        if others:
            change -= shared @ inverse(matrix[np.ix_(others, others)]) @ shared
        return float(np.sqrt(max(change, 0.0)))

    def signature(self, of: Sequence[str]) -> float:
        """Deviations of these quantities together before any refit."""
        here = self.index(of)
        return float(np.sqrt(self.raw[np.ix_(here, here)].sum()))


def inverse(information: Array) -> Array:
    """Pseudo-inverse of a matrix that is symmetric and scaled to unit diagonal first."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    kept = values > NOTHING * values[-1]
    return np.asarray((vectors[:, kept] / values[kept]) @ vectors[:, kept].T / np.outer(scale, scale))


def information(wanted: tuple[Quantity, ...], s: Sensitivity, minutes: float) -> Information:
    """Of one run."""
    basis, _ = np.linalg.qr(s.own / np.maximum(np.linalg.norm(s.own, axis=0), 1e-300))
    left = s.columns - basis @ (basis.T @ s.columns)
    columns, seiche = left[:, :-2], left[:, -2:]
    waves, _ = np.linalg.qr(seiche)
    calm, raw = columns - waves @ (waves.T @ columns), s.columns[:, :-2]
    return Information(wanted, columns.T @ columns, calm.T @ calm, raw.T @ raw, minutes)
