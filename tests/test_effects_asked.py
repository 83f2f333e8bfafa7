"""What an effect says of itself is what diagnosis and blind trials go by: no name is needed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vtank.diagnose.holdout import GRID, Model
from vtank.diagnose.hypothesis import candidates, largest_input, starting_values
from vtank.effects.catalogue import BY_NAME, CATALOGUE, PARAMETERS
from vtank.effects.effect import Effect, Parameter
from vtank.estimate.observed import POSITION, RANGE, SPEED, Observed
from vtank.plant.parameters import null_vector, slot, vector
from vtank.studies.blind.cause import draw_cause

TIME = np.arange(50) * 0.1


def run(kind: int, input_name: str = "n_rev_s") -> Observed:
    return Observed("run", input_name, TIME, 10.0 * np.sin(TIME), TIME, 3.0 + 0.1 * TIME, np.full(TIME.size, kind))


def names(*runs: Observed) -> set[str]:
    return {effect.name for effect in candidates(null_vector(), runs)}


@pytest.mark.parametrize(
    ("there", "lacking"),
    [
        (run(RANGE), ()),
        (run(POSITION), ("sonar",)),
        (run(SPEED), ("sonar", "position")),
        (run(RANGE, "thrust_N"), ("propeller",)),
    ],
)
def test_effects_are_considered_where_what_they_need_was_recorded(there: Observed, lacking: tuple[str, ...]) -> None:
    able = {e.name for e in CATALOGUE if e.standing != "absorbed" and not set(e.needs) & set(lacking)}
    assert names(there) == {name for name in able if BY_NAME[name].same_as not in able}


def test_the_second_of_two_that_are_the_same_is_considered_where_the_first_cannot_be_seen() -> None:
    for effect in (effect for effect in CATALOGUE if effect.same_as):
        assert effect.name not in names(run(RANGE)) and effect.same_as in names(run(RANGE))
        assert effect.name in names(run(SPEED)) and effect.same_as not in names(run(SPEED))


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.name)
def test_a_fit_begins_inside_the_bounds_and_away_from_the_null(effect: Effect) -> None:
    runs = [run(RANGE)]
    starts = starting_values(effect, runs)
    assert starts and all(start.keys() == set(effect.slots()) for start in starts)
    for start in starts:
        for name, value in start.items():
            q = PARAMETERS[name]
            assert q.bounds[0] <= value <= q.bounds[1] and (q.shape or value != q.null)
            assert not q.limit or value < largest_input(runs)


def test_all_parameters_that_a_run_has_for_itself_are_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    own = ("seiche.phase", "sonar_offset.o")
    monkeypatch.setitem(PARAMETERS, own[1], replace(PARAMETERS[own[1]], per_run=True))
    model, size = Model(vector({"seiche.amplitude": 0.2}), own), GRID ** len(own)
    assert model.grid.shape == (size, null_vector().size)
    assert all(np.unique(model.grid[:, slot(name)]).size == GRID for name in own)
    vague, sure = model.mean(np.full(size, 1.0 / size)), np.zeros(size)
    assert vague[[slot("seiche.amplitude"), slot("sonar_offset.o")]] == pytest.approx(0.0, abs=1e-12)
    sure[5] = 1.0
    assert np.allclose(model.mean(sure), model.grid[5])


def test_a_cause_is_drawn_whatever_the_unit_of_its_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    near = Parameter("near", "m", "distance", 1.0, (0.1, 9.0), 2.0, shape=True)
    effect = replace(BY_NAME["tether"], name="new", parameters=(*BY_NAME["tether"].parameters, near))
    monkeypatch.setitem(BY_NAME, "new", effect)
    for name, q in zip(effect.slots(), effect.parameters, strict=True):
        monkeypatch.setitem(PARAMETERS, name, q)
    cause = draw_cause("new", np.random.default_rng(1))
    assert cause.fixed == pytest.approx({"new.near": 2.0}) and cause.unit.keys() == {"new.k"}
