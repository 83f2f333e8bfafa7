"""The virtual tank: a vehicle in the water of vtank.water, moved by the surge equation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from . import render
    from .described import described
    from .prepare import forces, prepare
    from .tank import Tank
    from .whole import Motion, Whole, load_whole
    from .world import load_model, load_world, submerge

__all__ = facade(__name__)
