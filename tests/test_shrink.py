"""How far the gap shrinks: predictions from a start window, leaving out, floors, and intervals for new data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import NOISE, NOMINAL, differing, record, recordings, select, sine

from vtank.diagnose.evidence import evaluate
from vtank.diagnose.holdout import Model, Prediction, Target, fraction_closed, model_of, rms
from vtank.diagnose.new_data import NewData, remembered
from vtank.diagnose.selection import Selection
from vtank.diagnose.shrink import again, leave_out, parts_of, shrink, without
from vtank.diagnose.verdict import Verdict, decide, probabilities
from vtank.estimate.problem import Noise
from vtank.plant.parameters import slot, vector

DRAG = {"linear_drag.c": 0.15}
WAVE = {"seiche.amplitude": 0.03, "seiche.frequency": 0.8}


@pytest.fixture(scope="module")
def dragged() -> tuple[Selection, Verdict]:
    """Four runs with linear drag, and their verdict."""
    selection = select(recordings(DRAG), ("linear_drag", "thrust_deadband"))
    return selection, decide(selection, probabilities(selection))


def target(p: np.ndarray, noise: Noise = NOISE, noise_m: float = 0.0, seed: int = 0) -> Target:
    run = record("run", sine(0.5, 12.0), p, noise_m, seed)
    return Target(run, np.ones(run.time_s.size), noise)


def test_the_model_that_made_a_run_predicts_it() -> None:
    error = Prediction(Model(vector(DRAG, NOMINAL)), target(vector(DRAG, NOMINAL))).errors()
    assert np.max(np.abs(error)) < 1e-4
    assert rms([Prediction(Model(NOMINAL), target(vector(DRAG, NOMINAL))).errors()]) > 0.01


def test_nothing_after_the_window_reaches_the_prediction() -> None:
    aim = target(NOMINAL, noise_m=0.006)
    prediction = Prediction(Model(vector(DRAG, NOMINAL)), aim)
    moved = aim.run.value + np.where(np.arange(aim.run.value.size) >= aim.inside, 0.3, 0.0)
    np.testing.assert_allclose(prediction.errors(moved) - prediction.errors(), 0.3, atol=1e-12)
    assert aim.run.time_s[aim.inside - 1] == pytest.approx(10.0)


def test_short_runs_are_watched_for_a_third_of_their_time() -> None:
    run = record("run", sine(0.5, 12.0, 12.0), NOMINAL, 0.0, 0)
    aim = Target(run, np.ones(run.time_s.size), NOISE)
    assert run.time_s[aim.inside] == pytest.approx(run.time_s[-1] / 3.0, abs=0.1)


def test_outliers_do_not_count() -> None:
    aim = target(NOMINAL)
    flagged = replace(aim, weight=np.where(np.arange(aim.weight.size) == 500, 1e8, 1.0))
    assert np.sum(aim.scored) - np.sum(flagged.scored) == 1


def test_floor_is_the_mean_square_error_of_the_true_model() -> None:
    """Forty new runs with turbulence, predicted by the model that made them."""
    noise = Noise((0.006**2,) * 3, 2e-3, 1.0)
    aim = target(NOMINAL, noise)
    prediction, rng = Prediction(Model(NOMINAL), aim), np.random.default_rng(5)
    squares = []
    for _ in range(40):
        push = noise.sigma * remembered(aim.run.input_time_s, noise.correlation_time, rng)
        size = aim.run.time_s.size
        value = -aim.errors(NOMINAL, np.zeros((size, 6)), np.zeros(size), push) + 0.006 * rng.normal(size=size)
        squares.append(np.mean(prediction.errors(value) ** 2))
    by_noise, by_turbulence = prediction.floor_squares()
    expected = np.mean(by_noise + by_turbulence)
    assert np.mean(by_turbulence) > 3.0 * np.mean(by_noise)
    assert np.mean(squares) == pytest.approx(expected, abs=3.0 * np.std(squares) / np.sqrt(len(squares)))


def test_disturbances_are_remembered_as_long_as_they_should() -> None:
    time = 0.1 * np.arange(200_000)
    d = remembered(time, 2.0, np.random.default_rng(1))
    assert np.var(d) == pytest.approx(1.0, abs=0.05)
    assert np.mean(d[20:] * d[:-20]) == pytest.approx(np.exp(-1.0), abs=0.05)


def test_fraction_closed_is_that_of_the_reducible_gap() -> None:
    assert fraction_closed(0.03, 0.008, 0.007) == pytest.approx(22.0 / 23.0)
    assert fraction_closed(0.03, 0.03, 0.007) == 0.0
    assert fraction_closed(0.0075, 0.0072, 0.007) is None


def test_a_wave_is_predicted_as_large_as_its_phase_is_known() -> None:
    model = Model(vector(WAVE, NOMINAL), ("seiche.phase",))
    nowhere, somewhere = np.full(len(model.grid), 1.0 / len(model.grid)), np.eye(len(model.grid))[3]
    assert model.mean(nowhere)[slot("seiche.amplitude")] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(model.mean(somewhere), model.grid[3], atol=1e-12)


def test_the_window_tells_the_phase_of_a_strong_wave() -> None:
    aim = target(vector({**WAVE, "seiche.phase": 1.0}, NOMINAL), noise_m=0.003)
    known = Prediction(Model(vector(WAVE, NOMINAL), ("seiche.phase",)), aim)
    assert rms([known.errors()]) < 0.25 * rms([Prediction(Model(NOMINAL), aim).errors()])


def test_a_run_left_out_has_no_say(dragged: tuple[Selection, Verdict]) -> None:
    """The fit of a fold is the fit of the other runs from the catalogue's own first guess."""
    selection, verdict = dragged
    rest = without(selection.setting, 2)
    assert [run.name for run in rest.runs] == ["run_0", "run_1", "run_3"]
    fold, fresh = again(rest, verdict.fit, parts_of(selection.setting), 2), evaluate(rest, verdict.fit.hypothesis)
    scale = np.sqrt(np.diag(fresh.covariance()))
    np.testing.assert_allclose(fold.optimum.theta / scale, fresh.optimum.theta / scale, atol=0.2)
    assert model_of(fold).p[slot("linear_drag.c")] != model_of(verdict.fit).p[slot("linear_drag.c")]


def test_the_gap_by_linear_drag_closes(dragged: tuple[Selection, Verdict]) -> None:
    selection, verdict = dragged
    found = shrink(selection, verdict, 1)
    assert found["unit"] == "m" and found["chosen"] == ["linear_drag"] * 4
    assert found["floor"] == pytest.approx(0.006, rel=0.1)
    assert found["floor"] < 1.05 * found["diagnosed"] < 0.5 * found["refit"]
    assert found["fraction_closed"] > 0.9
    low, high = found["interval90"]
    assert 0.5 < low < high < 1.3
    assert shrink(selection, verdict, 1) == found


def test_each_fold_chooses_for_itself(dragged: tuple[Selection, Verdict]) -> None:
    selection, _ = dragged
    parts = parts_of(selection.setting)
    blind = replace(selection, named=tuple(f for f in selection.named if f.hypothesis.name != "linear_drag"))
    assert leave_out(selection, parts, 0).chosen == "linear_drag"
    assert leave_out(blind, parts, 0).chosen != "linear_drag"


def test_nothing_is_closed_where_the_simulator_is_right() -> None:
    selection = select(recordings(), ("linear_drag", "thrust_deadband"))
    found = shrink(selection, decide(selection, probabilities(selection)))
    assert found["fraction_closed"] is None and found["interval90"] is None
    assert found["refit"] == pytest.approx(found["floor"], rel=0.1)


@pytest.mark.slow
def test_a_vehicle_that_differs_by_run_leaves_noise_where_that_is_known() -> None:
    """Its own parameters are no effect's, which would be weighed in the window of every new run."""
    beta = NOMINAL[slot("beta")]
    runs = differing([{"beta": beta * share} for share in (1.1, 0.9, 1.05, 0.95)])
    selection = select(runs, ("linear_drag",))
    verdict = decide(selection, probabilities(selection))
    assert verdict.kind == "varying"
    found = shrink(selection, verdict)
    assert found["floor"] == pytest.approx(0.006, rel=0.15) and found["refit"] > 2.0 * found["floor"]


def test_new_runs_scatter_about_what_the_cause_leaves(dragged: tuple[Selection, Verdict]) -> None:
    new = NewData(*dragged)
    refit, diagnosed, own = np.mean(new.new_sets([(0, i) for i in range(12)]), axis=0)
    assert own == pytest.approx(0.006, rel=0.1)
    assert own <= diagnosed < 0.7 * refit


def test_a_single_run_is_cut_into_blocks() -> None:
    selection = select(recordings(DRAG)[:1], ("linear_drag",))
    parts = parts_of(selection.setting).setting
    whole = selection.setting.runs[0]
    np.testing.assert_array_equal(np.concatenate([part.time_s for part in parts.runs]), whole.time_s)
    assert all(part.input_time_s[0] <= part.time_s[0] for part in parts.runs)
    found = shrink(selection, decide(selection, probabilities(selection)))
    assert len(found["left_out"]) == 4 and found["left_out"][0] == "run_0, 0 to 29.98 s"
    assert 0.004 < found["diagnosed"] < 0.008 and found["nominal"] > 0.01
