"""What the surge controller can follow and withstand: closed-loop response, and station keeping in waves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .parts import RESULTS, Part, frequency_response, station_keeping, write_parts
    from .response import AMPLITUDES_M

__all__ = facade(__name__)
