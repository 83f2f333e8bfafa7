"""Loops that hold or move one axis, with gains from the vehicle: a bandwidth places the poles.

    m x'' + d x' + k x = F:   F = -kp e - kd e' - ki int(e), all poles of the place near w:
        (s + w)^2 (s + INTEGRAL w) = s^3 + (d + kd)/m s^2 + (k + kp)/m s + ki/m
    m u' + d u = F:           F = -kp e - ki int(e), both poles of the speed at w: (s + w)^2

Of the vehicle file come mass with added mass, linear drag, and the stiffness at the present speed: buoyancy rights
roll and pitch, the Munk moment of a slender hull turns it across the flow and its fins turn it back, both with the
square of the speed. Of a hull that turns over by itself w is raised, as far as what is late allows, until the loop is
twice as stiff as what turns it. Drag at the ordered speed is sent ahead. A rate that nothing measures is observed: the
same equation, driven by the ordered force, corrected by the place. Each loop knows one axis; what the drift of a hull
under way does to its heading it does not know, so that there the gain at w is 1.5 to 1.8, at rest 1.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

INTEGRAL = 0.2  # of the bandwidth: the pole of the integral; a choice
OBSERVER = 2.0  # of the bandwidth: both poles of an observer; a choice


@dataclass
class Loop:
    """PID on a place, or PI on a speed, along one axis.

    Attributes:
        mass: with added mass [kg, kg m2]. linear, quadratic: drag. rights: stiffness at rest [N m/rad].
        per_square: stiffness that comes with the square of the speed [N m/rad/(m/s)2].
        bandwidth_rad_s: w. most_rad_s: that w is raised to at most.
        integral: of the error over time. rate: observed rate of the error; error: observed error.
    """

    mass: float
    linear: float
    quadratic: float
    rights: float
    per_square: float
    bandwidth_rad_s: float
    of_speed: bool
    most_rad_s: float = 0.0
    integral: float = 0.0
    error: float | None = None
    rate: float = 0.0

    def force(self, error: float, rate: float, surge_m_s: float) -> float:
        """Force or moment against an error of the place [m or rad] and of its rate, or against one of the speed."""
        m, w = self.mass, self.bandwidth_rad_s
        if self.of_speed:
            return -max(2.0 * m * w - self.linear, 0.0) * error - m * w * w * self.integral
        stiffness = self.rights + self.per_square * surge_m_s**2
        w = max(w, min(self.most_rad_s, math.sqrt(max(-stiffness, 0.0) / (m * (1.0 + 2.0 * INTEGRAL)))))
        kp = max(m * w * w * (1.0 + 2.0 * INTEGRAL) - stiffness, 0.0)
        kd = max(m * w * (2.0 + INTEGRAL) - self.linear, 0.0)
        return -kp * error - kd * rate - INTEGRAL * m * w**3 * self.integral

    def ahead(self, place: float, speed: float) -> float:
        """What an ordered place and speed need in any case: drag, and the stiffness of the hull."""
        stiff = 0.0 if self.of_speed else self.rights * place
        return stiff + (self.linear + self.quadratic * abs(speed)) * speed

    def observe(self, error: float, force: float, step_s: float) -> float:
        """Rate of the error [per s], from readings of it and the force that was ordered since the last one."""
        if self.error is None:
            self.error = error
        w = OBSERVER * self.bandwidth_rad_s
        gone, off = self.rate * step_s, error - self.error
        pushed = (force - (self.linear + self.quadratic * abs(self.rate)) * self.rate) / self.mass
        self.error += gone + 2.0 * w * step_s * off
        self.rate += step_s * (pushed + w * w * off)
        return self.rate
