"""A diagnosis in words: every kind of verdict, every answer, and what is missing is said to be missing."""

from __future__ import annotations

import re
from typing import Any

import pytest

from vtank.plant.parameters import unit_of
from vtank.present import likeness, whole, words
from vtank.present.document import plain
from vtank.present.terminal import terminal_text

MINUS = "\N{MINUS SIGN}"


def document(kind: str = "effect", effects: tuple[str, ...] = ("linear_drag",), **changes: Any) -> dict[str, Any]:
    """A small document of schema vtank.diagnosis/2."""
    chance = 0.0 if kind in ("none", "parameters") else 0.95
    acting = None if kind in ("none", "parameters") else "hydrodynamics"
    return {
        "schema": "vtank.diagnosis/2",
        "verdict": {"kind": kind, "effects": list(effects), "class": list(effects), "channel": acting,
                    "probability": 0.95},
        "probabilities": {"none": 0.01, "parameters": 0.02, "linear_drag": 0.95, "unknown": 0.02},
        "where": {
            "channel": {
                "probability": {"hydrodynamics": chance, "actuator": 0.02, "sensor": 0.01, "none": 0.97 - chance},
                "log_evidence_gain": {"refit": {"force": 9.0, "sensor": 2.0}, "best": {"force": -1.0, "sensor": -1.0}},
            },
            "runs": [
                {"run": "a", "duration_s": 60.0, "unit": "m", "nominal": 0.08, "refit": 0.03, "diagnosed": 0.008,
                 "floor": 0.007, "share": 0.8},
                {"run": "b", "duration_s": 60.0, "unit": "m", "nominal": 0.6, "refit": 0.02, "diagnosed": 0.007,
                 "floor": 0.007, "share": 0.2},
            ],
            "time_s": [{"run": "a", "from": 10.0, "to": 30.0, "log_likelihood_gain": 40.0}],
            "frequency_rad_s": [
                {"run": "a", "frequency": 1.5, "power": 30.0, "false_alarm": 1e-6, "coherence": 0.9, "coherent": True,
                 "drive": 0.5, "multiple_of_drive": 3},
            ],
            "region": {
                "surge_m_s": {"log_likelihood_gain": 100.0, "share": 0.8, "bins": [
                    {"from": 0.1, "to": 0.2, "acceleration": -0.004, "band": [-0.005, -0.003], "unit": "m/s2"}]},
                "n_rev_s": {"log_likelihood_gain": 3.0, "share": 0.02, "bins": []},
                "distance_m": {"log_likelihood_gain": 4.0, "share": 0.03, "bins": [
                    {"from": 2.0, "to": 2.5, "acceleration": 0.001, "band": [0.0, 0.002], "unit": "m/s2"}]},
            },
        },
        "shrink": {"unit": "m", "nominal": 0.08, "refit": 0.03, "diagnosed": 0.008, "floor": 0.007,
                   "fraction_closed": 0.957, "interval90": [0.91, 0.99]},
        "estimates": {"linear_drag": {"c": {"value": 0.0794, "interval95": [0.0775, 0.0813], "unit": "1/s"}}},
        "absorbed": ["sonar_scale", "sonar_offset"],
        "tied": [["command_delay", "sonar_latency"]],
        "next_experiment": {"experiment": "a sine of 8 rev/s at 0.7 rad/s", "minutes": 2.0, "per_minute": 0.9,
                            "against_repeat": 6.0, "question": "how large", "alternatives": []},
        **changes,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "effects", "start"),
    [
        ("none", (), "No gap"),
        ("parameters", (), "The simulator's structure is right"),
        ("effect", ("linear_drag",), "The gap is caused by linear drag."),
        ("effects", ("seiche", "thrust_lag"), "The gap has two causes: seiche and thrust lag."),
        ("effects", ("seiche", "tether", "thrust_lag"), "The gap has three causes: seiche, tether and thrust lag."),
        ("unknown", (), "Something is missing"),
        ("undecided", ("tether",), "Undecided: perhaps tether"),
    ],
)
def test_every_verdict_has_a_sentence(kind: str, effects: tuple[str, ...], start: str) -> None:
    found = document(kind, effects)
    assert words.headline(found).startswith(f"Compared with given parameters. {start}")
    assert words.explanation(found)[-1] == "Probability: 95 %."


@pytest.mark.parametrize("name", ["none", "parameters", "unknown"])
def test_what_is_likelier_wrong_than_right_is_told_as_a_possibility(name: str) -> None:
    found = document("undecided", ())
    found["probabilities"] = {"tether": 0.3, "seiche": 0.05, "linear_drag": 0.2, "coulomb_friction": 0.04, name: 0.41}
    found["verdict"]["probability"] = 0.41
    assert words.verdict(found).startswith("Undecided: perhaps ")
    assert words.headline(found).endswith("these recordings do not settle it.")
    told = words.explanation(found)
    assert told[-2] == "Possible as well: tether (30 %), linear drag (20 %) and seiche (5 %)."
    assert told[-1] == "Probability: 41 %."


def test_a_class_of_effects_is_told_as_alternatives() -> None:
    found = document()
    found["verdict"]["class"] = ["sonar_latency", "command_delay"]
    assert words.verdict(found) == "The gap is caused by sonar latency or command delay."
    assert words.ties(found)[0].startswith("Sonar latency and command delay are indistinguishable here")
    assert not any("indistinguishable to one sonar" in line for line in words.ties(found))


def test_an_unknown_cause_names_the_best_known_explanation() -> None:
    assert "the best known effect, linear drag, leaves a part" in words.explanation(document("unknown", ()))[0]


def test_where_in_words() -> None:
    found = document()
    assert words.channel(found) == "It acts as a force of the water on the hull (hydrodynamics, probability 95 %)."
    assert words.runs(found) == "It shows most in a (80 % of the evidence)."
    assert words.time(found) == "It shows in a from 10 to 30 s."
    later = {"run": "a", "from": 40.0, "to": 50.0, "log_likelihood_gain": 90.0}
    found["where"]["time_s"].append(later)
    assert words.time(found) == "It shows in a from 10 to 30 s and 40 to 50 s."
    assert words.frequency(found) == "What the refit cannot predict stands out at 3 times the drive frequency."
    assert words.region(found) == (
        "The force that the refit lacks goes with the speed (\N{MINUS SIGN}4 mm/s² at 0.1 to 0.2 m/s)."
    )


def test_a_gap_that_is_no_function_of_the_motion() -> None:
    found = document()
    found["where"]["region"]["surge_m_s"]["share"] = 0.05
    assert words.region(found) == "It is no function of speed, input or place: they explain little of it."


def test_a_gap_throughout_a_drift_and_a_rhythm_of_its_own() -> None:
    found = document()
    found["where"]["time_s"][0] |= {"from": 0.0, "to": 110.0}
    line = found["where"]["frequency_rad_s"][0] | {"multiple_of_drive": None}
    found["where"]["frequency_rad_s"] = [line | {"frequency": 0.894}, line | {"frequency": 0.05}]
    assert words.time(found) == "It is there throughout."
    assert words.frequency(found) == (
        "What the refit cannot predict stands out at 0.89 rad/s, which is no multiple of the drive and as a slow drift."
    )


def test_causes_in_different_channels_are_told_one_by_one() -> None:
    found = document("effects", ("ambient_current", "thrust_deadband"))
    assert words.channel(found) == (
        "Ambient current acts as a force of the water on the hull (hydrodynamics) and "
        "thrust deadband acts through the thrust (actuator)."
    )
    assert words.channel(document("effects", ("ambient_current", "tether"))).startswith("It acts as a force")


def test_the_simulators_own_parameters_are_told_where_they_are_off() -> None:
    own = {"alpha": {"nominal": -2.5561, "refit": -3.2, "diagnosed": -3.2, "unit": "1/m"}}
    told = "quadratic drag: \N{MINUS SIGN}3.2 1/m (as it is \N{MINUS SIGN}2.556)"
    assert told in terminal_text(document("parameters", (), parameters=own))
    assert "quadratic drag" not in terminal_text(document("none", (), parameters=own))


def test_many_candidates_fit_the_width_and_each_matches_the_first() -> None:
    found = document()
    found["verdict"]["class"] = ["ambient_current", "drag_asymmetry", "seiche", "wake_memory", "thrust_asymmetry"]
    assert max(map(len, terminal_text(found, 60).splitlines())) <= 60
    assert "are matched by each of the others" in words.ties(found)[0]


def test_several_effects_that_explain_too_little_are_told_in_the_plural() -> None:
    found = document("unknown", ())
    assert "the best known effect, linear drag, leaves a part" in words.explanation(found)[0]
    found["estimates"]["tether"] = {}
    assert "the best known effects, linear drag and tether, leave a part" in words.explanation(found)[0]


def test_nothing_found_is_said() -> None:
    found = document("none", ())
    found["where"] |= {"time_s": [], "frequency_rad_s": []}
    found["where"]["region"] = {"surge_m_s": {"log_likelihood_gain": 1.0, "share": 0.1, "bins": []}}
    assert words.channel(found) == "No channel is at fault (probability 97 %)."
    assert words.time(found) == "No stretch of time stands out by itself."
    assert words.frequency(found) == "No frequency stands out of the noise."
    assert words.region(found).startswith("No missing force stands out")


def test_shrinkage_with_interval_without_one_and_absent() -> None:
    found = document()
    assert words.shrinkage(found).endswith(
        "The diagnosis closes 96 % of what refitting leaves beyond noise (on new data nine times out of ten 91 "
        "to 99 %)."
    )
    assert words.shrinkage(found).startswith("On runs left out, of which only the start is used, the error is 80 mm")
    found["shrink"]["interval90"] = [-0.002, 1.0]
    assert words.shrinkage(found).endswith("nine times out of ten 0 to 100 %).")
    found["where"]["runs"] = found["where"]["runs"][:1]
    assert words.shrinkage(found).startswith("On stretches of time left out")
    found["shrink"]["interval90"] = None
    assert words.shrinkage(found).endswith("closes 96 % of what refitting leaves beyond noise.")
    found["shrink"]["fraction_closed"] = None
    assert words.shrinkage(found).endswith("Refitting leaves next to nothing to close.")
    assert "was not worked out" in words.shrinkage(document(shrink={}))


def test_the_next_experiment() -> None:
    assert words.next_experiment(document()) == (
        "Best next, to sharpen the estimates: a sine of 8 rev/s at 0.7 rad/s (2 min). "
        "Per minute it tells 6 times as much as repeating a run."
    )
    assert "was worked out" in words.next_experiment(document(next_experiment={}))
    no_better = document()["next_experiment"] | {"against_repeat": 1.0}
    assert words.next_experiment(document(next_experiment=no_better)).endswith("than repeating a run.")


def test_without_a_sonar_nothing_is_said_of_sonars() -> None:
    found = document()
    del found["where"]["region"]["distance_m"]
    assert words.ties(found) == []


@pytest.mark.parametrize(
    ("share", "text"), [(0.0, "0 %"), (0.004, "under 1 %"), (0.5, "50 %"), (0.9951, "over 99 %"), (1.0, "over 99 %")]
)
def test_no_probability_is_rounded_to_certainty(share: float, text: str) -> None:
    assert words.percent(share) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.0123, "m", "12.3 mm"),
        (0.2, "m", "0.2 m"),
        (-0.004, "m/s2", "\N{MINUS SIGN}4 mm/s²"),
        (0.05, "m/s", "50 mm/s"),
    ],
)
def test_lengths_have_fitting_units(value: float, unit: str, text: str) -> None:
    assert words.length(value, unit) == text


def test_units_follow_the_input() -> None:
    assert unit_of("thrust_saturation.n_max") == "rev/s" and unit_of("beta") == "m/rev2"
    assert unit_of("thrust_saturation.n_max", "command") == "-" and unit_of("beta", "command") == "m/s2"
    assert unit_of("beta", "thrust_N") == "1/kg" and unit_of("force_offset", "thrust_N") == "N"


def test_the_nominal_is_named_first_and_none_is_no_simulator() -> None:
    own = {"alpha": {"nominal": -2.5561, "refit": -3.2, "diagnosed": -3.2, "unit": "1/m"}}
    for kind, effects in (("none", ()), ("parameters", ()), ("effect", ("linear_drag",)), ("unknown", ()),
                          ("undecided", ())):  # fmt: skip
        named = terminal_text(document(kind, effects, parameters=own, nominal="barge"))
        assert named.startswith("Compared with barge. ")
        alone = terminal_text(document(kind, effects, parameters=own, nominal="none"))
        assert alone.startswith("Without a simulator to compare with, drag and thrust were fitted")
        assert "as it is" not in alone and "the simulator" not in alone and "refitting it" not in alone
    default = words.headline(document(nominal="paper-ii", nominal_by_default=True))
    assert default.startswith("Compared with paper-ii, the Phoenix of 1996, since no simulator was named. The gap")


def test_sizes_are_told_in_newton_where_the_mass_is_known() -> None:
    mass = {"value": 95.1, "interval95": [94.0, 96.2], "unit": "kg"}
    beta = {"nominal": 0.01, "refit": 0.01, "diagnosed": 0.0105, "unit": "1/kg", "mass": mass}
    found = document(parameters={"beta": beta})
    found["estimates"]["linear_drag"]["c"]["force"] = {"value": 203.5, "interval95": [200.0, 207.0], "unit": "N s/m"}
    told = " ".join(terminal_text(found).split())
    assert "linear drag, drag per speed: 203.5 N s/m (95 %: 200 to 207)" in told
    assert "moving mass: 95.1 kg (95 %: 94 to 96.2)" in told


@pytest.mark.parametrize("width", [60, 100])
def test_the_terminal_text_has_all_answers_in_order_and_keeps_its_width(width: int) -> None:
    text = terminal_text(document(), width)
    lines = text.splitlines()
    assert " ".join(lines[:2]).startswith("Compared with given parameters. The gap is caused by linear drag.")
    places = [next(i for i, line in enumerate(lines) if line.startswith(h)) for h in
              ("Where", "Which", "How far", "Ties", "Next")]  # fmt: skip
    assert places == sorted(places)
    assert max(len(line) for line in lines if "mm" not in line or " a " not in line) <= width
    assert "0.0794 1/s (95 %: 0.0775 to 0.0813)" in " ".join(text.split())
    assert any(line.split() == ["a", "80", "mm", "30", "mm", "8", "mm", "7", "mm"] for line in lines)


@pytest.mark.parametrize(
    ("name", "share", "told"),
    [
        ("thruster_dead", 0.49, "thruster 4 lacks 49 % of its force"),
        ("thruster_dead", 1.0, "thruster 4 lacks 100 % of its force"),
        ("thrust_lag", 0.3, "thrust lag at thruster 4 (why)"),
    ],
)
def test_what_a_part_has_lost_is_told_with_its_share(name: str, share: float, told: str) -> None:
    """No thruster that has half of its thrust is called dead."""
    values = {"share": {"value": share, "sd": 0.01, "unit": "-"}}
    assert whole.found({"name": name, "place": "thruster_4", "sentence": "why", "values": values}) == told


def test_hypotheses_of_whole_vehicles_are_told_in_words() -> None:
    told = {
        "thruster_dead@thruster_4": "thruster 4 lacks part of its force",
        "linear_drag@yaw+gyro_bias@imu": "linear drag at yaw and gyro bias at imu",
        "sensor_scale@imu:imu.accel_x_m_s2": "sensor scale at imu (acceleration ahead, imu)",
        "unknown@sway": "an unmodelled cause at sway",
        "none": "no gap",
    }
    assert {name: whole.hypothesis(name) for name in told} == told


def test_the_report_of_a_whole_vehicle_names_its_cause_and_units() -> None:
    """In the title the cause, its size as a share, own parameters with their units, one sign for minus."""
    lost = {"name": "thruster_dead", "place": "thruster_1", "column": "", "sentence": "why",
            "values": {"share": {"value": 0.3, "sd": 0.01, "unit": "-"}}}  # fmt: skip
    verdict = {"kind": "effect", "effects": ["thruster_dead"], "places": ["thruster_1"], "class": [], "doubt": "",
               "probability": 0.98, "unexplained": []}  # fmt: skip
    own = [("quadratic_drag@surge", -1e-5), ("added_mass@yaw", 0.2), ("gain@thruster_1/thruster_2", 1.0)]
    found = {
        "nominal": "bluerov2", "runs": ["zigzag"], "axes": ["surge"], "verdict": verdict, "effects": [lost],
        "probabilities": {"thruster_dead@thruster_1": 0.98, "none": 0.02}, "notes": [], "unexplained": {"share": 0.0},
        "budget": [{"name": "own parameters", "kind": "parameters", "share": 0.88, "interval90": [0.86, 0.9]},
                   {"name": "thruster_dead@thruster_1", "kind": "effect", "share": 0.12, "interval90": [-0.1, 0.14]}],
        "parameters": [{"name": name, "nominal": 1.0, "value": value, "sd": 0.1} for name, value in own],
        "channels": {"imu.yaw_rate_rad_s": {"rms": {"nominal": 0.1, "refit": 0.05, "diagnosed": 0.01, "noise": 0.01}}},
        "slow_errors": {},
    }  # fmt: skip
    text = f"{whole.terminal_text(found, 100)}\n{plain(*whole.details(found))}"
    lines = [re.split("  +", line.strip()) for line in text.splitlines()]
    assert lines[0] == ["bluerov2: thruster 1 lacks 30 % of its force"]
    assert ["thruster 1 lacks part of its force", "share", "30", "1", "%"] in lines
    assert ["quadratic drag, surge", "N s²/m²", "1", f"{MINUS}1e{MINUS}05", "0.1"] in lines
    assert ["added mass, yaw", "kg m²", "1", "0.2", "0.1"] in lines
    assert ["gain, thruster 1 and thruster 2", "1", "1", "0.1"] in lines
    assert ["rate of turn, imu", "5.73 °/s", "2.86 °/s", "0.573 °/s", "0.573 °/s"] in lines
    assert f"{MINUS}10 to 14" in text and "thruster_1" not in text and "@" not in text
    assert "may imitate it, are taken off first" in " ".join(text.split())


@pytest.mark.parametrize(("kind", "told"), [("none", False), ("parameters", True)])
def test_where_there_is_no_gap_no_share_of_it_is_left(kind: str, told: bool) -> None:
    verdict = {"kind": kind, "doubt": "", "unexplained": [], "class": [], "places": []}
    line = {"kind": "disturbance", "share": 0.99}
    said = whole.sentence({"verdict": verdict, "budget": [line], "effects": [], "unexplained": {"share": 0.99}})
    assert ("does not repeat" in said) == told


@pytest.mark.parametrize(
    ("of_gap", "kind", "said"),
    [
        (0.1, "effect", "10 % of the gap; what is smaller cannot be told."),
        (1.4, "undecided", "1.4 times the gap; what is smaller cannot be told."),
        (1.4, "unknown", "1.4 times the gap in free runs, yet far less of it step by step."),
    ],
)
def test_what_a_plant_misses_is_told_beside_what_is_named(of_gap: float, kind: str, said: str) -> None:
    found = {"runs": ["a", "b"], "folder": "mine", "share": 0.05, "of_gap": of_gap, "refused": []}
    assert likeness.sentence({"against": found, "verdict": {"kind": kind}}).endswith(said)
