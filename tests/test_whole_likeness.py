"""The law of every effect is the same in the tank and in the diagnosis: fitted alone, it leaves nothing but noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

from vtank.diagnose.whole.model import Model, blank, refit
from vtank.diagnose.whole.score import based, promises
from vtank.diagnose.whole.selection import extended
from vtank.diagnose.whole.sizes import sizes_of
from vtank.experiment import fly_vehicle
from vtank.plant.vehicle import Vehicle, load_vehicle
from vtank.record import Run
from vtank.rigid.filtered import Filtered
from vtank.rigid.fit import Fit
from vtank.rigid.noise import Noise, first_noise
from vtank.rigid.places import catalogue
from vtank.rigid.recordings import record
from vtank.studies.blind.whole.sizes import entries
from vtank.tank.places.catalogue import CATALOGUE
from vtank.tank.places.effect import PlacedEffect
from vtank.tank.places.read import places

SECONDS, SIZE, SEED, ROUNDS = 30.0, 0.3, 5, 10
# gross mistakes are found in another way, test_whole_causes.py; late pings among single samples; a clock ahead is the
# twin of a late instrument; no wall is ahead here (test_whole_wall.py)
ELSEWHERE = {"wrong_unit", "wrong_allocation", "thruster_reversed", "sonar_multipath", "clock_offset", "sonar_offset",
             "wall_proximity"}  # fmt: skip
SIZES = {"tachometer_spikes": 1.0}  # smaller ones drown in what the command itself does
FLOWN = {"axis": "bluerov2", "thruster": "bluerov2", "fin": "remus100", "sensor": "bluerov2", "vehicle": "bluerov2"}
PLACES = {
    "tachometer_spikes": "thruster_1", "depth_offset": "depth", "magnetometer_bias": "ahrs", "earth_axes": "dvl",
    "sensor_scale": "ahrs", "sensor_displaced": "mocap", "wrong_sign": "depth", "sensor_latency": "mocap",
}  # fmt: skip


def cases() -> list[tuple[PlacedEffect, str, str]]:
    found = []
    for effect in CATALOGUE:
        if effect.name not in ELSEWHERE:
            vehicle = load_vehicle(FLOWN[effect.kind])
            there = effect.places if effect.kind == "axis" else places(vehicle)[effect.kind]
            place = PLACES.get(effect.name, "imu" if effect.kind == "sensor" else there[-1])
            found.append((effect, place, vehicle.name))
    return found


def flown(vehicle: Vehicle, effects: dict[str, dict[str, object]]) -> Run:
    commands = multisine(vehicle, SECONDS, 1)
    if vehicle.fins:  # which turn a hull that goes ahead
        commands["propeller_rev_s"] = np.full_like(commands["time_s"], 20.0)
        commands["rudder_rad"] = 0.15 * np.sign(np.sin(0.8 * commands["time_s"]))
    return fly_vehicle(vehicle, commands, SECONDS, 1, depth_m=5.0, effects=effects)


def still(run: Run, vehicle: Vehicle, noise: Noise | None = None) -> tuple[Model, list[Filtered]]:
    """The nominal, at the noise of the instruments, or another, and without a disturbance."""
    layout, seen, _ = record([run], vehicle)
    fit = Fit(seen, noise or replace(first_noise(seen), sigma=np.full(6, 1e-5)))
    model = blank(fit, layout, (), [])
    found = fit.filter(model.vector())
    return refit(model, found, np.zeros(0)), found


def converged(model: Model) -> Model:
    """Filtered and fitted anew for as long as that gains something."""
    for _ in range(ROUNDS):
        before, model = model.cost, refit(model, model.fit.filter(model.vector()), model.theta)
        if model.cost > before - 0.1:
            break
    return model


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "place", "name"), cases(), ids=lambda value: getattr(value, "name", value))
def test_what_the_tank_does_is_fitted_to_the_noise(effect: PlacedEffect, place: str, name: str) -> None:
    vehicle = load_vehicle(name)
    calm, _ = still(flown(vehicle, {}), vehicle)
    values = entries(np.random.default_rng(SEED), effect, place, vehicle, SIZES.get(effect.name, SIZE))
    model, found = still(flown(vehicle, {f"{effect.name}@{place}": values}), vehicle, calm.fit.noise)
    layout, base = model.fit.runs[0].layout, based(model, found)
    sought = [c for c in catalogue(layout, model.fit.runs[0].moves, sizes_of(model, found))
              if (c.effect, c.place) == (effect.name, place)]  # fmt: skip
    fits = [extended(model, base.J, found, layout, p.placed, p.begin) for p in promises(model, base, layout, sought)]
    least = min(converged(fit).cost for fit in fits)
    assert least < calm.cost + 0.02 * found[0].z.size + 5e-4 * (model.cost - calm.cost)
    assert model.cost > least + 3.0
