"""The free-form model: what is missing from a simulator, without a name for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .dictionary import PROBE_M_S2
    from .motion import drive_frequency, simulated, simulated_tracks
    from .pursuit import OWN, WORTHWHILE, Component, Freeform, pursue

__all__ = facade(__name__)
