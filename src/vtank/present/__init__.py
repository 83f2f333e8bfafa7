"""The report of a diagnosis: one HTML file that needs nothing else, and the same findings in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from . import canvas, document
    from .identification import FEET, NAMES, UNITS, Sheet, number, plain_names

__all__ = facade(__name__)
