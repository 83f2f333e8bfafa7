"""The gap budget: its lines add up, and each holds what was put into the recordings for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import DRIVES, NOISE_M, NOMINAL, record, recordings, select, sine

from vtank.diagnose.budget import Budget, budget
from vtank.diagnose.prior import calibration
from vtank.diagnose.shrink import parts_of
from vtank.diagnose.verdict import decide, probabilities
from vtank.estimate.observed import Observed
from vtank.plant.parameters import slot

ALPHA = NOMINAL[slot("alpha")]


def shared(runs: list[Observed], *names: str) -> Budget:
    """The budget of runs, the named effects considered."""
    selection = select(runs, names)
    return budget(selection, decide(selection, probabilities(selection)))


def adds_up(found: Budget) -> bool:
    return sum(line.share for line in found.lines) == pytest.approx(1.0, abs=1e-9)


def beyond(found: Budget) -> float:
    """What is left beside own parameters and noise of the sensor."""
    return 1.0 - found.share("parameters") - found.share("noise")


@pytest.fixture(scope="module")
def dragged() -> Budget:
    return shared(recordings({"linear_drag.c": 0.15}), "linear_drag", "thrust_deadband")


def test_lines_come_in_their_order_and_add_to_one(dragged: Budget) -> None:
    assert [(line.name, line.kind) for line in dragged.lines] == [
        ("own parameters", "parameters"),
        ("linear_drag", "effect"),
        ("repeatable, unnamed", "repeatable"),
        ("disturbance", "disturbance"),
        ("sensor noise", "noise"),
    ]
    assert adds_up(dragged) and dragged.unit == "m"
    for line in dragged.lines:
        assert line.interval90[0] < line.share < line.interval90[1]  # noise, too, may be other than it seems
    parameters, effect, *rest = dragged.lines
    left, named, margin = sum(line.share for line in rest), effect.share, calibration().budget
    for line, whole in ((parameters, left + named), (effect, left + named), *((line, left) for line in rest)):
        assert min(abs(end - line.share) for end in line.interval90) > 0.999 * margin[line.kind] * whole


def test_a_named_effect_has_most_of_what_the_refit_leaves(dragged: Budget) -> None:
    left = beyond(dragged)
    assert dragged.share("effect") > 0.8 * left > 0.0
    assert dragged.share("repeatable") < 0.1 * left and dragged.share("disturbance") < 0.1 * left
    assert dragged.worse == ()


def test_an_effect_that_the_verdict_does_not_name_has_no_line() -> None:
    """It mimics what has no name, and counts as that."""
    selection = select(recordings({"linear_drag.c": 0.15}), ("linear_drag",))
    known = decide(selection, probabilities(selection))
    named, unnamed = (budget(selection, v) for v in (known, replace(known, kind="unknown", effects=())))
    assert [line.kind for line in unnamed.lines] == ["parameters", "repeatable", "disturbance", "noise"]
    assert unnamed.share("repeatable") == pytest.approx(named.share("effect") + named.share("repeatable"))
    assert unnamed.unexplained.share == pytest.approx(named.unexplained.share + named.share("effect"))
    for found in (named, unnamed):
        assert found.unexplained.share == pytest.approx(found.share("repeatable") + found.share("disturbance"))
        low, high = found.unexplained.interval90
        assert low <= found.unexplained.share <= high


def test_the_nominal_s_error_and_its_noise_are_in_metres(dragged: Budget) -> None:
    runs = recordings({"linear_drag.c": 0.15})
    assert 2.0 * NOISE_M < dragged.nominal < np.std(np.concatenate([run.value for run in runs]))
    assert dragged.nominal * np.sqrt(dragged.share("noise")) == pytest.approx(NOISE_M, rel=0.05)


def test_where_nothing_is_missing_all_is_noise_and_disturbance() -> None:
    found = shared(recordings(), "linear_drag")
    assert adds_up(found)
    assert found.share("noise") + found.share("disturbance") == pytest.approx(1.0, abs=0.02)
    assert found.share("noise") > 0.9


def test_parameters_that_are_off_have_the_line_of_their_own() -> None:
    found = shared(recordings({"alpha": 1.4 * ALPHA}), "linear_drag")
    assert adds_up(found) and found.share("parameters") > 0.8


def test_what_has_no_name_but_comes_again_is_repeatable() -> None:
    """A force over speed that no effect considered has; measured on runs that were left out."""
    found = shared(recordings(force=lambda t, u, n: 0.03 * np.exp(-((u / 0.03) ** 2))))
    left = beyond(found)
    assert adds_up(found) and left > 0.5
    assert found.share("repeatable") > 0.7 * left


def test_what_was_there_once_is_not_repeatable() -> None:
    """A push in a window of one run says nothing about a run that was left out."""
    runs = recordings()
    runs[1] = record("run_1", sine(*DRIVES[1]), NOMINAL, NOISE_M, 1, lambda t, u, n: 0.01 * (40.0 < t < 60.0))
    found = shared(runs)
    assert adds_up(found)
    assert found.share("repeatable") < 0.05
    assert found.share("disturbance") > 0.5


def test_two_runs_suffice() -> None:
    """Blocks of time, with starts of their own, are left out."""
    runs = recordings({"linear_drag.c": 0.15})[:2]
    found = shared(runs, "linear_drag")
    assert adds_up(found)
    assert found.share("effect") > 0.8 * beyond(found) > 0.0


@pytest.mark.parametrize(("count", "expected"), [(1, 4), (2, 4), (3, 6), (4, 4)])
def test_parts_are_runs_or_blocks_of_few_runs(count: int, expected: int) -> None:
    runs = recordings()[:count]
    parts = parts_of(select(runs, ()).setting)
    assert len(parts.setting.runs) == len(parts.rows) == len(parts.parent) == expected
    assert parts.whole is (count == 4)
    np.testing.assert_array_equal(np.sum(parts.rows, axis=0), 1)  # every measurement is in one part
    ends = np.cumsum([0] + [run.time_s.size for run in runs])
    every = np.concatenate([run.value for run in runs])
    for part, k, rows in zip(parts.setting.runs, parts.parent, parts.rows, strict=True):
        assert np.all(np.flatnonzero(rows) >= ends[k]) and np.all(np.flatnonzero(rows) < ends[k + 1])
        np.testing.assert_array_equal(part.value, every[rows])
        assert part.input_time_s[0] <= part.time_s[0]


@pytest.mark.slow
def test_parameters_that_differ_from_run_to_run_have_a_line_of_their_own() -> None:
    """Blocks of every run are left out, and the rest of the run tells what it has for itself."""
    gains = (0.85, 0.95, 1.05, 1.15)
    beta = NOMINAL[slot("beta")]
    runs = [recordings({"beta": gain * beta})[k] for k, gain in enumerate(gains)]
    found = shared(runs, "linear_drag")
    names = [line.name for line in found.lines]
    assert names[:2] == ["own parameters", "own parameters of each run"]
    assert adds_up(found)
    assert found.lines[1].share > 0.8 * (1.0 - found.lines[0].share - found.share("noise"))


@pytest.mark.slow
def test_a_lag_of_each_run_is_its_own_and_not_found_anew() -> None:
    """The lag is an effect's parameter, too, but no phase that a run's start would tell."""
    tau = NOMINAL[slot("thrust_lag.tau")]
    runs = [recordings({"thrust_lag.tau": factor * tau})[k] for k, factor in enumerate((1.0, 2.5, 1.0, 1.0))]
    found = shared(runs, "linear_drag")
    assert found.lines[1].name == "own parameters of each run"
    assert found.verdict.interval90[0] > 0.0 and found.worse == ()
