"""The catalogue of unmodelled effects: one file per effect, which says all that is to be known about it.

A new effect is a file here that says what it does, and its row in the table of scenarios/README.md
(`vtank effects --markdown`). Everything else asks the catalogue; models/HOWTO.md goes through it step by step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .catalogue import BY_NAME, CATALOGUE, PARAMETERS
    from .effect import Channel, Effect, Parameter

__all__ = facade(__name__)
