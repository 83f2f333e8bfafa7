"""The scientist's loop: the run that parts what is possible is flown, and it ends where nothing is left to be told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment.whole_scenario import load_whole_scenario
from vtank.plant import load_vehicle
from vtank.record import Run
from vtank.studies.blind.seal import seal_truth
from vtank.studies.blind.whole import caused
from vtank.studies.blind.whole.strange import draw_strange
from vtank.studies.explore import Candidate, Plan, Planner, SealedTank, candidates, document, explore, loop, told
from vtank.studies.explore.planner import ranked

CRAFT = ("bluerov2", "kingfisher", "phoenix", "remus100")
BLUEROV = load_vehicle("bluerov2")
VEHICLE = replace(BLUEROV, sensors=tuple(s for s in BLUEROV.sensors if s.name in ("imu", "dvl")))
SOME = ("linear_drag", "thruster_dead")


@pytest.fixture(scope="module")
def planner() -> Planner:
    """Three runs of a vehicle with two instruments."""
    some = [c for c in candidates(BLUEROV, 50.0) if c.words in ("surge, quick multisine", "yaw, quick multisine")]
    return Planner(VEHICLE, [some[1], some[0]])


def says(name: str, p: float, *others: tuple[str, float]) -> Any:
    """A diagnosis that names a cause."""
    kind = name if name in ("none", "unknown") else "effect"
    chances = {("unknown@yaw" if kind == "unknown" else name): p} | dict(others)
    return SimpleNamespace(
        probabilities=chances, verdict=SimpleNamespace(kind=kind, probability=p, doubt=""),
        budget=SimpleNamespace(left=0.1), selection=SimpleNamespace(sets={}, best=None),
    )  # fmt: skip


@pytest.fixture
def flying(planner: Planner, monkeypatch: pytest.MonkeyPatch) -> Any:
    """(answers after each run, minutes, fixed) -> what came of it, the recordings being those of the nominal."""

    def flown(answers: list[Any], minutes: float = 10.0, fixed: bool = False) -> Any:
        monkeypatch.setattr(loop, "diagnose", lambda runs, *_: answers[min(len(runs), len(answers)) - 1])
        known = {c.text: run for c, run in zip(planner.flown, planner.flights, strict=True)}

        def fly(text: str, seed: int) -> Run:
            return known[text]

        return explore(planner, fly, minutes, fixed=fixed, effects=SOME)

    return flown


@pytest.mark.parametrize("name", CRAFT)
def test_every_candidate_is_a_scenario_that_runs_as_it_is(name: str, tmp_path: Path) -> None:
    vehicle = load_vehicle(name)
    some = candidates(vehicle)
    assert len({c.words for c in some}) == len(some) >= 5
    for candidate in some:
        (tmp_path / "next.toml").write_text(candidate.text)
        scenario = load_whole_scenario(tmp_path / "next.toml")
        assert scenario.vehicle.name == name and scenario.duration_s == 60.0 * candidate.minutes


def test_a_run_that_strikes_a_wall_or_cannot_be_flown_is_no_candidate() -> None:
    text = 'vehicle = "bluerov2"\nduration_s = 20\n[[excite]]\nkind = "step_coast"\naxis = "surge"\npush_s = 20.0\n'
    far = Candidate("far ahead", text + "amplitude_share = 0.8\ncoast_s = 0.0\n")
    near = Candidate("near", text + "amplitude_share = 0.02\ncoast_s = 0.0\n")
    strong = Candidate("strong", text.replace("[[excite]]", "[[excite]]\namplitude_N = 1e5") + "coast_s = 0.0\n")
    walls = [replace(c, text='walls = "basin"\ndepth_m = 0.6\n' + c.text) for c in (far, near, strong)]
    planner = Planner(VEHICLE, walls)
    assert [c.words for c in planner.flown] == ["near"]
    assert planner.refused.keys() == {"far ahead", "strong"}
    with pytest.raises(InputError, match="none of 1 runs can be flown"):
        Planner(VEHICLE, walls[:1])


def test_it_ends_when_an_effect_is_sure(flying: Any) -> None:
    found = flying([says("linear_drag@yaw", 0.6, ("none", 0.4)), says("linear_drag@yaw", 0.99)])
    assert (found.answer, found.ended, len(found.steps)) == ("linear_drag@yaw", "decided", 2)
    assert found.steps[-1].minutes == pytest.approx(2 * 40.0 / 60.0)
    said = document(found)
    assert said["answer"] == "linear_drag@yaw" and said["next"] is None
    assert "decided" in str(told(found))


def test_it_ends_when_the_minutes_are_spent(flying: Any) -> None:
    found = flying([says("unknown", 0.5, ("linear_drag@yaw", 0.3), ("none", 0.2))], minutes=1.5)
    assert (found.ended, len(found.steps)) == ("minutes", 2)
    with pytest.raises(InputError, match="room for one run"):
        flying([says("none", 0.99)], minutes=0.5)


def test_nothing_is_decided_before_small_effects_would_have_been_seen(flying: Any, planner: Planner) -> None:
    """A run of surge alone, in which nothing was seen, says nothing about the drag of yaw."""
    alone = Planner.__new__(Planner)
    alone.vehicle, alone.refused = planner.vehicle, {}
    surge = next(i for i, c in enumerate(planner.flown) if c.words.startswith("surge"))
    alone.flown, alone.flights = planner.flown, planner.flights
    doubt = loop.Doubt(alone, SOME)
    chance, decided = doubt.decided(says("none", 0.999), [planner.flights[surge]])
    both, now = doubt.decided(says("none", 0.999), [planner.flights[surge], planner.flights[1 - surge]])
    assert chance < both
    best = doubt.plans(None)[0]
    assert not decided or best.drop < 0.05
    assert now or both > 0.5


def test_a_fixed_plan_keeps_its_order(flying: Any, planner: Planner) -> None:
    found = flying([says("unknown", 0.5, ("linear_drag@yaw", 0.5))], fixed=True)
    assert [s.plan.candidate.words for s in found.steps] == [c.words for c in planner.flown]


def test_the_run_that_parts_the_probable_ones_comes_first() -> None:
    """Of two runs, each telling one pair apart, the one whose pair is in doubt."""
    first, second = Candidate("first", ""), Candidate("second", "")
    far, near = 30.0, 0.1
    one = np.array([[0.0, far, near], [far, 0.0, near], [near, near, 0.0]])
    other = np.array([[0.0, near, far], [near, 0.0, near], [far, near, 0.0]])
    plans = [Plan(first, 0.0, one), Plan(second, 0.0, other)]

    def best(*chances: float) -> str:
        return ranked(plans, [SimpleNamespace(chance=p) for p in chances])[0].candidate.words  # type: ignore[misc]

    assert best(0.5, 0.49, 0.01) == "first"
    assert best(0.5, 0.01, 0.49) == "second"


def test_a_force_of_no_catalogue_is_flown_as_it_was_drawn() -> None:
    drawn = draw_strange(np.random.default_rng(4), BLUEROV, "yaw", 1.0, 60.0)
    own = {"linear": [1.0] * 6, "quadratic": [2.0] * 6, "added_mass": np.eye(6).ravel().tolist()}
    truth = {"kind": "unknown", "vehicle": "bluerov2", "effects": {drawn.name: dict(drawn.values)}, "own": own}
    vehicle, (again,) = caused(truth)
    assert (again.name, again.values) == (drawn.name, drawn.values)
    assert again.effect.wrench is not None and vehicle.linear_drag.tolist() == [1.0] * 6


def test_only_the_flying_process_opens_a_sealed_tank(tmp_path: Path) -> None:
    own = {"linear": BLUEROV.linear_drag.tolist(), "quadratic": BLUEROV.quadratic_drag.tolist(),
           "added_mass": BLUEROV.added_mass.ravel().tolist()}  # fmt: skip
    effects = {"linear_drag@yaw": {"c_N_m_s_per_rad": 3.0}}
    truth = {"kind": "single", "vehicle": "bluerov2", "label": "linear_drag@yaw", "effects": effects, "own": own}
    seal_truth(tmp_path / "case_0001.json", truth)
    text = candidates(BLUEROV, 50.0)[-1].text.replace("duration_s = 40", "duration_s = 6")
    with SealedTank(tmp_path / "case_0001.json") as tank:
        run = tank.fly(text, 5)
        assert tank.vehicle.name == "bluerov2" and run.duration_s > 5.0
        assert not any("c_N_m_s_per_rad" in str(value) for value in vars(tank).values())
        assert tank.reveal() == "linear_drag@yaw"
    (tmp_path / "other.json").write_text("{}")
    with pytest.raises(InputError, match="not the truth of a sealed vehicle"):
        SealedTank(tmp_path / "other.json")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "expected recordings"),
        (["runs", "--tank", "x"], "not both"),
        (["runs"], "--nominal vehicle.toml"),
        (["runs", "--nominal", "bluerov2", "--fixed"], "go with --tank"),
        (["--tank", "x", "--minutes", "0"], "above 0"),
    ],
)
def test_what_does_not_go_together_is_refused(arguments: list[str], message: str, capsys: Any) -> None:
    assert main(["explore", *arguments]) == 2
    assert message in capsys.readouterr().err
