"""What a diagnosis found, in numbers: sizes of effects and the simulator's own parameters, in the unit of the input.

A fit sees forces per unit of moving mass. Where the mass is known, from the vehicle or because the input is a force,
they are told in N as well, under the key `force`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..effects.catalogue import BY_NAME
from ..estimate import NORMAL95
from ..plant.parameters import slot, unit_of
from .evidence import Fitted
from .selection import Selection
from .verdict import Verdict

FORCES = {"m/s2": "N", "1/s": "N s/m", "1/m": "N s2/m2", "1/s2": "N/m", "m/rev2": "N s2/rev2"}  # unit -> times kg


def estimates(verdict: Verdict, mass_kg: float | None = None) -> dict[str, dict[str, Any]]:
    """Sizes of the named effects with 95 % intervals, by effect and parameter."""
    fit, out = verdict.fit, {}
    for effect in fit.hypothesis.effects:
        found = {q.name: _told(fit, f"{effect.name}.{q.name}", mass_kg) for q in effect.parameters}
        out[effect.name] = {name: told for name, told in found.items() if told}
    return out


def own_parameters(selection: Selection, verdict: Verdict, mass_kg: float | None = None) -> dict[str, dict[str, Any]]:
    """The simulator's own parameters: as it is, refitted and in the diagnosed simulator, by slot."""
    fits = {"nominal": selection.nominal, "refit": selection.refit, "diagnosed": verdict.fit}
    vectors, out = {name: fit.vector() for name, fit in fits.items()}, {}
    for name in selection.refit.problem.free:
        out[name] = {key: float(p[slot(name)]) for key, p in vectors.items()} | {"unit": _unit(name, verdict.fit)}
        out[name] |= {k: v for k, v in _told(verdict.fit, name, mass_kg).items() if k in ("force", "mass")}
    return out


def _told(fit: Fitted, name: str, mass_kg: float | None) -> dict[str, Any]:
    """A parameter of a fit: value, 95 % interval within its bounds, unit, force; nothing where it was not estimated."""
    unit = _unit(name, fit)
    if name in fit.extra:
        return {"value": fit.extra[name], "interval95": None, "unit": unit}
    if name not in fit.problem.free:
        return {}
    i = fit.problem.free.index(name)
    bounds = float(fit.prior.low[i]), float(fit.prior.high[i])
    told = _sized(float(fit.optimum.theta[i]), float(np.sqrt(fit.covariance()[i, i])), unit, bounds)
    return told | _in_newton(fit, name, unit, mass_kg)


def _in_newton(fit: Fitted, name: str, unit: str, mass_kg: float | None) -> dict[str, Any]:
    """What makes a force per unit of moving mass, times that mass; the thrust gain of a force is one over the mass."""
    theta, free, gain_slot = fit.optimum.theta, fit.problem.free, "beta"
    i, measured = free.index(name), fit.problem.runs[0].input_name == "thrust_N" and gain_slot in free
    slope = np.zeros(theta.size)
    if measured:
        b = free.index(gain_slot)
        if name == gain_slot:
            slope[b] = -1.0 / theta[b] ** 2
            return {"mass": _sized(1.0 / theta[b], _sd(fit, slope), "kg")}
        slope[i], slope[b] = 1.0 / theta[b], -theta[i] / theta[b] ** 2
        mass_kg = 1.0 / theta[b]
    elif mass_kg is not None:
        slope[i] = mass_kg
    force = name in ("alpha", gain_slot) or ("." in name and BY_NAME[name.split(".")[0]].channel == "hydrodynamics")
    if mass_kg is None or not force or unit not in FORCES:
        return {}
    return {"force": _sized(mass_kg * theta[i], _sd(fit, slope), FORCES[unit])}


def _sd(fit: Fitted, slope: np.ndarray) -> float:
    """Deviation of something that goes with the unknowns by this slope, shape (size,)."""
    return float(np.sqrt(slope @ fit.covariance() @ slope))


def _sized(value: float, sd: float, unit: str, bounds: tuple[float, float] = (-np.inf, np.inf)) -> dict[str, Any]:
    low, high = np.clip([value - NORMAL95 * sd, value + NORMAL95 * sd], *bounds)
    return {"value": float(value), "interval95": [float(low), float(high)], "unit": unit}


def _unit(name: str, fit: Fitted) -> str:
    return unit_of(name, fit.problem.runs[0].input_name)
