"""The planar equations of motion: surge, sway and yaw of a vehicle that neither rolls, pitches nor heaves.

    m_u du/dt = m_v v r        - X_u u - X_uu u|u| + X         north' = u cos psi - v sin psi
    m_v dv/dt = -m_u u r       - Y_v v - Y_vv v|v| + Y         east'  = u sin psi + v cos psi
    m_r dr/dt = (m_u - m_v) u v - N_r r - N_rr r|r| + N         psi'   = r

Masses hold the added mass of their axis; the centre of gravity lies at the body's origin. Each force follows what is
asked of it through a first-order lag, tau dX/dt = X_asked - X.
Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), sections 6.5 and 7.3.
"""

from __future__ import annotations

import math

import numpy as np

from ..compiled import term
from .hooks import unchanged
from .plant import Axis, Parameters, Plant

# name -> (unit, null value)
PARAMETERS = {
    "m_u": ("kg", 1.0), "m_v": ("kg", 1.0), "m_r": ("kg m2", 1.0),
    "X_u": ("N s/m", 0.0), "Y_v": ("N s/m", 0.0), "N_r": ("N m s/rad", 0.0),
    "X_uu": ("N s2/m2", 0.0), "Y_vv": ("N s2/m2", 0.0), "N_rr": ("N m s2/rad2", 0.0),
    "tau": ("s", 0.0),
}  # fmt: skip
M_U, M_V, M_R, X_U, Y_V, N_R, X_UU, Y_VV, N_RR, TAU = range(len(PARAMETERS))


@term
def rates(t, s, n, push, p):
    """d/dt of place, heading, velocity and forces; the forces' lag is solved exactly (`Plant`)."""
    _, _, psi, u, v, r, X, Y, N = s
    cos, sin = math.cos(psi), math.sin(psi)
    du = (p[M_V] * v * r - (p[X_U] + p[X_UU] * abs(u)) * u + X) / p[M_U] + push[0]
    dv = (-p[M_U] * u * r - (p[Y_V] + p[Y_VV] * abs(v)) * v + Y) / p[M_V] + push[1]
    dr = ((p[M_U] - p[M_V]) * u * v - (p[N_R] + p[N_RR] * abs(r)) * r + N) / p[M_R] + push[2]
    return u * cos - v * sin, u * sin + v * cos, r, du, dv, dr, 0.0, 0.0, 0.0


@term
def targets(t, n, p):
    """Forces [N, N, N m] that are asked for."""
    return n


@term
def lags(p):
    """Their time constant [s]."""
    return p[TAU], p[TAU], p[TAU]


@term
def inputs(reading, lone, j, p):
    """Forces of sample j: recorded as they were asked for."""
    return reading[j, 0], reading[j, 1], reading[j, 2]


PLANAR = Plant(
    name="planar",
    states=("north_m", "east_m", "heading_rad", "surge_m_s", "sway_m_s", "yaw_rate_rad_s",
            "surge_N", "sway_N", "yaw_Nm"),
    lagging={"surge_N": "tau", "sway_N": "tau", "yaw_Nm": "tau"},
    axes=(Axis(speed=3), Axis(speed=4), Axis(speed=5)),
    parameters=Parameters(tuple(PARAMETERS), np.array([null for _, null in PARAMETERS.values()])),
    rates=rates,
    targets=targets,
    lags=lags,
    inputs=inputs,
    acts=unchanged,
)  # fmt: skip
