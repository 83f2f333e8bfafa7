"""The response that one harmonic gives: the loop closed on the first harmonic of the surge equation itself.

Command, position and demand are taken for sinusoids; over one period the propeller speed follows from the demand with
blunting and limit, the force from the surge equation (all its effects but wake and lag), and of that force the first
harmonic balances the vehicle's acceleration. This is the method of describing functions
(Gelb and Vander Velde, Multiple-Input Describing Functions, 1968), with the functions found by quadrature.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import root

from ...compiled import law
from ...experiment import Plan
from ...plant import surge_acceleration, thrust_target
from .loop import TAU, Array, Complex, Loop
from .response import NEAR

POINTS = 256  # of quadrature over a period: the corners of saturation cost 1e-4 of the amplitude; a choice
TURN = np.exp(2j * np.pi * np.arange(POINTS) / POINTS)
BALANCED = 1e-6  # residual of a solution that counts, over the command's acceleration; a choice


@law
def forces(x: Array, u: Array, n: Array, p: Array) -> tuple[Array, Array]:
    """Thrust and the other forces per moving mass [m/s2] at place, speed and propeller speed, shape (POINTS,) each."""
    thrust, rest = np.empty(x.size), np.empty(x.size)
    for j in range(x.size):
        thrust[j] = thrust_target(0.0, n[j], p)
        rest[j] = surge_acceleration(0.0, x[j], u[j], 0.0, 0.0, n[j], 1e9, 0.0, p)
    return thrust, rest


def balance(plan: Plan, amplitude_m: float, rad_s: Array) -> tuple[Complex, Array]:
    """Position over commanded position, and share of time with n at its limit, shape (W,) each.

    NaN where no balance is found. rad_s: ascending; a solution starts from the one before, or from the linear loop's.
    """
    loop, found, shares = Loop(plan), [], []
    command, feedback = loop.controller(rad_s)
    linear, known = loop.response(rad_s), 1.0 + 0.0j
    for i, w in enumerate(rad_s):
        period = (plan, amplitude_m, float(w), command[i], feedback[i])
        response, share = _solve(period, (known, complex(linear[i]), 1.0 + 0.0j))
        known = response if np.isfinite(response) else known
        found.append(response)
        shares.append(share)
    return np.array(found), np.array(shares)


def _solve(period: tuple[Any, ...], starts: tuple[complex, ...]) -> tuple[complex, float]:
    """The response that balances, from the first start that leads to one, NaN where none does; share at the limit."""
    for start in starts:
        solved = root(lambda parts: _left(parts, *period)[0], [start.real, start.imag])
        left, share = _left(solved.x, *period)
        if np.abs(left).max() < BALANCED:
            return complex(*solved.x), share
    return complex(np.nan, np.nan), share


def _left(
    parts: Array, plan: Plan, amplitude_m: float, rad_s: float, command: complex, feedback: complex
) -> tuple[Array, float]:
    """Real and imaginary part of force less acceleration, over the command's, for those of a response.

    Beside them the share of the period with n at its limit.
    """
    response = complex(*parts)
    x, control, h, limit = response * amplitude_m, plan.scenario.control, plan.scenario.period_s, plan.n_limit_rev_s
    signals = (x, 1j * rad_s * x, (command + feedback * response) * amplitude_m)
    place, speed, demand = ((signal * TURN).real for signal in signals)
    blunt = plan.thrust_m_per_rev2 * control.blunt_rev_s * control.blunt_rev_s
    size = plan.thrust_m_per_rev2 * (np.abs(demand) + blunt)
    n = demand / np.sqrt(np.maximum(size, np.finfo(float).tiny))
    thrust, rest = forces(place, speed, np.clip(n, -limit, limit), plan.p)
    hold = (1.0 - np.exp(-1j * rad_s * h)) / (1j * rad_s * h)
    lag = hold / (1.0 + 1j * rad_s * plan.p[TAU])
    force = 2.0 / POINTS * ((thrust @ TURN.conj()) * lag + rest @ TURN.conj())
    left = (force + rad_s**2 * x) / (rad_s**2 * amplitude_m)
    return np.array([left.real, left.imag]), float(np.mean(np.abs(n) >= NEAR * limit))
