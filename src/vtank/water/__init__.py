"""Water for any MuJoCo model: exact added mass, drag, buoyancy, current and waves on every wet body."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .add import add
    from .body import Body
    from .constants import set_const
    from .installation import forces
    from .shapes import ellipsoid, ellipsoids

__all__ = facade(__name__)
