"""The gap budget in the document, in words and in pictures, and what has no name beside it."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from drawings import SVG, cut_off
from recorded import NOISE, NOMINAL, differing
from test_report_words import document

from vtank.diagnose.evidence import evaluate
from vtank.diagnose.holdout import model_of
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.localise.gap import RunGap
from vtank.diagnose.selection import Selection, prepare, with_nameless
from vtank.diagnose.unnamed import unnamed
from vtank.diagnose.verdict import Verdict
from vtank.plant.parameters import slot, vector
from vtank.present import pictures_budget, whole, words, words_budget
from vtank.present.terminal import terminal_text

MINUS = "\N{MINUS SIGN}"
STILL = {"sigma_m_s2": 3e-4, "memory_s": 2.0, "plausible": True}
WHOLE = "Of the mean-square error of the simulator as it is on runs left out, "
REST = (("repeatable, unnamed", "repeatable"), ("disturbance", "disturbance"), ("sensor noise", "noise"))


def lines(parameters: float, effects: dict[str, float], *rest: float) -> list[dict[str, Any]]:
    """Lines of a budget: own parameters, effects by name, then repeatable, disturbance and noise."""
    names = [("own parameters", "parameters"), *((name, "effect") for name in effects), *REST]
    shares = [parameters, *effects.values(), *rest]
    return [{"name": name, "kind": kind, "share": share, "interval90": [share - 0.02, share + 0.02]}
            for (name, kind), share in zip(names, shares, strict=True)]  # fmt: skip


def budgeted(kind: str, shares: list[dict[str, Any]], *found: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """A document with a budget and with what has no name."""
    left = sum(line["share"] for line in shares if line["kind"] in ("repeatable", "disturbance"))
    effects = tuple(line["name"] for line in shares if line["kind"] == "effect") if kind == "effects" else ()
    parts = {"budget": shares, "disturbance": STILL, "unexplained": {"share": left, "interval90": [left, left]},
             "worse": [], "unnamed": list(found)}  # fmt: skip
    return document(kind, effects, **parts | changes)


def component(kind: str = "function", about: str = "speed", **changes: Any) -> dict[str, Any]:
    """Something without a name."""
    told = {"kind": kind, "channel": "hydrodynamics", "about": about, "force": True, "gain": 20.0, "windows": [],
            "frequency_rad_s": None, "runs": []}  # fmt: skip
    return told | changes


def test_the_shares_are_told_in_one_sentence() -> None:
    found = budgeted("effects", lines(0.39, {"tachometer_bias": 0.5, "linear_drag": 0.105}, 0.0, 0.004, 0.001))
    assert words_budget.budget(found) == [
        f"{WHOLE}own parameters account for 39 %, tachometer bias for 50 % and linear drag for 10 %; 0.4 % is "
        "disturbance (0.3 mm/s², as still water and its own wake make) and 0.1 % is sensor noise.",
        "Own parameters are taken off first and may imitate the causes, which alone may account for nearly all.",
    ]
    assert f"Budget      {WHOLE}own" in terminal_text(found)


def test_a_step_that_made_it_worse_adds_to_the_gap() -> None:
    found = budgeted("effects", lines(-0.03, {"linear_drag": 1.02}, 0.0, 0.0, 0.01))
    told = words_budget.shared_out(found)
    assert told.startswith(f"{WHOLE}linear drag accounts for 102 %; 1.0 % is sensor noise;")
    assert told.endswith("; a refit adds 3.0 %, so that the shares of the others come to 103 %.")


def test_of_a_whole_vehicle_no_share_is_hidden_and_what_they_are_of_is_said() -> None:
    table = whole.budget(lines(-0.12, {"linear_drag@yaw": 1.11}, 0.0, 0.0, 0.01))
    assert [row[1] for row in table.rows] == [f"{MINUS}12 %", "111 %", "0 %", "0 %", "1.0 %"]
    assert table.notes[0] == "Shares of the mean-square error of the simulator as it is; they add to 100 %."
    assert "below zero adds" in table.notes[1]
    assert len(whole.budget(lines(0.02, {"linear_drag@yaw": 0.97}, 0.0, 0.0, 0.01)).notes) == 1


def test_own_parameters_that_may_imitate_the_cause_are_told_by_every_outlet() -> None:
    """A refit bends drag and thrust until they hide most of a cause, also where the simulator's own are right."""
    told = "Own parameters are taken off first and may imitate the cause, which alone may account for up to 98 %."
    found = budgeted("effects", lines(0.91, {"linear_drag": 0.067}, 0.0, 0.0, 0.023))
    assert words_budget.budget(found)[1] == told
    assert told in " ".join(terminal_text(found).split())
    assert whole.budget(lines(0.91, {"linear_drag@yaw": 0.067}, 0.0, 0.0, 0.023)).notes[1] == told
    none = budgeted("parameters", lines(0.91, {}, 0.0, 0.0, 0.09))
    assert "imitate" not in " ".join(words_budget.budget(none))


def test_without_a_simulator_the_fit_of_drag_and_thrust_has_the_line() -> None:
    found = budgeted("none", lines(0.2, {}, 0.0, 0.3, 0.5), nominal="none")
    assert "error of drag and thrust alone on runs left out, a refit accounts for 20 %;" in words_budget.shared_out(
        found
    )


def test_what_is_not_explained_is_told_with_what_it_goes_with() -> None:
    shares = lines(0.2, {}, 0.7, 0.03, 0.07)
    found = budgeted("unknown", shares, component(), component(about="speed and input"))
    assert words_budget.unexplained(found) == "73 % of it is not explained; it repeats, and goes with speed and input."
    assert words_budget.unexplained(budgeted("unknown", shares)) == "73 % of it is not explained; it repeats."
    found = budgeted("unknown", shares, component(about="drag over time"), component(about="place", force=False))
    assert words_budget.unexplained(found) == (
        "73 % of it is not explained; it repeats, and is drag that changes with the time since the start of a run and "
        "is an error of the sonar that goes with place."
    )
    del found["where"]["region"]["distance_m"]
    assert "an error of the readings" in words_budget.unexplained(found)


def test_what_earns_little_beside_the_most_telling_is_left_out() -> None:
    own = [{"run": "a", "change": 0.1, "sd": 0.2}]
    weak = component("run", "thrust", runs=own, gain=3.0), component(about="place", gain=3.5)
    found = budgeted("unknown", lines(0.2, {}, 0.7, 0.03, 0.07), component(gain=100.0), *weak)
    assert words_budget.budget(found)[1:] == ["73 % of it is not explained; it repeats, and goes with speed."]
    found["verdict"]["kind"] = "varying"
    assert "Thrust gain differs" in words_budget.budget(found)[-1]


def test_what_does_not_come_again_is_said_not_to() -> None:
    found = budgeted("unknown", lines(0.2, {}, 0.0, 0.73, 0.07), component())
    assert words_budget.unexplained(found) == (
        "73 % of it is not explained; it does not come again on data left out, but here goes with speed."
    )


def test_windows_lines_and_what_wanders_are_placed() -> None:
    window = component("window", "drag", windows=[{"run": "run_1", "from": 61.0, "to": 85.0}])
    again = component("window", "drag", windows=[{"run": "run_4", "from": 5.0, "to": 9.0}])
    line = component("line", "error", force=False, frequency_rad_s=0.8)
    found = budgeted("unknown", lines(0.2, {}, 0.0, 0.73, 0.07), window, line, again, component("wander", "thrust"))
    assert words_budget.places(found) == [
        "In run_1 from 61 to 85 s and in run_4 from 5 to 9 s it looks as if drag changed.",
        "At 0.80 rad/s there is an error of the sonar.",
        "Thrust comes and goes without a rule.",
    ]
    assert "73 % does not repeat" in words_budget.shared_out(found)


def test_little_that_is_left_is_not_gone_into() -> None:
    shares = lines(0.5, {"linear_drag": 0.48}, 0.01, 0.005, 0.005)
    assert words_budget.unexplained(budgeted("effects", shares, component())) == ""
    assert words_budget.places(budgeted("effects", shares, component("line", "force", frequency_rad_s=1.0))) == []


def test_parameters_that_differ_from_run_to_run_are_told_in_order() -> None:
    own = [{"run": "a", "change": 0.031, "sd": 0.002}, {"run": "b", "change": -0.004, "sd": 0.002}]
    found = budgeted("varying", lines(0.5, {}, 0.0, 0.4, 0.1), component("run", "thrust", runs=own), estimates={})
    found["verdict"]["varying"] = ["beta"]
    assert words.verdict(found) == ("The simulator's structure is right, but its thrust gain differs from run to run.")
    assert words_budget.budget(found)[1:] == [
        f"Thrust gain differs from run to run: +3.1 ± 0.2 %, {MINUS}0.4 ± 0.2 %, in order of the runs."
    ]
    found["verdict"]["varying"] = ["beta", "alpha"]
    assert words.verdict(found).endswith("but its thrust gain and quadratic drag differ from run to run.")
    found["estimates"] = {"seiche": {}}
    assert words.verdict(found) == "Thrust gain and quadratic drag differ from run to run."


def test_a_disturbance_that_still_water_does_not_have_is_always_said() -> None:
    rough = {"sigma_m_s2": 0.012, "memory_s": 3.0, "plausible": False}
    for kind in ("none", "parameters", "effects", "unknown"):
        told = terminal_text(budgeted(kind, lines(0.5, {}, 0.0, 0.4, 0.1), disturbance=rough))
        assert "The disturbance, 12 mm/s² with a memory of 3 s, is several times what" in " ".join(told.split()), kind
        assert "as still water and its own wake make" not in told


def test_no_gap_says_what_is_left() -> None:
    told = words.explanation(budgeted("none", lines(0.0, {}, 0.0, 0.03, 0.97)))
    assert told[0] == (
        "What is missed is no larger than sensor noise and a disturbance of 0.3 mm/s², as still water and its own wake "
        "make."
    )


def test_a_part_that_is_predicted_worse_is_named() -> None:
    found = budgeted("effects", lines(0.5, {"linear_drag": 0.4}, 0.0, 0.05, 0.05), worse=["run_2", "run_4"])
    assert words_budget.budget(found)[-1] == (
        "On run_2 and run_4 the diagnosed simulator predicts worse than the refitted one."
    )


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0 %"), (0.0004, "under 0.1 %"), (0.004, "0.4 %"), (0.39, "39 %"), (0.999, "over 99 %"), (1.0, "100 %"),
     (1.2, "120 %"), (-0.034, f"{MINUS}3.4 %")],
)  # fmt: skip
def test_shares_in_percent(value: float, text: str) -> None:
    assert words_budget.share(value) == text


def test_a_missing_law_is_told_with_its_formula() -> None:
    law = {"formula": "c * speed^1.5 [m/s2]", "sentence": "A force goes with the power 1.5 of speed.",
           "gap_closed": 0.93, "probability": 0.62}  # fmt: skip
    told = " ".join(
        terminal_text(budgeted("unknown", lines(0.2, {}, 0.7, 0.03, 0.07), component(), laws=[law])).split()
    )
    assert (
        "Law A force goes with the power 1.5 of speed. c * speed^1.5 [m/s2]. It closes 93 % of what refitting" in told
    )
    assert "Law " not in terminal_text(budgeted("unknown", lines(0.2, {}, 0.7, 0.03, 0.07), laws=[]))


# --- by run, from recordings ---------------------------------------------------------------------------------------
@pytest.mark.parametrize("lag_s", [0.7074, 0.0])
def test_a_gain_that_differs_is_measured_in_percent(lag_s: float) -> None:
    """Also where thrust has no lag, and the force is what the input makes."""
    factors = np.array([1.06, 1.02, 0.98, 0.94])
    own = [{"beta": b * NOMINAL[slot("beta")], "thrust_lag.tau": lag_s} for b in factors]
    setting = prepare(differing(own), vector({"thrust_lag.tau": lag_s}, NOMINAL)).with_noise(NOISE)
    nominal, refit = (evaluate(setting, Hypothesis(refit=free)) for free in (False, True))
    selection = with_nameless(Selection(setting, nominal, refit, ()))
    found = unnamed(selection, Verdict("varying", (), (), None, 1.0, refit, ("beta",)))
    runs = next(c["runs"] for c in found if c["about"] == "thrust" and c["runs"])
    assert [run["run"] for run in runs] == [run.name for run in selection.setting.runs]
    change, sd = (np.array([run[key] for run in runs]) for key in ("change", "sd"))
    np.testing.assert_allclose(change, factors / np.mean(factors) - 1.0, atol=0.01)
    assert np.all((sd > 0.0) & (sd < 0.02))
    model = model_of(selection.free[-1].fit)  # which predicts a run of its own too
    assert model.per_run == ("beta",) and model.grid.shape[0] == 1


# --- pictures ------------------------------------------------------------------------------------------------------
def boxes(svg: str) -> list[tuple[float, float]]:
    """Left and right end of every bar."""
    found = ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}rect")
    return [(float(r.attrib["x"]), float(r.attrib["x"]) + float(r.attrib["width"])) for r in found]


def test_the_waterfall_goes_from_all_to_nothing() -> None:
    found = budgeted("effects", lines(0.4, {"linear_drag": 0.3}, 0.1, 0.05, 0.15))
    bars = boxes(pictures_budget.budget_picture(found["budget"], found))
    assert len(bars) == 5
    for upper, lower in zip(bars, bars[1:], strict=False):  # each begins where the one above it ended
        assert lower[1] == pytest.approx(upper[0], abs=0.2)
    whole = bars[0][1] - bars[-1][0]
    assert [(b - a) / whole for a, b in bars] == pytest.approx([0.4, 0.3, 0.1, 0.05, 0.15], abs=0.002)


def test_every_run_is_shown_measured_and_simulated() -> None:
    time = np.arange(0.0, 30.0, 0.1)
    error = {"nominal": 0.1 * np.sin(time), "refit": 0.05 * np.sin(time), "diagnosed": 0.0 * time}
    counts = dict.fromkeys(error, np.ones(time.size, bool))
    gaps = [RunGap(f"run_{k}", 0, time, np.cos(time), error, counts, 0.01, 0.5) for k in range(7)]
    svg = pictures_budget.runs_picture(gaps, "nominal")
    root = ElementTree.fromstring(svg)
    texts = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert all(f"run_{k}" in texts for k in range(7)) and texts.count("range [m]") == 7
    curves = [e.attrib["class"] for e in root.iter("{http://www.w3.org/2000/svg}polyline")]
    assert curves.count("line nominal") == curves.count("line diagnosed") == 14  # over time, and their errors below
    assert cut_off(svg) == []


def test_a_simulator_that_leaves_the_recording_is_cut_off_at_its_panel() -> None:
    """The panel shows what was measured and diagnosed: another simulator does not run across the errors below it."""
    time = np.arange(0.0, 30.0, 0.1)
    error = {"nominal": 0.2 * time, "diagnosed": 0.0 * time}
    counts = dict.fromkeys(error, np.ones(time.size, bool))
    gap = RunGap("run", 0, time, np.cos(time), error, counts, 0.01, 0.5)
    root = ElementTree.fromstring(pictures_budget.runs_picture([gap], "nominal"))
    clips = {e.attrib["class"]: e.get("clip-path") for e in list(root.iter(f"{SVG}polyline"))[:2]}
    assert clips == {"line nominal": "url(#runs-1)", "line diagnosed": None}


def test_a_verdict_that_the_budget_does_not_bear_out_says_why() -> None:
    found = budgeted("undecided", lines(-0.2, {}, 0.0, 0.3, 0.9))
    found["verdict"]["doubt"] = "worse"
    assert "but it predicts data left out worse than refitted parameters do." in words.verdict(found)
