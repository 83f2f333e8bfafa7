"""The force of a fin, compiled: lift and drag in the flow that the fin meets, in every Runge-Kutta stage.

    L = rho/2 A U2 CL(alpha),  D = rho/2 A U2 (CD0 + (1 - s) CL tan alpha)

U is the speed of the fin through the water across its axis, alpha the angle from that motion to the chord. CL grows
with the slope up to the stall and from there falls as sin 2 alpha, nothing at right angles. What lift costs in drag is
that of a force at right angles to the chord, up to the stall less the suction s at the leading edge: 0 of a plate, the
default, a choice on the side of drag; 1 of a wing of great span. The propeller's wash is left out.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import term
from ..plant.sixdof import Vector, cross, to_body
from ..water import offsets
from ..water.forces import flow, plus
from ..water.pointers import array_at, numbers, triple, whole, word_at
from .layout import FIN_AT

OFFSETS = offsets.AT


@term
def lift_coefficient(alpha: float, slope: float, stall: float) -> float:
    """CL at an angle of attack [rad] within -pi..pi."""
    if abs(alpha) <= stall:
        return slope * alpha
    return slope * stall * math.sin(2.0 * abs(alpha)) / math.sin(2.0 * stall) * (1.0 if alpha > 0.0 else -1.0)


@term
def cost(alpha: float, lift: float, slope: float, stall: float, suction: float) -> float:
    """(1 - s) CL tan alpha, the drag that comes with lift; written so that it is finite at right angles."""
    if abs(alpha) <= stall:
        return (1.0 - suction) * lift * math.tan(alpha)
    return 2.0 * slope * stall * math.sin(alpha) ** 2 / math.sin(2.0 * stall)


@term
def inner(a: Vector, b: Vector) -> float:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@term
def fin_at(velocity: Vector, user: np.ndarray, angle: float) -> float:
    """Force along the row's direction [N] of a fin that moves through the water at a velocity, body axes [m/s]."""
    axis, ahead = triple(user, FIN_AT.axis), (1.0, 0.0, 0.0)
    side = cross(axis, ahead)  # where a positive angle turns the chord's front
    along, across = inner(velocity, ahead), inner(velocity, side)
    square = along * along + across * across
    if square == 0.0:
        return 0.0
    beyond = angle - math.atan2(across, along)
    alpha = math.atan2(math.sin(beyond), math.cos(beyond))
    lift = lift_coefficient(alpha, user[FIN_AT.lift_per_rad], user[FIN_AT.stall_rad])
    slope, stall = user[FIN_AT.lift_per_rad], user[FIN_AT.stall_rad]
    back = user[FIN_AT.drag] + cost(alpha, lift, slope, stall, user[FIN_AT.suction])
    direction = triple(user, FIN_AT.along)
    forward, sideward = inner(direction, ahead), inner(direction, side)
    # lift is square to the motion, towards the side; drag against the motion
    speed = math.sqrt(square)
    force = lift * (along * sideward - across * forward) - back * (along * forward + across * sideward)
    return user[FIN_AT.pressure_area] * speed * force


@term
def fin_force(model: int, data: int, user: np.ndarray, angle: float) -> float:
    """Force along the row's direction [N] of a fin on a free body."""
    body = int(user[FIN_AT.body])
    width, time = word_at(model + OFFSETS.nuser_body), array_at(data + OFFSETS.time, 1)[0]
    wet, sea = numbers(model + OFFSETS.body_user, width * body, width), numbers(model + OFFSETS.body_user, 0, width)
    position, rotation = numbers(data + OFFSETS.xpos, 3 * body, 3), numbers(data + OFFSETS.xmat, 9 * body, (3, 3))
    velocity = numbers(data + OFFSETS.qvel, whole(model + OFFSETS.body_dofadr, body + 1)[body], 6)
    x, y, z = flow(wet, sea, time, position, rotation)[0]
    through = to_body(rotation, (velocity[0] - x, velocity[1] - y, velocity[2] - z))
    return fin_at(plus(through, cross(triple(velocity, 3), triple(user, FIN_AT.place_m))), user, angle)
