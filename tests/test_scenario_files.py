"""Scenario files: every one that comes with vtank, and what is said about a wrong one."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest

from vtank.errors import InputError
from vtank.experiment.clearance import check_command
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import Control, Sonar, SonarFilter, Tachometer, Turbulence, load_scenario, scenario_names
from vtank.record.suffix import UNITS, split_unit
from vtank.record.toml import meant, nearest, override
from vtank.resources import scenarios_dir

GOOD = """
duration_s = 20.0
[excitation]
kind = "position_sine"
amplitude_m = 0.3
frequency_rad_s = 0.5
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "trial.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", scenario_names())
def test_scenarios_that_come_with_vtank_load_and_keep_clear_of_the_walls(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name and scenario.description
    check_command(scenario)


def test_the_papers_experiments_are_those_of_the_paper() -> None:
    frequencies = [load_scenario(f"paper-ds{i}").excitation.frequencies_rad_s for i in (1, 2, 3, 4)]
    assert frequencies == [(0.5,), (0.4,), (0.7,), (0.2,)]
    scenario = load_scenario("paper-ds1")
    assert scenario.standoff_m == pytest.approx(3.048) and scenario.depth_m == pytest.approx(0.9144)
    assert scenario.filter.r_m2 == pytest.approx(0.01 * 0.3048**2)
    assert scenario.samples == 1201 and scenario.time_s[-1] == pytest.approx(120.0)


def test_defaults_are_null_values(tmp_path: Path) -> None:
    scenario = load_scenario(written(tmp_path, GOOD))
    sonar = scenario.sonar
    assert (sonar.noise_m, sonar.resolution_m, sonar.dropout, sonar.width_deg) == (0.0, 0.0, 0.0, 0.0)
    assert sonar.max_range_m == float("inf")
    assert (scenario.tachometer.noise_rev_s, scenario.tachometer.governor_per_s) == (0.0, 0.0)
    assert scenario.turbulence.acceleration_m_s2 == 0.0
    assert not scenario.effects


def test_a_controller_that_is_not_told_a_thrust_takes_that_of_the_truth(tmp_path: Path) -> None:
    """A vehicle of one's own would else be driven with the Phoenix's, ten times too hard or too softly."""
    own = plan_run(load_scenario(written(tmp_path, 'truth = "bluerov2"\n' + GOOD)))
    assert own.thrust_m_per_rev2 == own.truth.beta_m_per_rev2
    told = plan_run(load_scenario(written(tmp_path, GOOD + "[control]\nthrust_m_per_rev2 = 0.001\n")))
    assert told.thrust_m_per_rev2 == 0.001
    assert plan_run(load_scenario("paper-ds1")).thrust_m_per_rev2 == 0.0005


def test_filter_takes_feet_or_metres(tmp_path: Path) -> None:
    feet = load_scenario(written(tmp_path, GOOD + "[filter]\nq_ft2_per_s5 = 2.0\nr_ft2 = 0.02\n")).filter
    metres = load_scenario(written(tmp_path, GOOD + "[filter]\nq_m2_per_s5 = 0.18580608\nr_m2 = 0.0018580608\n")).filter
    assert feet.q_m2_per_s5 == pytest.approx(metres.q_m2_per_s5) and feet.r_m2 == pytest.approx(metres.r_m2)
    assert SonarFilter().r_m2 == pytest.approx(0.5 * feet.r_m2)


# text appended to or replacing part of a good file -> words of the message
WRONG = {
    "unknown key": (
        GOOD.replace("duration_s", "duratoin_s"),
        ["trial.toml:2", "duratoin_s", "did you mean 'duration_s'"],
    ),
    "unknown key in a table": (GOOD + "[sonar]\nnoize_m = 1\n", ["trial.toml:8", "sonar.noize_m", "'noise_m'"]),
    "unit of another system": (GOOD + "[sonar]\nnoise_ft = 1\n", ["sonar.noise_ft", "'noise_m' [m]", "[ft]"]),
    "unit where the key is needed": (
        GOOD.replace("amplitude_m", "amplitude_ft"),
        ["amplitude_ft", "'amplitude_m' [m]"],
    ),
    "unit where two keys would do": (
        GOOD.replace("position_sine", "square").replace("amplitude_m", "amplitude_rpm"),
        ["excitation.amplitude_rpm", "wrong unit", "[rpm]"],
    ),
    "both loops at once": (
        GOOD.replace("position_sine", "square") + "amplitude_rev_s = 3\n",
        ["exactly one of amplitude_m, amplitude_rev_s"],
    ),
    "missing key": (GOOD.replace("amplitude_m = 0.3", ""), ["excitation.amplitude_m", "missing", "[m]"]),
    "text for a number": (
        GOOD.replace("20.0", '"20"'),
        ["trial.toml:2", "duration_s", "expected a number [s]", "'20'"],
    ),
    "boolean for a number": (GOOD.replace("20.0", "true"), ["duration_s", "expected a number"]),
    "not a number": (GOOD.replace("20.0", "nan"), ["duration_s", "expected a number"]),
    "negative": (GOOD + "[sonar]\nnoise_m = -0.1\n", ["sonar.noise_m", "from 0 to 10", "-0.1"]),
    "infinite": (GOOD.replace("0.3", "inf"), ["excitation.amplitude_m", "from -100 to 100"]),
    "no such kind": (GOOD.replace("position_sine", "postion_sine"), ["excitation.kind", "position_sine"]),
    "no such effect": (GOOD + "[effects.linear_drug]\nc_per_s = 1\n", ["effects.linear_drug", "'linear_drag'"]),
    "no such parameter": (GOOD + "[effects.linear_drag]\nd_per_s = 1\n", ["effects.linear_drag.d_per_s", "c_per_s"]),
    "effect's wrong unit": (
        GOOD + "[effects.seiche]\namplitude_ft_s = 1\n",
        ["amplitude_ft_s", "'amplitude_m_s' [m/s]"],
    ),
    "effect out of bounds": (GOOD + "[effects.thrust_loss]\ngamma_per_rev = 0.1\n", ["gamma_per_rev", "from -2 to 0"]),
    "effect without a table": (GOOD.replace("[exc", "effects = 3\n[exc"), ["effects", "expected a table"]),
    "ping rate": (GOOD + "[sonar]\nrate_hz = 7\n", ["sonar.rate_hz", "10 Hz, divided by a whole number"]),
    "period": (GOOD.replace("20.0", "20.0\nperiod_s = 0.015"), ["period_s", "multiple"]),
    "seed": (GOOD.replace("20.0", "20.0\nseed = 1.5"), ["seed", "whole number"]),
    "list lengths": (
        GOOD.replace("position_sine", "multisine")
        .replace("amplitude_m = 0.3", "amplitudes_m = [0.1, 0.1]")
        .replace("frequency_rad_s = 0.5", "frequencies_rad_s = [0.5]"),
        ["frequencies_rad_s", "expected 2 numbers"],
    ),
    "both filter units": (GOOD + "[filter]\nr_ft2 = 0.01\nr_m2 = 0.001\n", ["filter.r_ft2", "exactly one"]),
    "not TOML": (GOOD + "[sonar\n", ["trial.toml", "not valid TOML", "line 7"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_file_is_told_by_file_line_and_key(case: str, tmp_path: Path) -> None:
    text, words = WRONG[case]
    with pytest.raises(InputError) as error:
        load_scenario(written(tmp_path, text))
    assert str(tmp_path) in str(error.value)
    for word in words:
        assert word in str(error.value)


def test_an_unknown_name_lists_the_scenarios() -> None:
    with pytest.raises(InputError, match="paper-ds1, paper-ds2.* and [0-9]+ more; or the path"):
        load_scenario("paper-ds9")


def test_settings_override_and_errors_name_them(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD)
    settings = [
        "sonar.noise_m=0.01",
        "truth=physical",
        "effects.linear_drag.c_per_s=0.2",
        "excitation.amplitude_m = 0.1",
    ]
    scenario = load_scenario(path, settings)
    assert scenario.sonar.noise_m == 0.01 and scenario.truth == "physical"
    assert scenario.effects == {"linear_drag.c": 0.2} and scenario.excitation.amplitudes == (0.1,)
    for setting, word in [
        ("sonar.noise_m=loud", "expected a number"),
        ("duration_min=3", "duration_s"),
        ("x", "key=value"),
        ("foo.bar=3", "foo: unknown key"),
        ("effects.linear_drg.c_per_s=1", "effects.linear_drg: unknown key; did you mean 'linear_drag'"),
        ("waves.height_m=1", "waves.kind: missing"),
    ]:
        with pytest.raises(InputError, match=word) as error:
            load_scenario(path, [setting])
        assert "--set " + setting.split("=")[0] in str(error.value)
    entries = {"hold": [{"axis": "yaw"}, {"axis": "surge"}], "sizes": [1.0, 2.0]}
    assert override(entries, "hold[1].axis=sway") == override(entries, "hold.1.axis = sway") == "hold[1].axis"
    assert override(entries, "hold.0.at.m=2") == "hold[0].at.m" and override(entries, "sizes[1]=3") == "sizes[1]"
    assert entries == {"hold": [{"axis": "yaw", "at": {"m": 2}}, {"axis": "sway"}], "sizes": [1.0, 3]}
    for setting in ("hold[2].axis=sway", "hold.axis=sway", "hold.9.axis=sway", "sizes.x=1"):
        with pytest.raises(InputError, match=r"is an array; expected one of its parts: \w+\[0\], \w+\[1\]"):
            override(entries, setting)
    with pytest.raises(InputError, match="is a value and not a table"):
        override({"seed": 1}, "seed.x=2")


def test_a_command_that_would_hit_a_wall_is_refused(tmp_path: Path) -> None:
    for amplitude, standoff, words in [
        (3.2, 3.048, "hits the wall ahead"),
        (1.0, 3.048, "hits the wall astern"),
        (0.74, 3.048, "too near the wall astern: 0.09 m"),
        (0.1, 6.0, "hits the wall astern"),
    ]:
        path = written(tmp_path, GOOD.replace("0.3", str(amplitude)).replace("20.0", f"20.0\nstandoff_m = {standoff}"))
        with pytest.raises(InputError, match=words) as error:
            check_command(load_scenario(path))
        assert "trial.toml" in str(error.value)


def test_a_name_is_offered_where_it_is_near_and_not_for_its_unit() -> None:
    inputs = [f"thruster_{k}_command" for k in range(1, 9)]
    assert nearest("port_command", inputs) == "" and meant("port_command", inputs).startswith("; there are: thruster_1")
    assert nearest("thruster8_command", inputs) == "thruster_8_command"
    assert nearest("lagg_s", ["limit_s", "lag_s"]) == "lag_s" and nearest("zigzag", ["whole/zigzag"]) == "whole/zigzag"


def test_a_frequency_that_the_commands_cannot_follow_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        load_scenario(written(tmp_path, GOOD), ["excitation.frequency_rad_s=32.0"])
    told = "excitation.frequency_rad_s (over "
    assert told in str(error.value) and "expected less than 31.42 rad/s, found 32" in str(error.value)


def test_units_are_split_from_the_longest_suffix() -> None:
    assert split_unit("c_per_s2") == ("c", "1/s2")
    assert split_unit("amplitude_rev_s") == ("amplitude", "rev/s")
    assert split_unit("acceleration_m_s2") == ("acceleration", "m/s2")
    assert split_unit("dropout") == ("dropout", "")
    suffixes = list(UNITS)
    for i, suffix in enumerate(suffixes):
        assert not any(suffix.endswith(earlier) for earlier in suffixes[:i]), suffix


def numbers(part: object) -> list[float]:
    """The numbers of a dataclass."""
    return [value for value in vars(part).values() if isinstance(value, float)]


def test_the_reference_of_all_keys_is_complete_and_current(tmp_path: Path) -> None:
    text = (scenarios_dir() / "README.md").read_text(encoding="utf-8")
    example = text.split("```toml")[1].split("```")[0]
    shown, bare = load_scenario(written(tmp_path, example)), load_scenario(written(tmp_path, GOOD))
    for part in ("sonar", "tachometer", "turbulence", "filter", "control", "waves"):
        assert numbers(getattr(shown, part)) == pytest.approx(numbers(getattr(bare, part)))
    assert (shown.period_s, shown.standoff_m, shown.depth_m) == pytest.approx(
        (bare.period_s, bare.standoff_m, bare.depth_m)
    )
    assert (shown.truth, shown.hold, shown.seed) == (bare.truth, bare.hold, bare.seed)
    assert (shown.vehicle, shown.walls, shown.waves) == (bare.vehicle, bare.walls, bare.waves)
    assert shown.excitation.axis == bare.excitation.axis
    for kind in (Sonar, Tachometer, Turbulence, Control):
        assert all(f"{field.name} = " in example for field in fields(kind))
    for name in scenario_names():
        assert f"| {name} |" in text or name.startswith("paper-ds")
