"""The response that one harmonic gives: the loop closed on the first harmonic of the surge equation itself.

Command, position and demand are taken for sinusoids; over one period the propeller speed follows from the demand with
blunting and limit, the force from the surge equation (all its effects but wake and lag), and of that force the first
harmonic balances the vehicle's acceleration. This is the method of describing functions
(Gelb and Vander Velde, Multiple-Input Describing Functions, 1968), with the functions found by quadrature.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from ...compiled import law
from ...experiment import Plan
from ...plant import surge_acceleration, thrust_target
from .loop import TAU, Array, Complex, Loop
from .response import NEAR

POINTS = 256  # of quadrature over a period: the corners of saturation cost 1e-4 of the amplitude; a choice
BALANCED = 1e-6  # residual of a solution that counts, over the command's acceleration; a choice


@law
def forces(
    x: Array,
    u: Array,
    demand: Array,
    beta_c: float,
    blunt: float,
    limit: float,
    near: float,
    p: Array,
    thrust: Array,
    rest: Array,
    at_limit: NDArray[np.bool_],
) -> None:
    """Fill thrust and the other forces per moving mass [m/s2], and whether n is `near` its limit, over a period."""
    for j in range(x.size):
        size = beta_c * (abs(demand[j]) + beta_c * blunt * blunt)
        n = demand[j] / np.sqrt(size) if size > 0.0 else 0.0
        at_limit[j] = abs(n) >= near * limit
        n = min(max(n, -limit), limit)
        thrust[j] = thrust_target(0.0, n, p)
        rest[j] = surge_acceleration(0.0, x[j], u[j], 0.0, 0.0, n, 1e9, 0.0, p)


def balance(plan: Plan, amplitude_m: float, rad_s: Array) -> tuple[Complex, Array]:
    """Position over commanded position, and share of time with n at its limit, shape (W,) each.

    NaN where no balance is found. rad_s: ascending; a solution starts from the one before, or from the linear loop's.
    """
    loop, found, shares = Loop(plan), [], []
    command, feedback = loop.controller(rad_s)
    linear, known = loop.response(rad_s), 1.0 + 0.0j
    for i, w in enumerate(rad_s):
        period = _Period(plan, float(w), amplitude_m)
        found.append(_solve(period, command[i], feedback[i], (known, complex(linear[i]), 1.0 + 0.0j)))
        shares.append(float(period.at_limit.mean()))
        known = found[-1] if np.isfinite(found[-1]) else known
    return np.array(found), np.array(shares)


def _solve(period: _Period, command: complex, feedback: complex, starts: tuple[complex, ...]) -> complex:
    """The response that balances, from the first start that leads to one; NaN where none does."""
    for start in starts:
        solved = root(period.residual, [start.real, start.imag], (command, feedback))
        if np.abs(period.residual(solved.x, command, feedback)).max() < BALANCED:
            return complex(*solved.x)
    return complex(np.nan, np.nan)


class _Period:
    """One period of the loop at an amplitude and a frequency."""

    def __init__(self, plan: Plan, rad_s: float, amplitude_m: float) -> None:
        self.plan, self.w, self.amplitude = plan, rad_s, amplitude_m
        self.turn = np.exp(2j * np.pi * np.arange(POINTS) / POINTS)
        self.thrust, self.rest = np.empty(POINTS), np.empty(POINTS)
        self.at_limit = np.zeros(POINTS, dtype=np.bool_)
        h = plan.scenario.period_s
        hold = (1.0 - np.exp(-1j * rad_s * h)) / (1j * rad_s * h)
        self.lag = hold / (1.0 + 1j * rad_s * plan.p[TAU])

    def residual(self, parts: Array, command: complex, feedback: complex) -> Array:
        """Real and imaginary part of force less acceleration, over the command's, for those of a response."""
        response = complex(parts[0], parts[1])
        x = response * self.amplitude
        demand = (command + feedback * response) * self.amplitude
        control = self.plan.scenario.control
        forces(
            (x * self.turn).real,
            (1j * self.w * x * self.turn).real,
            (demand * self.turn).real,
            control.thrust_m_per_rev2,
            control.blunt_rev_s,
            self.plan.n_limit_rev_s,
            NEAR,
            self.plan.p,
            self.thrust,
            self.rest,
            self.at_limit,
        )
        force = 2.0 / POINTS * ((self.thrust @ self.turn.conj()) * self.lag + self.rest @ self.turn.conj())
        left = (force + self.w**2 * x) / (self.w**2 * self.amplitude)
        return np.array([left.real, left.imag])
