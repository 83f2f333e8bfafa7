"""Every effect of the catalogue is wired: switched on, it changes what the surge model records, by each parameter."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from vtank.effects.catalogue import CATALOGUE, PARAMETERS
from vtank.effects.effect import Effect
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario
from vtank.experiment.surge_model import simulate_surge
from vtank.plant.parameters import depending_on, indices, slot, switched_on, vector
from vtank.plant.surge import surge_acceleration, thrust_target

# Hard pushes without noise or rounding: whatever differs, an effect has done
SETTINGS = ("duration_s=40", "sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0")
SLOTS = pytest.mark.parametrize("name", PARAMETERS)
EFFECTS = pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.name)


def recording(values: dict[str, float]) -> np.ndarray:
    """Ranges [m] and propeller speeds [rev/s] of the surge model with these slots set, shape (2, T)."""
    scenario = replace(load_scenario("open-loop-sine", SETTINGS), effects=values)
    run = simulate_surge([plan_run(scenario, seed=3)])[0].run
    return np.array([run.columns["range_m"], run.columns["n_rev_s"]])


def moderate(effect: Effect) -> dict[str, float]:
    """Sizes away from the null by the typical one, a limit at it; shapes as they are."""
    values = {}
    for name, q in zip(effect.slots(), effect.parameters, strict=True):
        off = q.scale if q.null + q.scale <= q.bounds[1] else -q.scale
        values[name] = q.null if q.shape else q.scale if q.limit else q.null + off
    return values


def differ(a: np.ndarray, b: np.ndarray) -> bool:
    return not np.allclose(a, b, rtol=0.0, atol=1e-6, equal_nan=True)


@EFFECTS
def test_an_effect_that_is_switched_on_changes_the_recording(effect: Effect) -> None:
    off = {name: PARAMETERS[name].null for name in effect.slots()}
    assert differ(recording(moderate(effect)), recording(off)), f"{effect.name} is registered, but no plant has it"
    assert effect in switched_on(vector(moderate(effect))) and effect not in switched_on(vector(off))


def test_a_recording_differs_by_effects_alone() -> None:
    shapes = {name: q.null + 0.5 * q.scale for name, q in PARAMETERS.items() if q.shape}
    assert not differ(recording({}), recording(shapes))


@SLOTS
def test_each_parameter_of_an_effect_changes_the_recording(name: str) -> None:
    effect = next(effect for effect in CATALOGUE if name in effect.slots())
    on, q = moderate(effect), PARAMETERS[name]
    more = on[name] + 0.5 * q.scale
    changed = more if more <= q.bounds[1] else on[name] - 0.5 * q.scale
    assert differ(recording(on), recording({**on, name: changed})), f"nothing follows {name}"


@EFFECTS
def test_an_effect_depends_on_place_and_time_where_it_says_so(effect: Effect) -> None:
    p = vector({"alpha": -1.0, "beta": 2e-3, **moderate(effect)})

    def acceleration(t: float, x: float) -> tuple[float, float]:
        gap = p[slot("standoff")] - x
        return surge_acceleration(t, x, 0.2, 0.1, 0.05, 6.0, gap, 0.0, p), thrust_target(t, 6.0, p)

    here = acceleration(1.0, 0.1)
    assert (acceleration(1.0, 0.6) != here) == ("place" in effect.depends_on)
    assert (acceleration(4.0, 0.1) != here) == ("time" in effect.depends_on)
    sizes = {i for i, q in zip(indices(effect), effect.parameters, strict=True) if not q.shape}
    assert (sizes <= set(depending_on("place"))) == ("place" in effect.depends_on)
    assert all(math.isfinite(value) for value in here)
