"""The report of a diagnosis: one HTML file that needs nothing else, and the same findings in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from . import canvas, document, pictures_budget, sections, svg, vehicle_picture, whole, words, words_budget
    from .blocks import Bars, Block, Drawing, Film, Heading, Links, Paragraph, Picture, Table, Terms
    from .identification import FEET, NAMES, UNITS, plain_names
    from .numbers import fixed, number
    from .words import effect_name, listed

__all__ = facade(__name__)
