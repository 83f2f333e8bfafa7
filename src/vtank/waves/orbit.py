"""The water's orbital motion at one point under waves: a sum of harmonic components, and its sampling in time.

Under eta = a cos(k x - w t + phase) the water at height z (the surface is z = 0, the bed z = -h) moves at

    u = a w cosh k(z + h)/sinh(k h) cos(k x - w t + phase)      along the waves
    v = a w sinh k(z + h)/sinh(k h) sin(k x - w t + phase)      up

A wall across the waves at x = D that reflects the
share r of the amplitude adds the mirrored wave, travelling back.

Source: Dean and Dalrymple (1991), chapters 3 and 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..compiled import law
from .dispersion import Array, wave_number

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Orbit:
    """Velocity of the water at one point, Re sum (along, up) exp(-i w t).

    Attributes:
        rad_s: frequencies w, shape (M,) [rad/s].
        along, up: complex amplitudes, shape (M,) [m/s].
    """

    rad_s: Array
    along: Complex
    up: Complex

    def velocity(self, time_s: Array) -> Array:
        """Along the waves and up at these times, shape (T, 2) [m/s]."""
        return (np.exp(-1j * np.multiply.outer(time_s, self.rad_s)) @ np.transpose([self.along, self.up])).real

    def ticks(self, period_s: float, count: int) -> Array:
        """`velocity` at 0, period, 2 period, ..., shape (count, 2) [m/s], fast."""
        return turned(self.rad_s * period_s, np.array([self.along, self.up]), count)


def point(
    rad_s: Array,
    amplitude: Complex,
    z_m: float,
    water_depth_m: float,
    x_m: float = 0.0,
    wall: tuple[float, float] = (0.0, 0.0),
) -> Orbit:
    """The orbit at (x, z) of waves with complex surface amplitudes a exp(i phase) [m].

    wall: distance D [m] and reflection r of a wall across the waves, by default without reflection.
    """
    k = wave_number(rad_s, water_depth_m)
    cosh, sinh = depth_profile(k, z_m, water_depth_m)
    there = amplitude * np.exp(1j * k * x_m)
    distance, reflection = wall
    back = reflection * amplitude * np.exp(1j * k * (2.0 * distance - x_m))
    return Orbit(rad_s, rad_s * cosh * (there - back), -1j * rad_s * sinh * (there + back))


def depth_profile(k: Array, z_m: float, water_depth_m: float) -> tuple[Array, Array]:
    """cosh k(z + h)/sinh(k h) and sinh k(z + h)/sinh(k h), each (M,); exp(k z) where the water is deep."""
    above, below = np.exp(k * z_m), np.exp(-2.0 * k * (z_m + water_depth_m))
    whole = -np.expm1(-2.0 * k * water_depth_m)
    return above * (1.0 + below) / whole, above * (1.0 - below) / whole


@law
def turned(angle: Array, amplitude: Complex, count: int) -> Array:
    """Re sum amplitude_m exp(-i j angle_m) for j = 0, 1, ..., shape (count, 2): one turn of every phasor per tick."""
    velocity = np.zeros((count, 2))
    for m in range(angle.size):
        turn = np.exp(-1j * angle[m])
        along, up = amplitude[0, m], amplitude[1, m]
        for j in range(count):
            velocity[j, 0] += along.real
            velocity[j, 1] += up.real
            along, up = along * turn, up * turn
    return velocity
