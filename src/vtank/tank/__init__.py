"""The virtual tank: MuJoCo with the water's forces in a compiled callback."""

from __future__ import annotations

from .installation import forces
from .tank import Tank, prepare
from .world import load_model, load_world, submerge

__all__ = ["Tank", "forces", "load_model", "load_world", "prepare", "submerge"]
