"""Blind trials of whole vehicles: vehicle, scenarios and what is wrong drawn at random, the truth sealed apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....facade import facade

if TYPE_CHECKING:
    from .case import caused
    from .names import scored_name, true_name

__all__ = facade(__name__)
