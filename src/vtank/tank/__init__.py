"""The virtual tank: MuJoCo with the water's forces in a compiled callback."""

from __future__ import annotations

from .installation import forces
from .model import load_model
from .tank import Tank, prepare

__all__ = ["Tank", "forces", "load_model", "prepare"]
