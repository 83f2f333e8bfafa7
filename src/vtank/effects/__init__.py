"""The catalogue of unmodelled effects: one file per effect, each with its law, parameters and source."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .catalogue import BY_NAME, CATALOGUE
    from .effect import Channel, Effect, Parameter

__all__ = facade(__name__)
