"""Three effects that act together are named, all of them and nothing else, by the whole comparison."""

from __future__ import annotations

import pytest
from recorded import NOMINAL, recordings

from vtank.diagnose.selection import LARGEST, Selection, prepare, select
from vtank.diagnose.verdict import Verdict, decide, probabilities

TRUE = {"linear_drag.c": 0.15, "thrust_deadband.n0": 2.0, "drag_asymmetry.e": 0.2}
NAMES = ("linear_drag", "coulomb_friction", "thrust_deadband", "thrust_loss", "drag_asymmetry", "tether")


@pytest.fixture(scope="module")
def three() -> tuple[Selection, Verdict]:
    selection = select(prepare(recordings(TRUE, seed=60), NOMINAL), NAMES)
    return selection, decide(selection, probabilities(selection))


@pytest.mark.slow
def test_three_effects_together_are_named(three: tuple[Selection, Verdict]) -> None:
    selection, verdict = three
    assert verdict.kind == "effects"
    assert set(verdict.effects) == {name.split(".")[0] for name in TRUE}
    assert verdict.probability > 0.8
    assert max(len(f.hypothesis.effects) for f in selection.named) == LARGEST == 3


@pytest.mark.slow
def test_each_of_them_is_measured(three: tuple[Selection, Verdict]) -> None:
    _, verdict = three
    for name, value in TRUE.items():
        assert verdict.fit.values[name] == pytest.approx(value, rel=0.15)


@pytest.mark.slow
def test_nothing_is_left_over_beside_them(three: tuple[Selection, Verdict]) -> None:
    selection, verdict = three
    (free,) = (free for free in selection.free if free.fit is verdict.fit)
    assert not free.components and free.left < 0.0
    assert selection.setting.noise.sigma < 1e-3
