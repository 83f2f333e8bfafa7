"""Waves by linear theory in water of finite depth: dispersion, orbital motion of the water, regular and irregular seas.

Axes: x along the waves, z up from the still water, time t. A component is eta = a cos(k x - w t + phase).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .dispersion import breaking_height, wave_number
    from .orbit import Orbit, depth_profile
    from .sea import Waves, orbit

__all__ = facade(__name__)
