"""Evidence and budget must agree, or nothing is decided."""

from __future__ import annotations

from dataclasses import replace

import pytest
from recorded import recordings, select

from vtank.diagnose.budget import Budget, Line
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.judged import judged
from vtank.diagnose.selection import Selection
from vtank.diagnose.verdict import Verdict, decide, probabilities
from vtank.estimate.problem import Noise

STILL, STORM = Noise(sigma=1e-3, correlation_time=2.0), Noise(sigma=2e-2, correlation_time=2.0)


@pytest.fixture(scope="module")
def known() -> tuple[Selection, Verdict]:
    selection = select(recordings({"linear_drag.c": 0.15}), ("linear_drag",))
    return selection, decide(selection, probabilities(selection))


def shares(
    verdict: tuple[float, float], repeatable: tuple[float, float], gains: tuple[float, ...] = (-1.0, -1.1, -0.9)
) -> Budget:
    """A budget of which only the intervals of two lines matter, and what is gained in each part."""
    lines = (Line("repeatable, unnamed", "repeatable", sum(repeatable) / 2, repeatable),)
    left = Line("not explained", "unexplained", 0.0, (0.0, 0.0))
    return Budget(lines, left, Line("the verdict", "verdict", sum(verdict) / 2, verdict), "m", 0.1, (), gains)


@pytest.mark.parametrize(
    ("kind", "noise", "verdict", "repeatable", "doubt"),
    [
        ("effect", STILL, (0.2, 0.4), (0.3, 0.5), ""),  # part of the gap has no name, which is said beside the cause
        ("effect", STILL, (-0.4, 0.1), (0.0, 0.0), ""),
        ("effect", STILL, (-0.4, -0.1), (0.0, 0.0), "worse"),
        ("varying", STILL, (-0.4, -0.1), (0.0, 0.0), "worse"),
        ("parameters", STILL, (-0.4, -0.1), (0.0, 0.0), "worse"),
        ("parameters", STILL, (0.2, 0.4), (0.2, 0.5), "repeats"),
        ("parameters", STILL, (0.2, 0.4), (0.0, 0.5), ""),
        ("none", STILL, (-0.4, -0.1), (0.0, 0.0), ""),  # nothing was fitted
        ("none", STORM, (0.0, 0.0), (0.0, 0.0), "disturbance"),
        ("effect", STORM, (0.2, 0.4), (0.0, 0.0), ""),
        ("unknown", STORM, (-0.4, -0.1), (0.2, 0.5), ""),
        (
            "unknown",
            STILL,
            (0.0, 0.0),
            (-0.4, 0.4),
            "unseen",
        ),  # all that data left out hold is own parameters and noise
    ],
)
def test_what_the_budget_does_not_bear_out_is_undecided(
    known: tuple[Selection, Verdict],
    kind: str,
    noise: Noise,
    verdict: tuple[float, float],
    repeatable: tuple[float, float],
    doubt: str,
) -> None:
    selection, said = known
    found = judged(replace(said, kind=kind), shares(verdict, repeatable), selection.setting.with_noise(noise))
    assert (found.kind, found.doubt) == ("undecided" if doubt else kind, doubt)


def test_what_is_worse_in_one_part_and_better_in_another_is_the_disturbance(known: tuple[Selection, Verdict]) -> None:
    selection, said = known
    setting = selection.setting.with_noise(STILL)
    drifting = shares((-0.4, -0.1), (0.0, 0.0), gains=(-1.0, 0.3, -0.1))
    assert judged(said, drifting, setting).doubt == ""
    assert judged(said, shares((-0.4, -0.1), (0.0, 0.0)), setting).doubt == "worse"


def test_what_a_large_gap_of_the_nominal_dwarfs_is_seen_beside_what_own_parameters_leave(
    known: tuple[Selection, Verdict],
) -> None:
    selection, said = known
    said, setting = replace(said, kind="unknown"), selection.setting
    lines = [("parameters", 0.9995), ("repeatable", 0.0002), ("noise", 0.0003)]
    budget = shares((0.0, 0.0), (0.0, 0.0))
    budget = replace(budget, lines=tuple(Line(kind, kind, share, (share, share)) for kind, share in lines))
    assert judged(said, budget, setting).doubt == ""
    nothing = replace(budget, lines=(budget.lines[0], Line("noise", "noise", 0.0005, (0.0, 0.001))))
    assert judged(said, nothing, setting).doubt == "unseen"


def test_what_all_probable_sets_have_in_common_is_named() -> None:
    """What acts beside it is not decided; where they have nothing in common, nothing is."""
    selection = select(recordings({"linear_drag.c": 0.15}), ("linear_drag", "tether", "seiche"))
    drag, tether, seiche = selection.named
    both = [replace(drag, hypothesis=Hypothesis((*drag.hypothesis.effects, *other.hypothesis.effects)))
            for other in (tether, seiche)]  # fmt: skip
    selection = replace(selection, named=(drag, *both, tether))
    names = [fit.hypothesis.name for fit in selection.named]
    found = decide(selection, dict(zip((*names, "unknown"), (0.25, 0.4, 0.25, 0.0, 0.1), strict=True)))
    assert (found.kind, found.effects, found.doubt) == ("effect", ("linear_drag",), "beside")
    assert found.probability == pytest.approx(0.9)
    apart = decide(selection, dict(zip((*names, "unknown"), (0.0, 0.4, 0.15, 0.35, 0.1), strict=True)))
    assert (apart.kind, apart.doubt) == ("undecided", "")
