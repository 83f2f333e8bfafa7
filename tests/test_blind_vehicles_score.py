"""Blind trials of whole vehicles answered and scored: nothing is passed over, and what is counted is what was true."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_rigid_motion import multisine

from vtank.cli import main
from vtank.diagnose.whole import Known, known_fits
from vtank.errors import InputError
from vtank.experiment.whole import fly_vehicle
from vtank.plant import load_vehicle
from vtank.record import read_dataset
from vtank.studies.blind.answer import answer
from vtank.studies.blind.closed import Closed
from vtank.studies.blind.score import score, write_score
from vtank.studies.blind.seal import VEHICLES_SCHEMA, Entry, digest, read_index, seal_truth, write_index
from vtank.studies.blind.whole import make
from vtank.studies.blind.whole.case import WholeCase
from vtank.studies.blind.whole.names import scored_name, true_name
from vtank.studies.blind.whole.rows import WholeRow, _covered
from vtank.studies.blind.whole.scheme import invented, measures, place, unknown_place

BLUEROV = load_vehicle("bluerov2")
FLOWN = replace(BLUEROV, sensors=tuple(s for s in BLUEROV.sensors if s.name in ("imu", "dvl")))
OWN = {"linear": BLUEROV.linear_drag.tolist(), "quadratic": BLUEROV.quadratic_drag.tolist(),
       "added_mass": BLUEROV.added_mass.ravel().tolist()}  # fmt: skip


def flight(drag: float, seed: int = 3) -> Any:
    """25 s in the tank with so much more linear drag about yaw than the file has [N m s/rad]."""
    vehicle = replace(FLOWN, linear_drag=FLOWN.linear_drag + [0.0, 0.0, 0.0, 0.0, 0.0, drag])
    return fly_vehicle(vehicle, multisine(BLUEROV, 25.0, seed), 25.0, seed)


def fitted(drag: float) -> Known:
    """Fits that know the drag, and the same flight without it."""
    return known_fits(FLOWN, [flight(drag)], [flight(0.0)], lambda name: name == "linear_drag@yaw")


@pytest.fixture(scope="module")
def known() -> Known:
    """Drag of yaw that the file has not, and the same flight without it."""
    return fitted(0.6)


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sealed cases, one with drag about yaw and one as the file has it, with answers of a fixed opinion."""
    root = tmp_path_factory.mktemp("vehicles")
    cases, sealed, entries = root / "cases", root / "truth", []
    for folder in (cases, sealed):
        folder.mkdir()
    for number, (drag, label) in enumerate([(0.6, "linear_drag@yaw"), (0.0, "none")], 1):
        told = {label: {"c_N_m_s_per_rad": drag}} if drag else {}
        truth = {"kind": "single" if drag else "none", "vehicle": "bluerov2", "label": label, "effects": told,
                 "given": 1, "own": OWN}  # fmt: skip
        case = WholeCase((flight(drag), flight(drag, 4)), (flight(0.0),), 1, "bluerov2", truth)
        entries.append(make._write(cases, sealed, f"case_{number:04d}", (case, 0)))
    write_index(cases, sealed, entries, {"trials": 2, "seed": 1, "vehicles": True})
    answer(cases, root / "answers.json", count=1, answer_case=opinion)
    return root


def opinion(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
    """Drag about yaw, whatever was recorded; its model has the very drag of the first case."""
    assert nominal == "bluerov2" and len(read_dataset(folder).runs) == 1
    name = "linear_drag@yaw"
    verdict = {"kind": "effect", "effects": ["linear_drag"], "places": ["yaw"], "class": [name], "probability": 0.97}
    model = f'schema = "vtank.whole/2"\n[diagnosed]\n"{name}" = {BLUEROV.linear_drag[5] + 0.6}\n'
    return {"document": {"verdict": verdict, "probabilities": {name: 0.97, "none": 0.03}}, "model": model}


def made_up(label: str, said: str, names: tuple[str, ...], p: float = 0.97, d: float = 20.0) -> WholeRow:
    """A row of a case and an answer by hand."""
    kind = label if label in ("none", "parameters", "unknown") else "single"
    effects = {"hunting@yaw": {}} if kind == "unknown" else {label: {}}
    places = [name.partition("@")[2] for name in names]
    verdict = {"kind": said, "class": list(names) if "effect" in said else [], "places": places, "probability": p}
    chances = {scored_name(name): p / len(names) for name in names} | {"none or other": 1.0 - p}
    return WholeRow("case_0001", label, d, {"kind": kind, "effects": effects}, {"verdict": verdict}, chances, "",
                    Closed(), (), "axis")  # fmt: skip


# --- names -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("name", "scored"), [
    ("sensor_scale@dvl:dvl.surge_m_s", "sensor_scale@dvl"), ("wrong_sign@dvl", "sensor_scale@dvl"),
    ("clock_offset@imu", "sensor_latency@imu"), ("unknown@yaw", "unknown"), ("parameters", "parameters"),
    ("wrong_allocation@thruster_2:thruster_1", "wrong_allocation@thruster_1,thruster_2"),
    ("tether@surge+gyro_bias@imu", "gyro_bias@imu+tether@surge"), ("seiche@surge:0.7 rad/s, 0 rad", "seiche@surge"),
])  # fmt: skip
def test_a_law_at_a_place_has_one_name(name: str, scored: str) -> None:
    assert scored_name(name) == scored


def test_exchanged_wires_are_named_by_both_thrusters() -> None:
    told = {"wrong_allocation@thruster_2": {"other": "thruster_1"}}
    truth = {"label": "wrong_allocation@thruster_2", "effects": told}
    assert true_name(truth) == scored_name("wrong_allocation@thruster_1:thruster_2")


# --- what could be told --------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_what_could_be_told_grows_with_the_cause(known: Known) -> None:
    """A third of the drag stands out a third as far or farther, the less so the more motion is left to it; none not.

    Beside quadratic drag c |r| r a linear one of k takes about k / (k + c |r|) off the rate r: 0.5 of what 3 k takes
    off where c |r| is 3 k, 0.33 where it is far larger.
    """
    weak = fitted(0.2)
    assert known.d > 10.0
    assert 0.25 * known.d < weak.d < 0.65 * known.d
    assert fitted(0.0).d < 1.0


def test_the_oracle_finds_the_size_of_the_true_effect(known: Known) -> None:
    assert known.oracle is not None
    assert known.oracle["linear_drag@yaw"] == pytest.approx(FLOWN.linear_drag[5] + 0.6, rel=0.25)


# --- answered and scored ---------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_the_score_counts_what_was_true(trials: Path, tmp_path: Path) -> None:
    scored = score(trials / "cases", trials / "truth", trials / "answers.json", count=1)
    every = scored["measures"]["all"]["all"]
    assert (every["effect and place first"].value, every["effect and place first"].n) == (1.0, 1)
    assert (every["place right given the effect"].value, every["false alarm"].value) == (1.0, 1.0)
    assert every["wrong class at 0.95"].value == 0.5
    assert every["gap closed against the oracle, median"].value > 0.8
    write_score(tmp_path / "score", scored)
    text = (tmp_path / "score" / "score.md").read_text()
    assert "linear_drag" in text and "bluerov2" in text and "axis" in text
    assert (tmp_path / "score" / "cases.csv").read_text().count("\n") == 3


def test_flights_without_the_cause_are_held_against_their_hashes(trials: Path) -> None:
    plain = next((trials / "truth" / "plain").rglob("*.csv"))
    kept = plain.read_bytes()
    try:
        plain.write_bytes(kept + b"\n")
        with pytest.raises(InputError, match="the plain run was changed"):
            score(trials / "cases", trials / "truth", trials / "answers.json", count=1)
    finally:
        plain.write_bytes(kept)


def test_whoever_cannot_answer_says_nothing(trials: Path, tmp_path: Path) -> None:
    def at_a_loss(*_: Any) -> dict[str, Any]:
        raise InputError("nothing drives the vehicle")

    answer(trials / "cases", tmp_path / "answers.json", count=1, answer_case=at_a_loss)
    first = json.loads((tmp_path / "answers.json").read_text())["answers"]["case_0001"]
    assert first["document"]["verdict"]["kind"] == "undecided" and "nothing drives" in first["refused"]


def test_cases_of_one_axis_and_of_vehicles_are_told_apart(trials: Path, tmp_path: Path) -> None:
    assert read_index(trials / "cases").vehicles
    for folder in ("cases", "truth"):
        (tmp_path / folder).mkdir()
    commitment = seal_truth(tmp_path / "truth" / "case_0001.json", {"schema": VEHICLES_SCHEMA})
    entry = Entry("case_0001", "bluerov2", {}, (), commitment)
    write_index(tmp_path / "cases", tmp_path / "truth", [entry], {"trials": 1, "seed": 1})
    assert not read_index(tmp_path / "cases").vehicles
    assert entry.data == digest({})


@pytest.mark.slow
def test_a_short_case_is_diagnosed_and_scored_from_the_command_line(trials: Path, tmp_path: Path, capsys: Any) -> None:
    out = str(tmp_path / "answers.json")
    assert main(["blind", "answer", str(trials / "cases"), "--out", out, "--processes", "1"]) == 0
    answers = json.loads(Path(out).read_text())["answers"]
    assert answers["case_0001"]["document"]["verdict"]["effects"] == ["linear_drag"]
    arguments = ["blind", "score", str(trials / "cases"), "--truth", str(trials / "truth"), "--answers", out]
    assert main([*arguments, "--processes", "1", "--out", str(tmp_path / "score")]) == 0
    assert "place right given the effect" in capsys.readouterr().out


# --- questions -------------------------------------------------------------------------------------------------------
def test_a_place_is_asked_about_only_where_the_effect_is_right() -> None:
    assert place(made_up("tether@sway", "effect", ("tether@sway",))) is True
    assert place(made_up("tether@sway", "effect", ("tether@surge",))) is False
    assert place(made_up("tether@sway", "effect", ("linear_drag@sway",))) is None
    assert place(made_up("tether@sway", "effect", ("tether@surge",), d=3.0)) is None


def test_a_wrong_place_is_a_wrong_class_and_a_rival_in_it_is_not() -> None:
    assert made_up("tether@sway", "effect", ("tether@surge",)).wrong
    assert not made_up("tether@sway", "effect", ("tether@surge", "tether@sway")).wrong
    assert made_up("tether@sway", "effects", ("gyro_bias@imu+tether@sway",)).wrong
    assert not made_up("tether@sway", "undecided", ("tether@surge",)).wrong
    assert made_up("tether@sway", "none", ("none",)).wrong
    assert not made_up("tether@sway", "none", ("none",), d=1.0).wrong


def test_an_unknown_cause_is_asked_for_its_axis() -> None:
    assert unknown_place(made_up("unknown", "unknown", ("unknown@yaw",))) is True
    assert unknown_place(made_up("unknown", "unknown", ("unknown@surge",))) is False
    assert unknown_place(made_up("unknown", "effect", ("tether@yaw",))) is None


def test_effects_are_invented_where_there_are_none() -> None:
    assert invented(made_up("parameters", "effect", ("tether@sway",))) is True
    assert invented(made_up("none", "parameters", ("parameters",))) is False
    assert measures([made_up("none", "parameters", ("parameters",))])["false alarm"].value == 1.0


def test_intervals_count_that_hold_what_was_flown() -> None:
    """Two standard deviations off is not held, what is hardly known better than before is not asked."""
    drag = float(BLUEROV.quadratic_drag[0])
    number = {"name": "quadratic_drag@surge", "nominal": drag, "value": drag + 1.0, "sd": 0.6}
    document = {"parameters": [number, number | {"sd": 0.4}, number | {"sd": 0.2 * drag}]}
    assert _covered({"own": OWN}, document) == (True, False)
    named = [{"name": "quadratic_drag", "place": "surge"}]
    assert _covered({"own": OWN}, document | {"effects": named}) == ()
    assert np.isfinite(drag)
