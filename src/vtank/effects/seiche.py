"""Seiche: a standing wave in the tank moves the water to and fro past the hull.

The water's acceleration presses on the hull as well (Froude-Krylov and added mass forces): for a neutrally buoyant
hull both together make the hull follow the water, du/dt += dU_w/dt.
"""

import math

from ..compiled import law
from .effect import Effect, Parameter


@law
def velocity(t: float, amplitude: float, frequency: float, phase: float) -> float:
    """Water velocity towards the wall [m/s] at time t [s]."""
    return amplitude * math.sin(frequency * t + phase)


@law
def acceleration(t: float, amplitude: float, frequency: float, phase: float) -> float:
    """Acceleration of the water, and with it of a neutrally buoyant hull [m/s2], at time t [s]."""
    return amplitude * frequency * math.cos(frequency * t + phase)


EFFECT = Effect(
    name="seiche",
    channel="hydrodynamics",
    place="surge",
    sentence="A standing wave left in the tank carries the hull to and fro with the water.",
    law="u_r = u - U_w, du/dt += dU_w/dt, U_w = amplitude sin(frequency t + phase)",
    parameters=(
        Parameter("amplitude", "m/s", "amplitude of the water velocity", 0.0, (0.0, 0.5), 0.02),
        Parameter("frequency", "rad/s", "frequency of the standing wave", 1.0, (0.05, 3.0), 0.5, shape=True),
        Parameter("phase", "rad", "phase at the start of the run", 0.0, (-7.0, 7.0), 2.0, per_run=True, shape=True),
    ),
    source="Lamb, Hydrodynamics (1932), standing waves in a basin; Morison equation for the force on a fixed volume",
    order=4,
    confused_with=("ambient_current", "tether"),
    depends_on=("time",),
    in_equation=True,
)
