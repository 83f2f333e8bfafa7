"""The surge equation of motion, once, for the surge model, the MuJoCo tank and the diagnosis.

    (1 + mass g) du/dt = (1 + drag g) alpha (|u_r| + e u_r) u_r + z + gamma |n_e| u_r
                         - c u_r - f sign(u) - k x - 1.5 mass g/gap u^2 + law + disturbance
                         [+ dU_w/dt outside the bracket]
    tau dz/dt          = beta (|n_e| + e n_e) n_e exp(-r t) - z
    T dwake/dt         = k u - wake, or the memory of `law`, a product of factors that is data (law.py)
    u_r                = u - U - U_w - wake

With every effect at its null value this is the paper's Model III, eqs. (4) and (5) with the cross term gamma u|n|:
du/dt = alpha u|u| + z + gamma |n| u, tau dz/dt = beta n|n| - z; Model II has gamma = 0, Model I also tau = 0.

Symbols: x distance made good ahead [m], u surge speed [m/s], z lagged thrust per unit of moving mass [m/s2],
wake water velocity of the hull's own wake [m/s], n propeller speed [rev/s] held over each sample, gap distance from
the sonar to the wall ahead [m]. The moving mass is m - X_udot.
"""

from __future__ import annotations

import math

from ..compiled import term
from ..effects import (
    drag_asymmetry,
    seiche,
    supply_sag,
    thrust_asymmetry,
    thrust_deadband,
    thrust_lag,
    thrust_saturation,
    wake_memory,
    wall_proximity,
)
from ..effects.catalogue import CATALOGUE
from . import law
from .hooks import acting_on, added, chained, shifting
from .parameters import LAG, NAMES, null_vector, slot
from .plant import Axis, Parameters, Plant

ALPHA, BETA = slot("alpha"), slot("beta")
LINEAR_INPUT, FORCE_OFFSET, STANDOFF = slot("linear_input"), slot("force_offset"), slot("standoff")
LINEAR_DRAG = slot("linear_drag.c")
CURRENT = slot("ambient_current.U")
SEICHE_U, SEICHE_W, SEICHE_PHASE = slot("seiche.amplitude"), slot("seiche.frequency"), slot("seiche.phase")
WALL_DRAG, WALL_MASS = slot("wall_proximity.drag"), slot("wall_proximity.mass")
DRAG_ASYMMETRY = slot("drag_asymmetry.e")
WAKE_K, WAKE_T = slot("wake_memory.k"), slot("wake_memory.T")
DEADBAND, SATURATION = slot("thrust_deadband.n0"), slot("thrust_saturation.n_max")
THRUST_ASYMMETRY = slot("thrust_asymmetry.e")
TAU = slot("thrust_lag.tau")
SAG = slot("supply_sag.r")
LAW, FACTORS, MEMORY = slot("law.force"), slot("law.variable1"), slot("law.memory_kind")
MEMORY_END = slot("law.memory_b") + 1


@term
def effective_speed(n, p):
    """Propeller speed that makes thrust [rev/s], after saturation and dead-band."""
    return thrust_deadband.effective_speed(thrust_saturation.effective_speed(n, p[SATURATION]), p[DEADBAND])


@term
def thrust_target(t, n, p):
    """Thrust per unit of moving mass [m/s2] that propeller speed n [rev/s] settles to at time t [s]."""
    n_e = effective_speed(n, p)
    thrust = thrust_asymmetry.signed_square(n_e, p[THRUST_ASYMMETRY])
    if p[LINEAR_INPUT] != 0.0:
        thrust = thrust + p[LINEAR_INPUT] * (thrust_asymmetry.signed_thrust(n_e, p[THRUST_ASYMMETRY]) - thrust)
    return p[BETA] * thrust * supply_sag.factor(t, p[SAG])


@term
def thrust_rate(z, target, p):
    """dz/dt [m/s3]; zero where there is no lag."""
    return thrust_lag.rate(z, target, p[TAU])


@term
def thrust_now(z, target, p):
    """Thrust per unit of moving mass that acts now [m/s2]: z, or the target where there is no lag."""
    return thrust_lag.present(z, target, p[TAU])


@term
def wake_rate(u, wake, p):
    """d wake/dt [m/s2]."""
    return wake_memory.rate(u, wake, p[WAKE_K], p[WAKE_T])


@term
def memory_rate(t, x, u, z, wake, n, p):
    """d/dt of what the state `wake` holds: the hull's wake, or the memory of a law that has one."""
    if p[MEMORY] != 0.0:
        return law.memory_rate(t, x, u, z, wake, n, p[MEMORY:MEMORY_END])
    return wake_rate(u, wake, p)


@term
def law_product(t, x, u, z, wake, n, gap, acceleration, p):
    """Product of the factors of a law that is data, in SI."""
    fresh = 0.0 * u
    if p[MEMORY] != 0.0:
        now = law.driven(t, x, u, z, n, p[MEMORY:MEMORY_END])
        fresh, wake = now - wake, law.recalled(wake, now, p[MEMORY:MEMORY_END])
    return law.product(t, x, u, z, wake, n, gap, acceleration, fresh, p[FACTORS:MEMORY])


SYMBOLS = {name: name for name in ("t", "x", "u", "u_r", "z", "n", "gap")} | {"n_e": "effective_speed(n, p)"}
with_forces = added((*acting_on("thruster"), *acting_on("surge")), SYMBOLS, {"effective_speed": effective_speed})


@term
def surge_acceleration(t, x, u, z, wake, n, gap, disturbance, p):
    """du/dt [m/s2]; z is the thrust that acts now (`thrust_now`), disturbance an acceleration [m/s2].

    A term whose effect is at its null value is skipped, for speed: it would add nothing.
    """
    u_r = u
    if p[CURRENT] != 0.0:
        u_r = u_r - p[CURRENT]
    if p[SEICHE_U] != 0.0:
        u_r = u_r - seiche.velocity(t, p[SEICHE_U], p[SEICHE_W], p[SEICHE_PHASE])
    if p[MEMORY] == 0.0:  # else it is a law's memory; without a wake it is zero
        u_r = u_r - wake
    drag = p[ALPHA] * drag_asymmetry.signed_square(u_r, p[DRAG_ASYMMETRY])
    if p[WALL_DRAG] != 0.0:
        drag = drag * wall_proximity.drag_factor(gap, p[WALL_DRAG])
    force = drag + z
    force = with_forces(force, t, x, u, u_r, z, n, gap, p)
    if p[WALL_MASS] != 0.0:
        force = force - wall_proximity.inertia_gradient(gap, p[WALL_MASS]) * u * u
    if p[LAW] != 0.0:
        force = force + p[LAW] * law_product(t, x, u, z, wake, n, gap, force, p)
    force = force + disturbance
    if p[WALL_MASS] != 0.0:
        force = force / wall_proximity.inertia_factor(gap, p[WALL_MASS])
    if p[SEICHE_U] != 0.0:
        force = force + seiche.acceleration(t, p[SEICHE_U], p[SEICHE_W], p[SEICHE_PHASE])
    return force


@term
def settle(z, target, h, p):
    """Thrust per unit of moving mass [m/s2] after h [s] under a held propeller speed: exact for a first-order lag."""
    return target + (z - target) * math.exp(-h / p[TAU]) if p[TAU] > 0.0 else target


@term
def rates(t, s, n, push, p):
    """d/dt of (x, u, z, wake) at present thrust z [m/s2]; the lag itself is solved exactly (`Plant`)."""
    x, u, z, wake = s
    du = surge_acceleration(t, x, u, z, wake, n[0], p[STANDOFF] - x, push[0], p)
    return u, du, 0.0, memory_rate(t, x, u, z, wake, n[0], p)


@term
def targets(t, n, p):
    """Thrust that the lag settles to [m/s2]."""
    return (thrust_target(t, n[0], p),)


@term
def lags(p):
    """Its time constant [s]."""
    return (p[TAU],)


behind = chained(CATALOGUE[::-1], "true_input", "lone, ")


@term
def inputs(reading, lone, j, p):
    """Input behind recorded sample j: what the tachometer, or a transducer of force, added is taken off."""
    return (behind(reading[j], lone[j], p) - p[FORCE_OFFSET],)


SURGE = Plant(
    name="surge",
    states=("x_m", "u_m_s", "z_m_s2", "wake_m_s"),
    lagging={"z_m_s2": LAG},
    axes=(Axis(speed=1, place=0),),
    parameters=Parameters(NAMES, null_vector()),
    rates=rates,
    targets=targets,
    lags=lags,
    inputs=inputs,
    acts=chained(CATALOGUE[::-1], "acts"),
    shifting=shifting(),
)
