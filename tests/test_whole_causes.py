"""Causes that a diagnosis of a whole vehicle took for others, or did not see, in tanks that have them."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.diagnose.whole.budget import _is_a_body
from vtank.diagnose.whole.gross import mistaken
from vtank.diagnose.whole.model import blank
from vtank.diagnose.whole.own import own_unknowns
from vtank.experiment.whole import fly_vehicle
from vtank.experiment.whole_scenario import fly_whole, scenario_of
from vtank.present.words import WORDS
from vtank.record.table import Table
from vtank.rigid.fit import RUNAWAY, Fit, begun
from vtank.rigid.layout import (
    ASLANT,
    FIN,
    GONE,
    HOLDS,
    HULL,
    LEANS,
    LIFT,
    PRESSURE,
    RATIO,
    STALL,
    SUCTION,
    THRUSTER,
    Layout,
    masses,
)
from vtank.rigid.motion import fin_force
from vtank.rigid.noise import first_noise
from vtank.rigid.places import Sizes, catalogue
from vtank.rigid.push import pushes
from vtank.rigid.recordings import record
from vtank.tank.places import read_placed

REMUS, ROV, PHOENIX = (vt.load_vehicle(name) for name in ("remus100", "bluerov2", "phoenix"))
FEW = replace(ROV, sensors=tuple(s for s in ROV.sensors if s.name in ("imu", "ahrs", "dvl", "depth")))
PUSHES = (("bow", 0.5), ("stern", 0.8))  # [rad/s]
ZIGZAG = """
vehicle = "phoenix"
duration_s = 60
seed = 687676889
depth_m = 50.0
[[excite]]
axis = "yaw"
kind = "zigzag"
amplitude_share = 0.2973
heading_rad = 0.2229
[[hold]]
axis = "surge"
speed_m_s = 0.480
bandwidth_rad_s = 0.3
otherwise = "leave"
[[hold]]
axis = "heave"
bandwidth_rad_s = 0.4
otherwise = "leave"
[[hold]]
axis = "pitch"
bandwidth_rad_s = 0.4
otherwise = "leave"
"""


def flown_with(vehicle, seconds: float, **effects) -> vt.Run:
    """A flight in the tank with effects at places, named EFFECT__PLACE."""
    named = {name.replace("__", "@"): values for name, values in effects.items()}
    placed = read_placed(Table(Path("trial"), "effects", named), vehicle)
    told = multisine(vehicle, seconds, 3)
    return fly_vehicle(vehicle, told, seconds, 3, effects=placed)


def diagnosed(vehicle, name: str, seconds: float = 40.0, **effects):
    """Values that are found of an effect, sought alone, and the verdict."""
    found = vt.diagnose([flown_with(vehicle, seconds, **effects)], nominal=vehicle, effects=[name])
    return {p.name: found.selection.best.values(p) for p in found.selection.best.effects}, found.verdict


@pytest.mark.slow
def test_a_pilot_who_answers_noise_does_not_foresee_it():
    """Averaged samples are true before the answer to any of them: what is left has nothing to do with the answer."""

    def steadied(time_s: float, readings):
        rate = readings.get("imu.pitch_rate_rad_s", 0.0)
        return {"propeller_rev_s": 12.0, "plane_rad": float(np.clip(40.0 * rate, -0.2, 0.2))}

    layout, (run,), _ = record([fly_vehicle(REMUS, steadied, 60.0, 1, depth_m=50.0)], REMUS)
    (found,) = Fit((run,), first_noise((run,))).filter(layout.null)
    mine = run.column == layout.columns.index("imu.pitch_rate_rad_s")
    time_s, z = run.time_s[mine], (found.innovation / np.sqrt(found.variance))[mine]
    assert np.median(np.diff(time_s)) == pytest.approx(0.1), "five samples each"
    plane = run.angles[np.searchsorted(run.stamps, time_s) - 1, [fin.name for fin in REMUS.fins].index("plane")]
    turned = np.diff(plane)
    assert abs(z[1:] @ turned) < 3.5 * np.sqrt(turned @ turned) and np.std(turned) > 0.02


@pytest.mark.parametrize("gain", [0.0, 2.0])
def test_noise_that_a_quick_pilot_answers_is_not_averaged_with_the_answer(gain: float):
    """A gyro at 50 Hz, a loop as fast: each sample by itself; steered at 50 Hz by the clock alone: five together."""

    def steadied(time_s: float, readings):
        rate = readings.get("imu.pitch_rate_rad_s", 0.0)
        plane = np.clip(gain * rate + 0.1 * np.sin(0.7 * time_s), -0.2, 0.2)
        return {"propeller_rev_s": 12.0, "plane_rad": float(plane)}

    run = fly_vehicle(REMUS, steadied, 20.0, 1, depth_m=50.0, period_s=0.02)
    layout, (seen,), _ = record([run], REMUS)
    gaps = {name: np.median(np.diff(seen.time_s[seen.column == c])) for c, name in enumerate(layout.columns)}
    assert gaps["imu.pitch_rate_rad_s"] == pytest.approx(0.02 if gain else 0.1, abs=0.002)
    assert gaps["imu.accel_x_m_s2"] == pytest.approx(0.1, abs=0.002), "nobody answers it"


@pytest.mark.parametrize(("sign", "found"), [(1.0, None), (-1.0, "wrong_sign@depth")])
def test_a_depth_that_grows_upwards_is_seen_at_any_depth(sign: float, found: str | None):
    """Its first sample, -50 m, is no place that the other sign had to start from."""
    run = fly_vehicle(FEW, multisine(FEW, 20.0, 3), 20.0, 3, depth_m=50.0)
    turned = replace(run, columns={**run.columns, "depth.depth_m": sign * run.columns["depth.depth_m"]})
    layout, seen, _ = record([turned], FEW)
    signs = [c for c in catalogue(layout, seen[0].moves, Sizes.unit(layout)) if c.effect == "wrong_sign"]
    mistake = mistaken(layout, seen, first_noise(seen), signs)
    assert (mistake.name if mistake else None) == found


def test_where_a_part_left_out_would_tell_of_no_body_the_step_is_shorter():
    """Added mass in surge is moved to less than none of the body's own."""
    layout, seen, _ = record([fly_vehicle(FEW, multisine(FEW, 4.0, 1), 4.0, 1)], FEW)
    own = [u for u in own_unknowns(layout, seen) if u.name == "added_mass@surge"]
    model = blank(Fit(seen, first_noise(seen)), layout, (), own)
    assert _is_a_body(model, np.zeros(1)) and not _is_a_body(model, np.array([-100.0]))


@pytest.mark.slow
def test_a_grossly_late_instrument_is_found_and_read_in_its_time():
    """0.9 s, far beyond what a motion can be wound back by, on an instrument that is not alone in what it tells."""
    values, verdict = diagnosed(FEW, "sensor_latency", 60.0, sensor_latency__ahrs={"d_s": 0.9})
    assert verdict.effects == ("sensor_latency",) and verdict.places == ("ahrs",)
    assert "clock_offset@ahrs" in verdict.rivals
    assert values["sensor_latency@ahrs"]["d"][0] == pytest.approx(0.9, abs=0.02)


def test_measurements_are_put_in_order_at_other_delays_only_where_these_are_far_off():
    layout, (run,), _ = record([fly_vehicle(FEW, multisine(FEW, 4.0, 1), 4.0, 1)], FEW)
    p, late = layout.null.copy(), layout.slot("latency@ahrs")
    p[late] += 0.1
    assert run.ordered(p) is run
    p[late] += 0.8
    there = run.ordered(p)
    of_ahrs = run.sensor == layout.sensors.index("ahrs")
    np.testing.assert_allclose(there.late - run.late, 0.9 * of_ahrs)
    assert there.ordered(p) is there and there.ordered(layout.null).late == pytest.approx(run.late)


@pytest.mark.slow
def test_moments_of_added_mass_are_own_parameters():
    """The file of a Phoenix has the one between sway and yaw by a quarter too small; the rest of it is right.

    Which leaves a part of it to two tunnel thrusters that are not quite alike.
    """
    true = PHOENIX.added_mass.copy()
    true[1, 5] = true[5, 1] = 1.25 * true[1, 5]
    time_s = np.arange(0.0, 60.0, 0.1)
    sideways = {f"tunnel_{end}_lateral_rev_s": 45.0 * np.sign(np.sin(w * time_s)) for end, w in PUSHES}
    run = fly_vehicle(replace(PHOENIX, added_mass=true), {"time_s": time_s} | sideways, 60.0, 3)
    best = vt.diagnose([run], nominal=PHOENIX, effects=["linear_drag"]).selection.best
    i = next(i for i, unknown in enumerate(best.unknowns) if unknown.name == "added_mass_sway_yaw@hull")
    found, sd = best.unknowns[i].base[0] + best.theta[i], best.sd[i]
    assert abs(found - true[1, 5]) < 2.5 * sd and sd < 0.3 * (true[1, 5] - PHOENIX.added_mass[1, 5])


@pytest.mark.parametrize("name", ["phoenix", "remus100", "kingfisher", "bluerov2"])
def test_wherever_moments_of_added_mass_are_sought_no_direction_is_without_mass(name: str):
    vehicle = vt.load_vehicle(name)
    layout, (run,), _ = record([fly_vehicle(vehicle, multisine(vehicle, 4.0, 1), 4.0, 1)], vehicle)
    moments = [u for u in own_unknowns(layout, [run]) if u.name.endswith("@hull")]
    assert len(moments) == {"phoenix": 2, "remus100": 2}.get(name, 0)
    for ends in np.ndindex(*(2 for _ in moments)):
        p = layout.null.copy()
        for u, end in zip(moments, ends, strict=True):
            p[u.slots] += (u.low, u.high)[end]
        masses(p, run.moves)  # refuses what is not positive definite


def test_lift_is_an_own_parameter_of_fins_of_a_section():
    """As the gain of thrusters of a kind: a fin that is weak alone differs from the others; a hull is of no section."""
    vehicle = vt.load_vehicle("remus100")
    layout, (run,), _ = record([fly_vehicle(vehicle, multisine(vehicle, 4.0, 1), 4.0, 1)], vehicle)
    lifts = {u.name: u.slots.size for u in own_unknowns(layout, [run]) if u.name.startswith("lift@")}
    assert lifts == {"lift@plane/rudder": 2, "lift@hull_heave": 1, "lift@hull_sway": 1}


def test_masses_that_no_body_has_are_as_far_off_as_can_be():
    """A fit that steps there turns back; it does not end in an error."""
    _, seen, _ = record([fly_vehicle(PHOENIX, multisine(PHOENIX, 4.0, 1), 4.0, 1)], PHOENIX)
    fit, p = Fit(seen, first_noise(seen)), seen[0].layout.null.copy()
    found = fit.filter(p)
    p[seen[0].layout.slot("added_mass_sway_yaw@hull")] = 1e4
    assert np.all(fit.residuals([p], found) == RUNAWAY)


def test_a_fin_that_lost_half_its_area_makes_half_its_force_whatever_its_angle():
    _, (run,), _ = record([fly_vehicle(REMUS, multisine(REMUS, 5.0, 1), 5.0, 1)], REMUS)
    p, first = run.layout.null.copy(), HULL + THRUSTER * len(run.layout.pushes)
    whole = np.array(fin_force(p, first, 0.1, (1.5, 0.1, 0.05)))
    p[first + GONE] = 0.5
    np.testing.assert_allclose(fin_force(p, first, 0.1, (1.5, 0.1, 0.05)), 0.5 * whole, rtol=1e-12)


def test_with_all_suction_lift_is_square_to_the_flow_and_without_the_force_is_square_to_the_fin():
    _, (run,), _ = record([fly_vehicle(REMUS, multisine(REMUS, 5.0, 1), 5.0, 1)], REMUS)
    p, first, angle = run.layout.null.copy(), HULL + THRUSTER * len(run.layout.pushes) + FIN, 0.15  # the rudder
    flow = np.array([1.4, -0.1, 0.0])
    plate = np.array(fin_force(p, first, angle, tuple(flow)))
    beside = [abs(plate @ np.array([np.cos(a), np.sin(a), 0.0])) for a in (angle, -angle)]
    assert min(beside) < 1e-12 * np.linalg.norm(plate) + 1e-12
    p[first + SUCTION] = 1.0
    wing = np.array(fin_force(p, first, angle, tuple(flow)))
    assert wing @ flow == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(wing) > 0.1


@pytest.mark.parametrize("suction", [0.0, 1.0])
def test_a_fin_that_holds_its_lift_beyond_the_stall_has_there_what_it_had_at_it(suction: float):
    """No file states what comes after; a force square to the fin, or to the flow, either side of it."""
    _, (run,), _ = record([fly_vehicle(REMUS, multisine(REMUS, 5.0, 1), 5.0, 1)], REMUS)
    p, first = run.layout.null.copy(), HULL + THRUSTER * len(run.layout.pushes) + FIN  # the rudder
    p[first + SUCTION], p[first + HOLDS], stall = suction, 1.0, p[first + STALL]
    lifts = []
    for angle in (stall - 1e-9, stall + 1e-9, 1.3 * stall):
        X, Y, _ = fin_force(p, first, angle, (1.4, 0.0, 0.0))
        lifts.append(Y)
        assert X == pytest.approx(-(1.0 - suction) * abs(Y) * np.tan(min(angle, stall)), rel=1e-6, abs=1e-9)
    assert lifts == pytest.approx([lifts[0]] * 3, rel=1e-6) and abs(lifts[0]) > 1.0
    athwart = fin_force(p, first, 0.0, (1e-9, 1.4, 0.0))  # as a hull that hovers goes aside
    assert np.hypot(*athwart[:2]) < 1.1 * np.hypot(X, Y), "and no more square to the flow"
    p[first + HOLDS] = 0.0
    assert abs(fin_force(p, first, 0.5 * np.pi, (1.4, 0.0, 0.0))[1]) < 1e-6, "all is lost athwart the flow"


@pytest.mark.parametrize(("power", "flowing"), [(0.0, 1.4**2 + 0.1**2), (2.0, 1.4**2)])
@pytest.mark.parametrize(("ratio", "inflow"), [(0.0, np.arctan(0.1 / 1.4)), (1.0, 0.1 / 1.4)])
@pytest.mark.parametrize("angle", [0.1, 0.5])
def test_a_fin_that_does_not_lean_is_that_of_simple_simulators(
    angle: float, power: float, flowing: float, ratio: float, inflow: float
):
    """Square to the hull, by the flow's angle or a ratio of speeds, up to the stall, and the square of all or surge."""
    _, (run,), _ = record([fly_vehicle(REMUS, multisine(REMUS, 5.0, 1), 5.0, 1)], REMUS)
    p, first = run.layout.null.copy(), HULL + THRUSTER * len(run.layout.pushes) + FIN  # the rudder
    p[first + LEANS], p[first + ASLANT], p[first + RATIO] = 0.0, power, ratio
    lift = p[first + PRESSURE] * flowing * p[first + LIFT] * min(angle + inflow, p[first + STALL])
    assert fin_force(p, first, angle, (1.4, -0.1, 0.0)) == pytest.approx((0.0, lift, 0.0), rel=1e-12)
    leaning = run.layout.null.copy()
    for flow in ((-1.4, -0.1, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.0)):  # of which simple simulators say nothing
        assert fin_force(p, first, angle, flow) == fin_force(leaning, first, angle, flow)


@pytest.mark.slow
def test_a_fin_that_lost_part_of_its_area_is_named_with_that_part():
    values, verdict = diagnosed(REMUS, "fin_weak", 60.0, fin_weak__rudder={"share": 0.4})
    assert (verdict.effects, verdict.places) == (("fin_weak",), ("rudder",))
    size, sd = values["fin_weak@rudder"]["share"]  # masses, drags and lift of the file are not known to be exact
    assert abs(size - 0.4) < 2.0 * sd < 0.14


@pytest.mark.slow
def test_a_thruster_that_obeys_very_late_is_found():
    """Far from the truth a delay of six tenths of a second promises nothing: fits begin at several."""
    values, verdict = diagnosed(FEW, "command_delay", command_delay__thruster_3={"d_s": 0.6})
    assert (verdict.effects, verdict.places) == (("command_delay",), ("thruster_3",))
    assert values["command_delay@thruster_3"]["d"][0] == pytest.approx(0.6, abs=0.01)


def ramps(vehicle: vt.Vehicle, duration_s: float, seed: int) -> vt.Run:
    """A flight by commands that go straight from each value to the next, of which the log has these alone."""
    told = multisine(vehicle, duration_s, seed)
    fine = np.linspace(0.0, told["time_s"][-1], 10 * told["time_s"].size - 9)
    between = {name: np.interp(fine, told["time_s"], values) for name, values in told.items()}
    run = fly_vehicle(vehicle, between, duration_s, seed)
    logged = np.isin(np.round(run.time_s, 6), np.round(told["time_s"], 6))
    return replace(run, columns={
        name: np.where(logged, values, np.nan) if name.endswith("_command") else values
        for name, values in run.columns.items()
    })  # fmt: skip


def test_the_tank_cannot_act_before_it_is_told():
    """A corrected simulator of inputs that were stamped late is flown as one of inputs that act at once."""
    asked = {"time_s": [0.0, 1.0], **{f"thruster_{k}_command": [0.3, -0.3] for k in range(1, 9)}}
    early = replace(FEW, corrections={f"delay@thruster_{k}": -0.0048 for k in range(1, 9)})
    for name, values in fly_vehicle(FEW, asked, 3.0, 1).columns.items():
        np.testing.assert_array_equal(fly_vehicle(early, asked, 3.0, 1).columns[name], values)


@pytest.mark.slow
@pytest.mark.parametrize("modelled", [True, False])
def test_commands_that_go_straight_from_one_to_the_next_are_no_gap(monkeypatch, modelled: bool):
    """Held, they act late by half the time between them, and in steps: of which no file tells."""
    if not modelled:
        own = importlib.import_module("vtank.diagnose.whole.own")
        for name in ("OFF", "PATH"):
            monkeypatch.setattr(own, name, 1e-9)
    asked = None if modelled else ["linear_drag", "thrust_lag"]  # of all effects none passes for it
    found = vt.diagnose([ramps(FEW, 60.0, 5)], nominal=FEW, effects=asked)
    assert (found.verdict.kind == "none") == modelled
    if modelled:
        nominal = found.selection.nominal
        values = {u.name: theta for u, theta in zip(nominal.unknowns, nominal.theta, strict=True)}
        assert values["path@thrusters"] == pytest.approx(1.0, abs=0.03)
        assert values["delay@thrusters"] == pytest.approx(0.01, abs=0.003), (
            "the flight's own commands are held for 20 ms"
        )


@pytest.mark.parametrize("vehicle", [ROV, REMUS, PHOENIX], ids=lambda vehicle: vehicle.name)
def test_every_own_parameter_has_a_word(vehicle: vt.Vehicle):
    columns = [thruster.column for thruster in vehicle.thrusters]
    sonars = [f"{s.name}.range_m" for s in vehicle.sensors if "range_m" in s.channels]
    layout = Layout(vehicle, pushes(vehicle, columns), tuple(s.partition(".")[0] for s in sonars), tuple(sonars))
    for unknown in own_unknowns(layout, [SimpleNamespace(moves=np.ones(6, bool), tick_s=0.1)]):
        assert unknown.name.partition("@")[0] in WORDS["own_whole"], unknown.name


def test_speeds_of_which_nothing_tells_begin_at_rest_and_their_drag_is_free():
    run = fly_whole(scenario_of(ZIGZAG, "run_1"), PHOENIX).run
    layout, seen, _ = record([run], PHOENIX)
    assert not seen[0].asked[0] and seen[0].moves[0], "nothing tells of surge"
    free = {u.name for u in own_unknowns(layout, seen)}
    assert {"quadratic_drag@surge", "added_mass@sway"} <= free
    noise = replace(first_noise(seen), sigma=np.full(6, 1e-4))
    fit = Fit(seen, noise)
    assert begun(fit, layout.null).runs[0] is seen[0]
    doubting = replace(fit, runs=(seen[0].drifting,))
    level = [sum(_level(f) for f in some.filter(layout.null)) for some in (fit, doubting)]
    assert level[0] > level[1]


def _level(f) -> float:
    return -0.5 * float(np.sum(f.innovation**2 / f.variance + np.log(f.variance)))


def test_rates_alone_may_be_in_degrees():
    layout, seen, _ = record([fly_vehicle(ROV, multisine(ROV, 5.0, 1), 5.0, 1)], ROV)
    sizes = Sizes(*(np.ones(6) for _ in range(3)), 10.0, 1.0, np.ones(8), np.ones(8))
    units = {c.name: c.parameters[0].slots for c in catalogue(layout, seen[0].moves, sizes) if c.effect == "wrong_unit"}
    assert all("rate" in slot for slot in units["wrong_unit@imu:degrees"])
    assert all("rate" not in slot for slot in units["wrong_unit@mocap:degrees"])


def test_echoes_are_heard_by_being_late_and_are_left_out_of_what_else_is_sought():
    echoes = importlib.import_module("vtank.diagnose.whole.echoes")
    rng = np.random.default_rng(4)
    layout, (run,), _ = record([flown_with(ROV, 40.0)], ROV)
    layout = replace(layout, columns=tuple("ping.range_m" if c == 0 else n for c, n in enumerate(layout.columns)))
    run = replace(run, layout=layout)
    mine = np.flatnonzero(run.column == 0)
    sizes = Sizes(*(np.ones(6) for _ in range(3)), 10.0, 1.0, np.ones(8), np.ones(8))
    known = [
        c
        for c in catalogue(replace(layout, sensors=("ping",)), run.moves, sizes)
        if not any(q.slots for q in c.parameters)
    ]
    stray = rng.choice(mine, mine.size // 15, replace=False)
    for sign, told in ((1.0, True), (rng.choice([-1.0, 1.0], stray.size), False)):
        e = 0.02 * rng.normal(size=run.time_s.size)
        e[stray] += 1.4 * sign
        found = echoes.heard([run], [SimpleNamespace(innovation=e)], known)
        assert (found is not None) == told
        if found:
            p, extra = (q.starts[0] for q in found.placed.parameters)
            assert p == pytest.approx(1 / 15, rel=0.1) and extra == pytest.approx(1.4, abs=0.02)
            assert run.time_s.size - found.runs[0].time_s.size == stray.size


@pytest.mark.slow
def test_a_standing_wave_is_found_with_frequency_and_phase():
    wave = {"amplitude_m_s": 0.08, "frequency_rad_s": 0.7, "phase_rad": 2.5}
    values, verdict = diagnosed(FEW, "seiche", 60.0, seiche__surge=wave)
    assert verdict.effects == ("seiche",)
    (found,) = values.values()
    sine, cosine = found["sine"][0], found["cosine"][0]
    assert np.hypot(sine, cosine) == pytest.approx(0.08, rel=0.02)
    assert found["frequency"][0] + found["detuning"][0] == pytest.approx(0.7, rel=0.01)
    assert np.arctan2(cosine, sine) == pytest.approx(2.5, abs=0.1)
