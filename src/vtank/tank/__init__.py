"""The virtual tank: MuJoCo with the water's forces in a compiled callback."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .installation import forces
    from .model import load_model
    from .tank import Tank, prepare

__all__ = facade(__name__)
