"""The corrected simulator of a whole vehicle flies: what a diagnosis moves is what the tank's own effects do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vtank as vt
from vtank.errors import InputError
from vtank.experiment.whole import fly, fly_vehicle
from vtank.plant.vehicle import Vehicle, load_vehicle
from vtank.resources import models_dir
from vtank.rigid.layout import Layout
from vtank.rigid.places import Placed, Sizes, catalogue
from vtank.rigid.push import pushes
from vtank.tank.described import described
from vtank.tank.places.thruster import thrust_asymmetry
from vtank.water.body import of_vehicle

FILES = {"bluerov2": 0.4, "remus100": 8.0}  # vehicle -> input
DURATION_S = 4.0


def commands(vehicle: Vehicle, size: float) -> dict[str, Any]:
    """Unlike ones for all thrusters and fins, with changes."""
    rng, times = np.random.default_rng(3), [0.0, 1.0, 2.5]
    table: dict[str, Any] = {"time_s": times}
    table |= {thruster.column: size * rng.uniform(-1.0, 1.0, 3) for thruster in vehicle.thrusters}
    return table | {fin.column: rng.uniform(-0.3, 0.3, 3) for fin in vehicle.fins if fin.limit_rad}


def placed_in(vehicle: Vehicle) -> tuple[Layout, dict[str, Placed]]:
    """The catalogue of a diagnosis of that vehicle, whose instruments have all recorded."""
    vehicle = described(vehicle)
    driven = pushes(vehicle, [thruster.column for thruster in vehicle.thrusters])
    columns = tuple(f"{sensor.name}.{channel}" for sensor in vehicle.sensors for channel in sensor.channels)
    layout = Layout(vehicle, driven, tuple(sensor.name for sensor in vehicle.sensors), columns)
    waves = replace(Sizes.unit(layout), waves=((0.7,), (), ()))
    return layout, {placed.name: placed for placed in catalogue(layout, [True] * 6, waves)}


def slots(layout: Layout, placed: Placed, values: Mapping[str, float]) -> dict[str, float]:
    """What an effect of that size moves, by name."""
    found: dict[str, float] = {}
    for number in placed.parameters:
        value = values.get(number.name, number.starts[0] if number.scale == 0.0 else 0.0)
        for name in number.slots:
            now = found.get(name, layout.null[layout.slot(name)])
            found[name] = float(number.moved(now, value))
    return found


# What a diagnosis finds -> the effect of the tank that it is; by vehicle
SAME = {
    "bluerov2": [
        ("linear_drag@yaw", {"c": 0.3}, {"c_N_m_s_per_rad": 0.3}),
        ("coulomb_friction@surge", {"f": 2.0}, {"f_N": 2.0}),
        ("drag_asymmetry@sway", {"e": 0.3}, {"e": 0.3}),
        ("ambient_current@surge", {"U": 0.2}, {"U_m_s": 0.2}),
        ("tether@heave", {"k": 3.0}, {"k_N_per_m": 3.0}),
        ("constant_force@pitch", {"F": 0.5}, {"F_N_m": 0.5}),
        ("wake_memory@surge", {"k": 0.4, "T": np.log(0.6)}, {"k": 0.4, "T_s": 3.0}),
        ("coriolis@surge", {"c": 4.0}, {"c_kg": 4.0}),
        ("coriolis@sway", {"c": 4.0}, {"c_kg": 4.0}),
        ("coriolis@heave", {"c": 4.0}, {"c_kg": 4.0}),
        ("munk_moment@yaw", {"c": 4.0}, {"c_kg": 4.0}),
        ("munk_moment@pitch", {"c": 4.0}, {"c_kg": 4.0}),
        ("thruster_dead@thruster_1", {"share": 0.4}, {"share": 0.4}),
        ("thruster_reversed@thruster_2", {}, {}),
        ("wrong_allocation@thruster_1:thruster_4", {}, {"other": "thruster_4"}),
        ("thrust_deadband@thruster_3", {"n0": 0.1}, {"n0": 0.1}),
        ("thrust_saturation@thruster_3", {"n_max": 0.15}, {"n_max": 0.15}),
        ("thrust_asymmetry@thruster_3", {"e": 0.3}, {"e": 0.3}),
        ("thrust_lag@thruster_3", {"tau": 0.5}, {"tau_s": 0.5}),
        ("command_delay@thruster_3", {"d": 0.35}, {"d_s": 0.35}),
        ("thrust_loss@thruster_3", {"gamma": 8.0}, {"gamma_N_s_per_m": 8.0}),
        ("supply_sag@thruster_3", {"r": 0.05}, {"r_per_s": 0.05}),
        ("tachometer_bias@thruster_3", {"b": 0.1}, {"b": 0.1}),
        ("thruster_turned@thruster_3", {"yaw": 0.3, "pitch": 0.2}, {"yaw_rad": 0.3, "pitch_rad": 0.2}),
        ("centre_of_gravity@vehicle", {"x": 0.02, "z": -0.01}, {"x_m": 0.02, "z_m": -0.01}),
        ("centre_of_buoyancy@vehicle", {"y": 0.01}, {"y_m": 0.01}),
        ("buoyancy@vehicle", {"B": 2.0}, {"B_N": 2.0}),
        ("trim_weight@vehicle", {"m": 0.3, "x": 0.1}, {"m_kg": 0.3, "x_m": 0.1}),
        ("coriolis_left_out@vehicle", {"share": 0.8}, {"share": 0.8}),
        ("current@vehicle", {"north": 0.1, "east": 0.2}, {"north_m_s": 0.1, "east_m_s": 0.2}),
        ("tether@vehicle", {"east": 3.0, "k": 2.0, "z": 0.1}, {"east_N": 3.0, "k_N_per_m": 2.0, "z_m": 0.1}),
        ("sensor_latency@dvl", {"d": 0.2}, {"d_s": 0.2}),
        ("clock_offset@dvl", {"o": -0.2}, {"o_s": -0.2}),
        ("clock_skew@dvl", {"s": 0.01}, {"s": 0.01}),
        ("sensor_scale@dvl", {"s": 0.1}, {"s": 0.1}),
        ("wrong_sign@dvl:dvl.sway_m_s", {}, {"channel": "sway_m_s"}),
        ("earth_axes@dvl", {}, {}),
        ("sensor_rotated@dvl", {"yaw": 0.2}, {"yaw_rad": 0.2}),
        ("sensor_displaced@dvl", {"x": 0.2}, {"x_m": 0.2}),
        ("wall_proximity@surge", {"drag": 0.5, "mass": 0.3}, {"drag": 0.5, "mass": 0.3}),
        ("gyro_bias@imu", {"yaw_rate_rad_s": 0.03}, {"yaw_rad_s": 0.03}),
    ],
    "remus100": [
        ("fin_offset@rudder", {"angle": 0.05}, {"angle_rad": 0.05}),
        ("fin_weak@rudder", {"share": 0.4}, {"share": 0.4}),
        ("fin_delay@rudder", {"d": 0.4}, {"d_s": 0.4}),
        ("fin_drag@rudder", {"k": 300.0}, {"k_N_s2_per_m2": 300.0}),
        ("cross_flow_drag@vehicle", {"sway": 3000.0}, {"sway_N_s2_per_m3": 3000.0}),
        ("cross_flow_drag@vehicle", {"sway": 3000.0, "nose": -0.3, "tail": 0.2}, {"sway_N_s2_per_m3": 3000.0}),
    ],
}  # fmt: skip
CASES = [(vehicle, *case) for vehicle, cases in SAME.items() for case in cases]


@pytest.mark.parametrize(("file", "name", "found", "effect"), CASES, ids=[f"{case[0]} {case[1]}" for case in CASES])
def test_what_a_diagnosis_moves_is_the_effect_of_that_size(
    file: str, name: str, found: dict[str, float], effect: dict[str, Any]
) -> None:
    vehicle = load_vehicle(file)
    layout, known = placed_in(vehicle)
    as_found = slots(layout, known[name], found)
    effect = dict(effect)
    if "cross_flow" in name:
        nose, tail = layout.vehicle.ends_m
        effect |= {"nose_m": nose + found.get("nose", 0.0), "tail_m": tail + found.get("tail", 0.0)}
    asked, water = commands(vehicle, FILES[file]), {"walls": models_dir() / "basin.xml"} if "wall" in name else {}
    plain = fly(vehicle, asked, DURATION_S, **water).run
    true = fly(vehicle, asked, DURATION_S, effects={name.partition(":")[0]: effect}, **water).run
    run = fly(replace(vehicle, corrections=as_found), asked, DURATION_S, **water).run
    assert run.columns.keys() == true.columns.keys()
    apart = 0.0
    for column in true.columns:
        (time_s, values), (there_s, there), (_, still) = (each.samples(column) for each in (true, run, plain))
        assert there_s == pytest.approx(time_s, abs=1e-9)
        scale = float(np.abs(values).max()) or 1.0
        assert np.abs(there - values).max() < 1e-6 * scale
        apart = max(apart, np.abs(values - still).max() / scale if still.size == values.size else 1.0)
    assert apart > 1e-4  # the effect acts, so that the comparison tells something


def test_a_thruster_that_is_weak_astern_is_as_strong_ahead_as_before() -> None:
    """So that its gain need not change with it, which would name a weak thruster besides."""
    force = np.array([-2.0, 0.0, 3.0])
    assert thrust_asymmetry.one_sided(np.zeros(3), np.sign(force), force, {"e": 0.4}) == pytest.approx([-1.2, 0.0, 3.0])


def test_every_effect_of_a_diagnosis_is_flown_or_named_as_of_the_recording_alone() -> None:
    alone = {"tachometer_spikes", "sonar_multipath"}
    tried = {case[1].partition("@")[0] for case in CASES}
    for file in FILES:
        layout, known = placed_in(load_vehicle(file))
        for placed in known.values():
            if placed.effect in alone or placed.effect in tried:
                continue
            values = {number.name: 0.3 * number.scale for number in placed.parameters if number.scale > 0.0}
            moved = slots(layout, placed, values)
            corrected = replace(layout.vehicle, corrections=moved)
            asked = commands(corrected, FILES[file])
            walls = models_dir() / "basin.xml"
            plain, run = (fly(v, asked, 1.0, walls=walls).run for v in (layout.vehicle, corrected))
            assert any(
                not np.array_equal(plain.samples(column)[1], run.samples(column)[1]) for column in plain.columns
            ), placed.name


def test_own_parameters_are_those_of_another_file() -> None:
    vehicle = load_vehicle("remus100")
    layout, _ = placed_in(vehicle)
    thruster, rudder = vehicle.thrusters[0], next(fin for fin in vehicle.fins if fin.name == "rudder")
    corrections = {
        "quadratic_drag@surge": 6.0, "added_mass@sway": 40.0, "added_mass_sway_yaw@hull": 1.5,
        f"gain@{thruster.name}": 1.2, f"lag@{thruster.name}": 0.3, "lift@rudder": 4.0,
    }  # fmt: skip
    drag, added = vehicle.quadratic_drag.copy(), vehicle.added_mass.copy()
    drag[0], added[1, 1], added[1, 5], added[5, 1] = 6.0, 40.0, 1.5, 1.5
    other = replace(
        vehicle, quadratic_drag=drag, added_mass=added,
        thrusters=(replace(thruster, gain=1.2 * thruster.gain, limit_N=1.2 * thruster.limit_N, lag_s=0.3,
                           curve=tuple((n, 1.2 * f) for n, f in thruster.curve)), *vehicle.thrusters[1:]),
        fins=tuple(replace(fin, lift_per_rad=4.0) if fin is rudder else fin for fin in vehicle.fins),
    )  # fmt: skip
    asked = commands(vehicle, 8.0)
    one, two = (fly_vehicle(v, asked, DURATION_S) for v in (replace(vehicle, corrections=corrections), other))
    for column in one.columns:
        assert one.samples(column)[1] == pytest.approx(two.samples(column)[1], abs=1e-12)


def model(tmp_path: Path, **diagnosed: float) -> Path:
    lines = ['schema = "vtank.whole/2"', 'vehicle = "bluerov2"', "[diagnosed]"]
    path = tmp_path / "gap.toml"
    path.write_text("\n".join(lines + [f'"{name}" = {value}' for name, value in diagnosed.items()]))
    return path


def test_a_diagnosed_model_is_a_vehicle_to_every_command(tmp_path: Path) -> None:
    path = model(tmp_path, **{"lost@thruster_1": 0.3, "linear_drag@yaw": 0.4})
    settings = (f"vehicle={path}", "duration_s=5")
    vt.run("whole/zigzag", settings=settings, out=tmp_path / "corrected")
    own = ("vehicle=bluerov2", "duration_s=5", 'effects."thruster_dead@thruster_1".share=0.3',
           'effects."linear_drag@yaw".c_N_m_s_per_rad=0.4')  # fmt: skip
    vt.run("whole/zigzag", settings=own, out=tmp_path / "own")
    (one,), (two,) = vt.load(tmp_path / "corrected"), vt.load(tmp_path / "own")
    null = load_vehicle("bluerov2").linear_drag[5]
    assert null == 0.0  # else the effect would add to it
    for column in one.columns:
        assert one.samples(column)[1] == pytest.approx(two.samples(column)[1], abs=1e-9)
    assert load_vehicle(path).name == "bluerov2, corrected"


def test_what_is_flown_is_the_nominal_of_a_diagnosis_too(tmp_path: Path) -> None:
    layout, _ = placed_in(load_vehicle(model(tmp_path, **{"lost@thruster_1": 0.3, "bias@imu.yaw_rate_rad_s": 0.01})))
    assert layout.null[layout.slot("lost@thruster_1")] == 0.3
    assert layout.null[layout.slot("bias@imu.yaw_rate_rad_s")] == 0.01


def test_an_effect_that_remembers_is_there_once(tmp_path: Path) -> None:
    vehicle = load_vehicle(model(tmp_path, **{"wake@surge": 0.3}))
    with pytest.raises(InputError, match=r"wake_memory@surge: the vehicle has it already"):
        fly_vehicle(vehicle, {"time_s": [0.0]}, 1.0, effects={"wake_memory@surge": {"k": 0.2}})


def test_where_corrections_would_be_lost_it_is_refused(tmp_path: Path) -> None:
    path = model(tmp_path, **{"linear_drag@yaw": 0.4})
    with pytest.raises(InputError, match=r"gap.toml: a diagnosed model, whose corrections only flights"):
        of_vehicle(load_vehicle(path), 9.8)
    with pytest.raises(InputError, match=r"gap.toml: a diagnosed model"):
        vt.run("paper-ds1", settings=(f"vehicle={path}",), out=tmp_path / "out")


def test_a_model_of_itself_and_a_plant_of_a_simulator_are_refused(tmp_path: Path) -> None:
    (tmp_path / "gap.toml").write_text('schema = "vtank.whole/2"\nvehicle = "gap.toml"\n')
    with pytest.raises(InputError, match=r"gap.toml.*vehicle: a diagnosed model of itself"):
        load_vehicle(tmp_path / "gap.toml")
    (tmp_path / "gap.toml").write_text('schema = "vtank.whole/2"\nvehicle = "bluerov2"\n[plant]\nsigma = [0.0]\n')
    with pytest.raises(InputError, match=r"plant: stands for a simulator that it was fitted to"):
        load_vehicle(tmp_path / "gap.toml")
