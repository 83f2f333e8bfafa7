"""The virtual tank: MuJoCo with the water's forces in a compiled callback."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .installation import forces
    from .tank import Tank, prepare
    from .world import load_model, load_world, submerge

__all__ = facade(__name__)
