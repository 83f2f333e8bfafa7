"""Open-loop scenarios of whole vehicles: forces along chosen axes, shared by the thrusters, from the command line."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.experiment.whole import Flown
from vtank.experiment.whole_scenario import fly_scenarios, fly_whole, is_whole, load_whole_scenario, summary
from vtank.plant import Sensor, Thruster, load_vehicle
from vtank.plant.vehicle import AXES
from vtank.record import Run, read_dataset, read_truth
from vtank.resources import scenarios_dir
from vtank.tank import load_whole

NAMES = sorted(f"whole/{path.stem}" for path in (scenarios_dir() / "whole").glob("*.toml"))
HEAVE = """
vehicle = "{vehicle}"
duration_s = 20.0
[[excite]]
kind = "multisine"
axis = "{axis}"
amplitudes{unit} = [{size}]
frequencies_rad_s = [1.0]
"""


def scenario(folder: Path, vehicle: str = "bluerov2", axis: str = "heave", size: float = 10.0, **replaced: str) -> Path:
    path = folder / "mine.toml"
    unit = "_N" if axis in AXES[:3] else "_N_m"
    text = HEAVE.format(vehicle=vehicle, axis=axis, unit=unit, size=size)
    for find, replacement in replaced.items():
        assert find in text
        text = text.replace(find, replacement)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", ["bluerov2", "phoenix", "kingfisher", "remus100"])
def test_the_input_for_a_force_makes_that_force(name: str) -> None:
    for thruster in load_vehicle(name).thrusters:
        for side in (1.0, -1.0):
            most = np.abs(thruster.force_N(side * np.linspace(0.0, 1.0, 11) * (1.0 if thruster.curve else 20.0))).max()
            wanted = side * most * np.linspace(0.0, 1.0, 41)
            assert thruster.force_N(thruster.input_for(wanted)) == pytest.approx(wanted, abs=2e-3 * most)


def test_the_input_for_a_force_bridges_the_dead_band() -> None:
    thruster = Thruster("a", (1.0, 0.0, 0.0), 40.0, input="command", gain=40.0, dead_band=0.1)
    assert thruster.input_for(np.array([-4.0, 0.0, 4.0, 40.0])) == pytest.approx([-0.2, 0.0, 0.2, 1.0], abs=1e-4)


@pytest.mark.parametrize(("vehicle", "axis"), [("bluerov2", axis) for axis in AXES] + [("phoenix", "heave")])
def test_thrusters_share_a_force_so_that_it_is_along_its_axis_alone(tmp_path: Path, vehicle: str, axis: str) -> None:
    size = 6.0 if axis in AXES[:3] else 0.5
    flown = load_whole_scenario(scenario(tmp_path, vehicle, axis, size))
    table = flown.commands()
    whole = load_whole(flown.vehicle)
    control = whole.control({key: values for key, values in table.items() if key != "time_s"})
    wrench = control @ whole.model.actuator_gear[: whole.model.nu]
    expected = np.zeros_like(wrench)
    expected[:, AXES.index(axis)] = size * np.sin(table["time_s"])
    assert wrench == pytest.approx(expected, abs=2e-2 * size)


def test_an_excited_axis_moves_as_its_equation_says(tmp_path: Path) -> None:
    """Amplitude in heave, harmonic balance: F = w U sqrt((m + m_A)2 + (8/(3 pi) D U + d)2/w2)."""
    flown = load_whole_scenario(scenario(tmp_path, size=15.0, **{"[1.0]": "[2.0]"}))
    vehicle = replace(flown.vehicle, sensors=(Sensor("log", ("heave_m_s",), rate_hz=100.0),))
    thrusters = tuple(replace(thruster, lag_s=0.0) for thruster in vehicle.thrusters)
    run = fly_vehicle(replace(vehicle, thrusters=thrusters), flown.commands(), 20.0)
    late = run.samples("log.heave_m_s")[1][1000:]
    speeds = np.linspace(0.0, 1.0, 2001)
    mass, drag = 13.5 + 18.68, 8.0 / (3.0 * np.pi) * 190.0 * speeds + 33.0
    balance = speeds * np.hypot(2.0 * mass, drag)
    assert 0.5 * np.ptp(late) == pytest.approx(np.interp(15.0, balance, speeds), rel=0.03)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"vehicle": "remus100"}, "excite[0].axis: the thrusters of remus100 cannot push along heave alone"),
        ({"size": 400.0}, "excite[0].amplitudes_N: expected a number from -100 to 100"),
        ({"size": 40.0, "axis": "yaw"}, "N of thruster thruster_1, which makes "),
        ({"size": 99.0, "vehicle": "phoenix"}, "of thruster tunnel_bow_vertical, which makes -8.9 N at most"),
        (
            {"multisine": "multisin"},
            "excite[0].kind: expected one of multisine, chirp, square, step_coast, zigzag, spiral",
        ),
        ({"amplitudes_N": "amplitudes_rpm"}, "excite[0].amplitudes_rpm: wrong unit: expected 'amplitudes_N' [N]"),
        ({'axis = "heave"': 'input = "thruster_9_command"'}, "excite[0].input: expected one of thruster_1_command"),
        (
            {
                'axis = "heave"': 'input = "thruster_5_command"',
                '"multisine"': '"square"\namplitude = 1.6',
                "amplitudes_N = [10.0]": "",
                "frequencies_rad_s = [1.0]": "frequency_rad_s = 1.0",
            },
            "excite[0].amplitude: thruster_5_command is asked for 1.6; expected -1 to 1, full astern to full ahead",
        ),
        ({"duration_s": "duration_min"}, "duration_min: wrong unit: expected 'duration_s' [s]"),
        ({"excite": "excites"}, "excite"),
    ],
)
def test_what_cannot_be_flown_is_told(tmp_path: Path, options: dict, said: str) -> None:
    path = scenario(tmp_path, **options)
    with pytest.raises(InputError) as caught:
        load_whole_scenario(path).commands()
    assert said in str(caught.value) and str(path) in str(caught.value)


def test_the_scenarios_that_come_with_vtank_fly_from_the_command_line(tmp_path: Path, capsys) -> None:
    out = tmp_path / "flown"
    assert main(["run", *NAMES, "--set", "duration_s=20", "--seed", "5", "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert "dvl.heave_m_s" in told and "imu.yaw_rate_rad_s" in told
    runs = read_dataset(out).runs
    assert [f"whole/{run.name}" for run in runs] == NAMES and len(NAMES) == 7
    seeds = [entry["seed"] for entry in read_truth(out)["scenarios"]]
    assert seeds[0] == 5 and len(set(seeds)) == 7
    assert main(["check-data", str(out)]) == 0 and "remus100-zigzag" in capsys.readouterr().out


def test_runs_of_one_data_set_have_noise_of_their_own(tmp_path: Path) -> None:
    """The first is the scenario flown alone; the second flies alike, with other errors and other samples lost."""
    path = scenario(tmp_path, size=2.0)
    (again := tmp_path / "again.toml").write_text(path.read_text())
    _, flights = fly_scenarios([path, again], seed=3)
    (alone,) = fly_scenarios([path], seed=3)[1]
    first, second = (flown.run.samples("depth.depth_m")[1] for flown in flights)
    assert np.array_equal(first, alone.run.samples("depth.depth_m")[1])
    count = min(first.size, second.size)
    noise = [np.diff(depth[:count], 3) for depth in (first, second)]
    assert abs(np.corrcoef(noise)[0, 1]) < 0.3


def test_a_rudder_zigzag_turns_the_hull_to_either_side(tmp_path: Path) -> None:
    out = tmp_path / "zigzag"
    assert main(["run", "whole/remus100-zigzag", "--out", str(out)]) == 0
    rate = read_dataset(out).runs[0].samples("imu.yaw_rate_rad_s")[1]
    assert rate.min() < -0.15 and rate.max() > 0.15


def test_experiments_of_one_axis_and_of_whole_vehicles_do_not_mix(tmp_path: Path, capsys) -> None:
    (tmp_path / "held.toml").write_text('hold = "rigid"\n', encoding="utf-8")
    assert is_whole(NAMES[0]) and not is_whole("sway") and not is_whole(tmp_path / "held.toml")
    for arguments, said in (
        ([NAMES[0], "sway"], "sway: an experiment of one axis"),
        ([NAMES[0], "--truth", "physical"], "--truth and --model go with experiments of one axis"),
    ):
        assert main(["run", *arguments, "--out", str(tmp_path / "out")]) == 2
        assert said in capsys.readouterr().err


def test_the_summary_tells_of_a_vehicle_that_turns_round_and_round() -> None:
    """A Phoenix whose tunnels do not hold its heading in a zig-zag: the course goes on beyond half a turn."""
    zigzag = load_whole_scenario("whole/zigzag", ("vehicle=phoenix",))
    heading = np.r_[np.linspace(0.0, np.pi - 0.01, 50), np.linspace(-np.pi + 0.01, -0.2, 50)]
    run = Run("run_1", 0.1 * np.arange(100), {"attitude.heading_rad": heading})
    assert "attitude.heading_rad +0 to +6.08" in summary(zigzag, Flown(run))


def test_a_vehicle_above_the_water_and_one_that_sinks_are_told() -> None:
    """vtank's water has neither surface nor floor: nothing would seem wrong."""
    zigzag = load_whole_scenario("whole/zigzag", ("vehicle=bluerov2", "duration_s=3", "depth_m=0"))
    said = summary(zigzag, fly_whole(zigzag))
    assert re.search(r"; above the surface from [\d.]+ s, by up to [\d.e-]+ m: there is water here, too$", said), said
    deep = load_whole_scenario("whole/zigzag", ("vehicle=bluerov2", "duration_s=3", "depth_m=2", "hold=[]"))
    assert "surface" not in summary(deep, fly_whole(deep))
    sunk = Flown(
        Run("run_1", np.arange(3.0), {"imu.yaw_rate_rad_s": np.zeros(3)}), depth="depth 1 to 57 m, and no floor"
    )
    assert summary(deep, sunk).endswith("; depth 1 to 57 m, and no floor")
