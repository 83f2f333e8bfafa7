"""The equations of motion and the numbers that go into them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .actuators import Fin, Thruster
    from .lumped import Lumped, to_feet
    from .parameters import LAG, LOSS, LUMPED, NAMES, indices, null_vector, slot, switched_on, vector
    from .sensor import Sensor
    from .surge import ALPHA, BETA, LINEAR_DRAG, STANDOFF, TAU, surge_acceleration, thrust_target
    from .truth import Truth, load_truth
    from .vehicle import Vehicle, load_vehicle

__all__ = facade(__name__)
