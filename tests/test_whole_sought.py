"""Whatever the tank can switch on at a place, the diagnosis looks for there."""

from __future__ import annotations

import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.experiment import fly_vehicle
from vtank.rigid.places import Sizes, catalogue
from vtank.rigid.recordings import record
from vtank.tank.places.catalogue import CATALOGUE
from vtank.tank.places.read import places

# of a standing wave the frequency is found first, and late pings are sought among single samples
NOT_HERE = {"seiche", "sonar_multipath"}
WITHOUT_PLACE = {"roll_rad", "pitch_rad", "heading_rad", "roll_rate_rad_s", "pitch_rate_rad_s", "yaw_rate_rad_s"}


@pytest.mark.parametrize("name", ["bluerov2", "phoenix", "kingfisher", "remus100"])
def test_every_effect_at_every_place_is_sought(name: str) -> None:
    vehicle = vt.load_vehicle(name)
    layout, (run,), _ = record([fly_vehicle(vehicle, multisine(vehicle, 5.0, 1), 5.0, 1, depth_m=5.0)], vehicle)
    sought = {f"{c.effect}@{c.place}" for c in catalogue(layout, run.moves, Sizes.unit(layout))}
    channels = {sensor.name: set(sensor.channels) for sensor in vehicle.sensors}
    for effect in CATALOGUE:
        for place in places(vehicle)[effect.kind]:
            seen = channels.get(place, set())
            unseen = effect.kind == "sensor" and (
                place not in layout.sensors
                or bool(effect.channels)
                and not seen & set(effect.channels)
                or effect.name == "sensor_displaced"
                and seen <= WITHOUT_PLACE
                or effect.name == "sensor_rotated"
                and seen == {"depth_m"}
            )
            elsewhere = effect.kind == "axis" and place not in effect.places
            if effect.name == "wall_proximity":  # of a wall that nothing hears there is nothing to seek
                elsewhere |= not any(column.endswith("range_m") for column in layout.columns)
            if effect.name == "wrong_allocation":  # of two thrusters under the first
                elsewhere = place == layout.pushes[-1].name
            if not (unseen or elsewhere or effect.name in NOT_HERE):
                assert f"{effect.name}@{place}" in sought


def test_exchanged_inputs_stand_at_both_thrusters() -> None:
    vehicle = vt.load_vehicle("bluerov2")
    layout, (run,), _ = record([fly_vehicle(vehicle, multisine(vehicle, 5.0, 1), 5.0, 1, depth_m=5.0)], vehicle)
    exchanges = [c for c in catalogue(layout, run.moves, Sizes.unit(layout)) if c.exchange]
    assert {c.effect for c in exchanges} == {"wrong_allocation"}
    pairs = {frozenset((c.place, c.detail)) for c in exchanges}
    assert len(pairs) == len(exchanges) == 8 * 7 // 2
