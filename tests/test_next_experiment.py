"""The next experiment: entropy, separations against a refit by brute force, an advice that the tank can carry out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recorded import NOMINAL, recordings, select

from vtank.diagnose.evidence import Setting, evaluate
from vtank.diagnose.experiments import Experiment, library, recorded, shortened, with_channels
from vtank.diagnose.next_experiment import _alone, _known, _parameter_gain, _separation, entropy_drop, next_experiment
from vtank.diagnose.selection import Selection
from vtank.diagnose.ties import noise_free
from vtank.diagnose.verdict import Verdict, decide, probabilities
from vtank.estimate.observed import RANGE, SPEED, Observed
from vtank.experiment.clearance import check_command
from vtank.experiment.scenario import load_scenario
from vtank.plant.parameters import vector


@pytest.fixture(scope="module")
def tied() -> tuple[Selection, Verdict, dict[str, float]]:
    """One run at one frequency, in which linear drag and friction look alike."""
    selection = select(recordings({"linear_drag.c": 0.1})[:1], ("linear_drag", "coulomb_friction"))
    chances = probabilities(selection)
    return selection, decide(selection, chances), chances


@pytest.fixture(scope="module")
def certain() -> tuple[Selection, Verdict, dict[str, float]]:
    """Four runs with plenty of linear drag."""
    selection = select(recordings({"linear_drag.c": 0.3}), ("linear_drag",))
    chances = {"linear_drag": 1.0, "parameters": 0.0, "none": 0.0, "unknown": 0.0}
    return selection, decide(selection, chances), chances


def test_entropy_drops_from_nothing_to_all() -> None:
    assert entropy_drop(0.3, 0.0) == pytest.approx(0.0, abs=1e-12)
    assert entropy_drop(0.5, 30.0) == pytest.approx(np.log(2.0), rel=1e-6)
    assert entropy_drop(0.5, 0.1) == pytest.approx(0.1**2 / 8.0, rel=0.01)  # its series about zero
    drops = [entropy_drop(0.2, d) for d in np.linspace(0.0, 10.0, 30)]
    assert np.all(np.diff(drops) > -1e-9)
    assert entropy_drop(0.2, 1.7) == pytest.approx(entropy_drop(0.8, 1.7), rel=1e-9)
    assert entropy_drop(0.0, 3.0) == 0.0


@pytest.mark.parametrize("words", ["multisine", "at 0.2 rad/s (small"])
def test_separation_is_that_of_a_refit_to_all_runs(
    tied: tuple[Selection, Verdict, dict[str, float]], words: str
) -> None:
    """Against the rival fitted to the winner's noise-free old and new runs together."""
    selection, verdict, _ = tied
    winner = verdict.fit
    rival = next(f for f in selection.named if f is not winner)
    new = next(e for e in library(winner.vector(), selection.setting.runs) if words in e.words)
    old = noise_free(selection.setting, winner)
    alone = evaluate(old, rival.hypothesis)
    together = evaluate(_both(old, new.run), rival.hypothesis, [{**alone.values}])
    found = _separation(old, winner, alone, new)
    assert found > 3.0
    assert found**2 == pytest.approx(2.0 * (together.optimum.cost - alone.optimum.cost), rel=0.2)


def _both(setting: Setting, run: Observed) -> Setting:
    size = run.time_s.size
    return replace(setting, runs=(*setting.runs, run), flags=(*setting.flags, np.zeros(size, bool)),
                   weight=(*setting.weight, np.ones(size)))  # fmt: skip


def test_information_about_parameters_adds_up(certain: tuple[Selection, Verdict, dict[str, float]]) -> None:
    """Half the log-determinant after a repeat, against that of a fit to both."""
    selection, verdict, _ = certain
    fit = verdict.fit
    new = next(e for e in library(fit.vector(), selection.setting.runs) if "multisine" in e.words)
    gain = _parameter_gain(selection.setting, fit, new)
    both = evaluate(_both(selection.setting, new.run), fit.hypothesis, [{k: v for k, v in fit.values.items()}])
    count = len(fit.problem.free)
    before, after = (np.linalg.slogdet(f.covariance()[:count, :count])[1] for f in (fit, both))
    assert gain == pytest.approx(0.5 * (before - after), rel=0.2)
    assert _known(fit).shape == (count, count) and _alone(selection.setting, fit, new)[1].size > count


def test_tied_effects_are_told_apart_five_times_faster_than_by_a_repeat(
    tied: tuple[Selection, Verdict, dict[str, float]], tmp_path: Path
) -> None:
    selection, verdict, chances = tied
    assert {"linear_drag", "coulomb_friction"} <= set(verdict.rivals)
    advice = next_experiment(selection, verdict, chances)
    assert advice["question"] == "which hypothesis"
    assert advice["against_repeat"] > 5.0 and advice["per_minute"] > 0.0
    (before, after), *_ = advice["separations"].values()
    assert before < 3.0 < after
    assert advice == json.loads(json.dumps(advice))
    scenario = load_scenario(_written(tmp_path, advice["scenario"]))
    check_command(scenario)
    assert scenario.duration_s == 60.0 * advice["minutes"]


def _written(folder: Path, table: dict) -> Path:
    path, excitation = folder / "next.toml", table["excitation"]
    lines = [f"{key} = {json.dumps(value)}" for key, value in table.items() if key != "excitation"]
    lines += ["[excitation]", *(f"{key} = {json.dumps(value)}" for key, value in excitation.items())]
    path.write_text("\n".join(lines))
    return path


def test_a_certain_effect_asks_how_large(certain: tuple[Selection, Verdict, dict[str, float]]) -> None:
    advice = next_experiment(*certain)
    assert advice["question"] == "how large" and advice["separations"] == {}
    assert advice["against_repeat"] >= 1.0
    assert len(advice["alternatives"]) == 3
    assert advice["alternatives"][0]["per_minute"] <= advice["per_minute"] + 1e-3


def test_experiments_start_at_rest_and_stay_in_the_tank(tied: tuple[Selection, Verdict, dict[str, float]]) -> None:
    runs = tied[0].setting.runs
    found = library(vector({"linear_drag.c": 0.1}, NOMINAL), runs)
    assert len(found) > 15 and len({e.words for e in found}) == len(found)
    top = np.max(np.abs(runs[0].input))
    for experiment in found:
        run = experiment.run
        assert np.all(run.value[run.kind == RANGE] > 0.3)
        assert np.max(np.abs(run.input)) < 1.5 * top
        assert set(experiment.scenario) <= {"duration_s", "standoff_m", "excitation"}


def test_a_speed_sensor_can_be_added(tied: tuple[Selection, Verdict, dict[str, float]]) -> None:
    run = tied[0].setting.runs[0]
    found = [e for e in library(NOMINAL, [run]) if SPEED in e.run.first]
    assert [e.words for e in found] == ["run run_0 again with a speed sensor of 0.01 m/s on board"]
    speed = found[0].run.value[found[0].run.kind == SPEED]
    place = found[0].run.value[found[0].run.kind == RANGE]
    np.testing.assert_allclose(speed[1:-1], -(place[2:] - place[:-2]) / 0.2, atol=2e-3)


def test_other_inputs_are_driven_in_open_loop_in_their_own_unit() -> None:
    time = np.arange(0.0, 30.0, 0.1)
    like = Observed(
        "boat", "command", time, np.sign(np.sin(time)), time, np.zeros(time.size), np.full(time.size, SPEED)
    )
    p = vector({"beta": 0.5}, NOMINAL)
    found = library(p, [like])
    assert found and all(e.scenario == {} and e.run.input_name == "command" for e in found)
    assert max(np.max(np.abs(e.run.input)) for e in found) <= 1.0
    still = recorded(with_channels(replace(like, input=0.0 * time), [SPEED]), p)
    np.testing.assert_array_equal(still.value, 0.0)


def test_runs_of_seconds_are_not_shortened(tied: tuple[Selection, Verdict, dict[str, float]]) -> None:
    """Where no shorter experiment is left to be tried, the advice still stands."""
    selection, _, _ = tied
    run = selection.setting.runs[0]
    seen, fed = run.time_s <= 20.0, run.input_time_s <= 20.0
    short = replace(run, time_s=run.time_s[seen], value=run.value[seen], kind=run.kind[seen],
                    input_time_s=run.input_time_s[fed], input=run.input[fed])  # fmt: skip
    found = select([short], ("linear_drag",))
    chances = probabilities(found)
    assert next_experiment(found, decide(found, chances), chances)["against_repeat"] > 0.0


def test_the_beginning_of_a_run_is_called_so(tied: tuple[Selection, Verdict, dict[str, float]]) -> None:
    again = Experiment("run a once more", {}, 2.0, tied[0].setting.runs[0])
    assert again.told == "run a once more"
    assert shortened(again, 0.5).told == "run a once more, only the beginning"
    planned = Experiment("a sine", {"duration_s": 120.0}, 2.0, again.run)
    assert shortened(planned, 0.5).told == "a sine" and shortened(planned, 0.5).scenario == {"duration_s": 30.0}
