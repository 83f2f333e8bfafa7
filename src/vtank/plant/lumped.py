"""Lumped surge parameters from masses and coefficients; feet and SI.

The surge balance of a neutrally buoyant vehicle with moving mass M = m - X_udot [kg] is

    M du/dt = -D u|u| + T n|n| - L |n| u

Divided by M it is the paper's Model III (S0, eqs. (3)-(5)):

    alpha = -D/M [1/m]      beta = T/M [m/rev2]      gamma = -L/M [1/rev]

so alpha < 0, beta > 0 and gamma <= 0; the lag tau [s] passes through. The paper prints a = alpha in 1/ft and b = beta
in ft/rev2; gamma [1/rev] and tau [s] read the same in both systems.

T and L follow from a linear open-water curve KT(J) = KT0 - KT1 J, J = u/(n d), of k propellers of diameter d [m] in
water of density rho [kg/m3]: thrust k rho n|n| d^4 KT gives T = k rho d^4 KT0 and L = k rho d^3 KT1. (Wake fraction
and thrust deduction are taken as nil.)
"""

from __future__ import annotations

from dataclasses import dataclass

from ..units import FOOT_M


@dataclass(frozen=True)
class Lumped:
    """Parameters of the surge equation: alpha [1/m], beta [m/rev2], gamma [1/rev], tau [s]."""

    alpha_per_m: float
    beta_m_per_rev2: float
    gamma_per_rev: float
    tau_s: float


def lump(moving_mass_kg: float, drag: float, thrust: float, loss: float, tau_s: float) -> Lumped:
    """Divide the surge balance, D [N/(m/s)2], T [N/(rev/s)2], L [N/(rev/s m/s)], by the moving mass M."""
    return Lumped(-drag / moving_mass_kg, thrust / moving_mass_kg, -loss / moving_mass_kg, tau_s)


def propeller_forces(
    count: int, diameter_m: float, kt0: float, kt1: float, density_kg_m3: float
) -> tuple[float, float]:
    """Bollard thrust T [N/(rev/s)2] and thrust loss L [N/(rev/s m/s)] of all propellers together."""
    scale = count * density_kg_m3 * diameter_m**3
    return scale * diameter_m * kt0, scale * kt1


def from_feet(a_per_ft: float, b_ft_per_rev2: float, gamma_per_rev: float, tau_s: float) -> Lumped:
    """SI parameters from the paper's, as printed in its tables."""
    return Lumped(a_per_ft / FOOT_M, b_ft_per_rev2 * FOOT_M, gamma_per_rev, tau_s)


def to_feet(lumped: Lumped) -> tuple[float, float, float, float]:
    """(a [1/ft], b [ft/rev2], gamma [1/rev], tau [s]) as the paper prints them: the inverse of `from_feet`."""
    return lumped.alpha_per_m * FOOT_M, lumped.beta_m_per_rev2 / FOOT_M, lumped.gamma_per_rev, lumped.tau_s
