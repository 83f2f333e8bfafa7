"""The surge equation of motion, once, for the surge model, the MuJoCo tank and the diagnosis.

    (1 + mass g) du/dt = (1 + drag g) alpha (|u_r| + e u_r) u_r + z + gamma |n_e| u_r
                         - c u_r - f sign(u) - k x - 1.5 mass g/gap u^2 + disturbance  [+ dU_w/dt outside the bracket]
    tau dz/dt          = beta (|n_e| + e n_e) n_e exp(-r t) - z
    T dwake/dt         = k u - wake
    u_r                = u - U - U_w - wake

With every effect at its null value this is the paper's Model III, eqs. (4) and (5) with the cross term gamma u|n|:
du/dt = alpha u|u| + z + gamma |n| u, tau dz/dt = beta n|n| - z; Model II has gamma = 0, Model I also tau = 0.

Symbols: x distance made good ahead [m], u surge speed [m/s], z lagged thrust per unit of moving mass [m/s2],
wake water velocity of the hull's own wake [m/s], n propeller speed [rev/s] held over each sample, gap distance from
the sonar to the wall ahead [m]. The moving mass is m - X_udot.
"""

from __future__ import annotations

import math

from ..compiled import law
from ..effects import (
    coulomb_friction,
    drag_asymmetry,
    linear_drag,
    seiche,
    supply_sag,
    tether,
    thrust_asymmetry,
    thrust_deadband,
    thrust_lag,
    thrust_loss,
    thrust_saturation,
    wake_memory,
    wall_proximity,
)
from .parameters import slot

ALPHA, BETA = slot("alpha"), slot("beta")
LINEAR_INPUT, STANDOFF = slot("linear_input"), slot("standoff")
LINEAR_DRAG = slot("linear_drag.c")
FRICTION = slot("coulomb_friction.f")
CURRENT = slot("ambient_current.U")
SEICHE_U, SEICHE_W, SEICHE_PHASE = slot("seiche.amplitude"), slot("seiche.frequency"), slot("seiche.phase")
WALL_DRAG, WALL_MASS = slot("wall_proximity.drag"), slot("wall_proximity.mass")
TETHER = slot("tether.k")
DRAG_ASYMMETRY = slot("drag_asymmetry.e")
WAKE_K, WAKE_T = slot("wake_memory.k"), slot("wake_memory.T")
DEADBAND, SATURATION = slot("thrust_deadband.n0"), slot("thrust_saturation.n_max")
THRUST_ASYMMETRY = slot("thrust_asymmetry.e")
GAMMA, TAU = slot("thrust_loss.gamma"), slot("thrust_lag.tau")
SAG = slot("supply_sag.r")


@law
def effective_speed(n, p):
    """Propeller speed that makes thrust [rev/s], after saturation and dead-band."""
    return thrust_deadband.effective_speed(thrust_saturation.effective_speed(n, p[SATURATION]), p[DEADBAND])


@law
def thrust_target(t, n, p):
    """Thrust per unit of moving mass [m/s2] that propeller speed n [rev/s] settles to at time t [s]."""
    n_e = effective_speed(n, p)
    if p[LINEAR_INPUT] == 0.0:
        thrust = p[BETA] * thrust_asymmetry.signed_square(n_e, p[THRUST_ASYMMETRY])
    else:
        thrust = p[BETA] * thrust_asymmetry.signed_thrust(n_e, p[THRUST_ASYMMETRY])
    return thrust * supply_sag.factor(t, p[SAG])


@law
def thrust_rate(z, target, p):
    """dz/dt [m/s3]; zero where there is no lag."""
    return thrust_lag.rate(z, target, p[TAU])


@law
def thrust_now(z, target, p):
    """Thrust per unit of moving mass that acts now [m/s2]: z, or the target where there is no lag."""
    return thrust_lag.present(z, target, p[TAU])


@law
def wake_rate(u, wake, p):
    """d wake/dt [m/s2]."""
    return wake_memory.rate(u, wake, p[WAKE_K], p[WAKE_T])


@law
def surge_acceleration(t, x, u, z, wake, n, gap, disturbance, p):
    """du/dt [m/s2]; z is the thrust that acts now (`thrust_now`), disturbance an acceleration [m/s2]."""
    u_r = u - p[CURRENT] - seiche.velocity(t, p[SEICHE_U], p[SEICHE_W], p[SEICHE_PHASE]) - wake
    drag = p[ALPHA] * drag_asymmetry.signed_square(u_r, p[DRAG_ASYMMETRY])
    force = (
        drag * wall_proximity.drag_factor(gap, p[WALL_DRAG])
        + z
        + thrust_loss.acceleration(u_r, effective_speed(n, p), p[GAMMA])
        + linear_drag.acceleration(u_r, p[LINEAR_DRAG])
        + coulomb_friction.acceleration(u, p[FRICTION])
        + tether.acceleration(x, p[TETHER])
        - wall_proximity.inertia_gradient(gap, p[WALL_MASS]) * u * u
        + disturbance
    )
    water = seiche.acceleration(t, p[SEICHE_U], p[SEICHE_W], p[SEICHE_PHASE])
    return force / wall_proximity.inertia_factor(gap, p[WALL_MASS]) + water


@law
def settle(z, target, h, p):
    """Thrust per unit of moving mass [m/s2] after h [s] under a held propeller speed: exact for a first-order lag."""
    return target + (z - target) * math.exp(-h / p[TAU]) if p[TAU] > 0.0 else target


@law
def rates(t, x, u, z, wake, n, disturbance, p):
    """(du, dwake)/dt at propeller speed n [rev/s] and present thrust z [m/s2]; dx/dt is u itself."""
    return surge_acceleration(t, x, u, z, wake, n, p[STANDOFF] - x, disturbance, p), wake_rate(u, wake, p)


@law
def advance(t, h, x, u, z, wake, n, disturbance, p):
    """State (x, u, z, wake) after one step of length h [s]; n and the disturbance are held over it.

    Classical fourth-order Runge-Kutta for x, u and wake; the lag is solved exactly, so that a short time constant
    costs no small steps.
    """
    g = 0.5 * h
    target = thrust_target(t + g, n, p)
    z1 = thrust_now(z, target, p)
    z2 = settle(z1, target, g, p)
    z3 = settle(z2, target, g, p)
    du1, dw1 = rates(t, x, u, z1, wake, n, disturbance, p)
    u2 = u + g * du1
    du2, dw2 = rates(t + g, x + g * u, u2, z2, wake + g * dw1, n, disturbance, p)
    u3 = u + g * du2
    du3, dw3 = rates(t + g, x + g * u2, u3, z2, wake + g * dw2, n, disturbance, p)
    u4 = u + h * du3
    du4, dw4 = rates(t + h, x + h * u3, u4, z3, wake + h * dw3, n, disturbance, p)
    s = h / 6.0
    return (
        x + s * (u + 2.0 * (u2 + u3) + u4),
        u + s * (du1 + 2.0 * (du2 + du3) + du4),
        z3,
        wake + s * (dw1 + 2.0 * (dw2 + dw3) + dw4),
    )
