"""What the instruments of a whole vehicle read of its motion, each at its place and turned as it is mounted."""

from __future__ import annotations

import math

from ..compiled import lean, term
from ..plant.sixdof import cross
from ..record.columns import ATTITUDE, MOTION
from .layout import BEARING, BIAS, COLUMN, EARTH, FIN, HULL, ROTATED, SCALE, SENSOR, SITE, THRUSTER, G
from .motion import back, rotation, triple, turned

CHANNELS = tuple(MOTION)
ANGLES = tuple(CHANNELS.index(name) for name in ATTITUDE)
RANGE, POSITION, NORTH, ROLL, SURGE, ROLL_RATE, ACCEL = (
    CHANNELS.index(name) for name in
    ("range_m", "position_m", "north_m", "roll_rad", "surge_m_s", "roll_rate_rad_s", "accel_x_m_s2")
)  # fmt: skip


@term
def pick(v, i):
    """Entry i of three."""
    return v[0] if i == 0 else v[1] if i == 1 else v[2]


@lean
def read(kind, sensor, column, x, rate, p, counts, home, wall, bearing):
    """Reading of channel `kind` by an instrument, in the state x, shape (12,), which changes at `rate`, shape (12,).

    home: north and east of the start [m]; wall: distance from there, ahead at the heading `bearing`, to the wall [m],
    which stands about square to it.
    """
    i = HULL + THRUSTER * counts[0] + FIN * counts[1] + SENSOR * sensor
    c = HULL + THRUSTER * counts[0] + FIN * counts[1] + SENSOR * counts[2] + COLUMN * column
    seat, w = triple(p, i + SITE), (x[9], x[10], x[11])
    value = 0.0
    if kind <= POSITION or NORTH <= kind < ROLL:
        R = rotation(x[3], x[4], x[5])
        arm = turned(R, seat)
        if kind >= NORTH:
            value = x[kind - NORTH] + pick(arm, kind - NORTH)
        else:
            bearing += p[i + BEARING]
            made = (x[0] - home[0] + arm[0]) * math.cos(bearing) + (x[1] - home[1] + arm[1]) * math.sin(bearing)
            value = (
                made
                if kind == POSITION
                else (wall * math.cos(p[i + BEARING]) - made) / (R[0] * math.cos(bearing) + R[3] * math.sin(bearing))
            )
    elif kind < SURGE:
        if p[i + ROTATED] == 0.0 and p[i + ROTATED + 1] == 0.0 and p[i + ROTATED + 2] == 0.0:
            value = x[3 + kind - ROLL]
        else:
            R, S = rotation(x[3], x[4], x[5]), rotation(p[i + ROTATED], p[i + ROTATED + 1], p[i + ROTATED + 2])
            ahead = turned(R, (S[0], S[3], S[6]))
            side, down = turned(R, (S[1], S[4], S[7])), turned(R, (S[2], S[5], S[8]))
            if kind == ROLL:
                value = math.atan2(side[2], down[2])
            elif kind == ROLL + 1:
                value = -math.asin(max(min(ahead[2], 1.0), -1.0))
            else:
                value = math.atan2(ahead[1], ahead[0])
            value += 2.0 * math.pi * round((x[3 + kind - ROLL] - value) / (2.0 * math.pi))
        if p[c + SCALE] != 1.0:  # it is within a turn that an instrument makes something else of an angle
            value -= 2.0 * math.pi * round(value / (2.0 * math.pi))
    else:
        S = rotation(p[i + ROTATED], p[i + ROTATED + 1], p[i + ROTATED + 2])
        if kind < ROLL_RATE:
            v = cross(w, seat)
            v = (x[6] + v[0], x[7] + v[1], x[8] + v[2])
            value = pick(back(S, v), kind - SURGE)
            if p[i + EARTH] != 0.0:
                over = turned(rotation(x[3], x[4], x[5]), v)
                value += p[i + EARTH] * (pick(over, kind - SURGE) - value)
        elif kind < ACCEL:
            value = pick(back(S, w), kind - ROLL_RATE)
        else:
            R = rotation(x[3], x[4], x[5])
            swing, spin = cross(w, (x[6], x[7], x[8])), cross((rate[9], rate[10], rate[11]), seat)
            inward = cross(w, cross(w, seat))
            a = (
                rate[6] + swing[0] + spin[0] + inward[0] - G * R[6],
                rate[7] + swing[1] + spin[1] + inward[1] - G * R[7],
                rate[8] + swing[2] + spin[2] + inward[2] - G * R[8],
            )
            value = pick(back(S, a), kind - ACCEL)
    return p[c + SCALE] * value + p[c + BIAS]
