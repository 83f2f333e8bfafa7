"""What is usual at a place of a vehicle: speeds, forces and inputs, from which effects state their usual sizes."""

from __future__ import annotations

import numpy as np

from ...plant.vehicle import AXES, Vehicle

U_M_S, U_RAD_S = 0.4, 0.3  # usual speeds, choices


class Usual:
    """Usual values at a place.

    Attributes:
        u: speed along the axis, or ahead [m/s or rad/s]. force: drag at it, or of the thruster [N or N m].
        input: of the thruster, in its unit. mass: by which sway is heavier than surge [kg].
        hull: half its length [m]. weight: of the displaced water [N].
    """

    def __init__(self, vehicle: Vehicle, kind: str, place: str) -> None:
        """kind, place: as of an effect."""
        axis = AXES.index(place) if kind == "axis" else 0
        self.u = U_M_S if axis < 3 else U_RAD_S
        drag = vehicle.linear_drag[axis] * self.u + vehicle.quadratic_drag[axis] * self.u**2
        self.force, self.input = max(float(drag), 1e-3), 1.0
        self.mass = vehicle.mass_kg + float(vehicle.added_mass[1, 1] - vehicle.added_mass[0, 0])
        self.hull, self.weight = max(abs(end) for end in vehicle.ends_m), vehicle.buoyancy_N
        if kind == "thruster":
            thruster = next(t for t in vehicle.thrusters if place in (t.name, t.site))
            self.force = 0.4 * thruster.most_N(1.0)
            self.input = float(thruster.input_for(np.array([self.force]))[0])
