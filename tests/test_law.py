"""A law that is data: interpreted as written, in files and back, and found again from recordings."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from synthetic import observed, sine

from vtank.cli import main
from vtank.diagnose.evidence import evaluate
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.laws import found
from vtank.diagnose.laws.found import laws
from vtank.diagnose.laws.metric import BLOCKS, blocks, metric
from vtank.diagnose.laws.screen import screened, structure
from vtank.diagnose.laws.words import sentence
from vtank.diagnose.selection import prepare
from vtank.errors import InputError
from vtank.estimate.problem import Noise
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario
from vtank.experiment.surge_model import simulate_surge
from vtank.experiment.tank_model import simulate_tank
from vtank.plant.formula import Factor, Formula, Memory, formula_of, law_lines, read_formula, read_law
from vtank.plant.law import operated
from vtank.plant.parameters import slot, vector
from vtank.plant.surge import memory_rate, surge_acceleration
from vtank.plant.truth import load_truth
from vtank.present.draft import draft
from vtank.record.table import open_table

NOMINAL = vector({"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.6})
DRAG = Formula("force", (Factor("u", "signed", 1.5),), None, -0.1)
NEAR = Formula("force", (Factor("u", "signed", 2.0), Factor("gap", "above", 2.5, -0.1)), None, -0.8)
MOTOR = Memory("follows", Factor("n", "signed", 1.0), 2.0)
LATE = Formula("force", (Factor("z", "signed", 1.0), Factor("w", "signed", 1.0)), MOTOR, -0.01)
WASH = Formula("force", (Factor("w", "signed", 1.0),), Memory("delays", Factor("n", "signed", 2.0), 1.5), -2e-4)
SLACK = Formula("force", (Factor("fresh", "signed", 1.0),), Memory("plays", Factor("n", "signed", 1.0), 2.0), -3e-3)
LUMPED = "alpha_per_m = -2.5\nbeta_m_per_rev2 = 5e-4\ngamma_per_rev = 0.0\ntau_s = 0.6\n"
TRUTH = 'name = "t"\nsource = "s"\nn_limit_rev_s = 20.0\n[lumped]\n' + LUMPED


@pytest.mark.parametrize(("operation", "a", "b", "expected"), [
    ("power", 1.5, 0.0, lambda y: abs(y) ** 1.5), ("power", -2.0, 0.0, lambda y: abs(y) ** -2.0),
    ("signed", 0.5, 0.0, lambda y: math.copysign(abs(y) ** 0.5, y)), ("signed", 0.0, 0.1, lambda y: math.tanh(y / 0.1)),
    ("above", 0.3, 0.1, lambda y: 0.5 + 0.5 * math.tanh((y - 0.3) / 0.1)),
    ("above", 0.3, -0.1, lambda y: 0.5 - 0.5 * math.tanh((y - 0.3) / 0.1)),
    ("beyond", 0.3, 1.0, lambda y: max(y - 0.3, 0.0)), ("beyond", 0.3, -1.0, lambda y: max(0.3 - y, 0.0)),
    ("sine", 3.0, 0.4, lambda y: math.sin(3.0 * y + 0.4)), ("decay", 2.0, 0.0, lambda y: math.exp(-y / 2.0)),
    ("from", 0.3, 0.0, lambda y: y - 0.3),
])  # fmt: skip
def test_an_operation_is_what_it_is_called(operation, a, b, expected):
    from vtank.plant.law import OPERATIONS

    for y in (-0.7, 0.2, 1.3):
        assert operated(float(OPERATIONS.index(operation)), y, a, b) == pytest.approx(expected(y), rel=1e-12)


def test_a_law_acts_in_the_equation_of_motion_and_a_null_one_changes_nothing():
    at = (3.0, 0.4, -0.25, 0.03, 5.0, -9.0, 2.6, 0.0)
    still = (*at[:4], 0.0, *at[5:])  # the fifth, 5.0, is the memory of a law, and nothing where none has one
    plain = surge_acceleration(*still, NOMINAL)
    p = vector(NEAR.values(), NOMINAL)
    expected = -0.8 * -(0.25**2) * (0.5 + 0.5 * math.tanh((2.6 - 2.5) / -0.1))
    assert surge_acceleration(*still, p) - plain == pytest.approx(expected, rel=1e-9)
    late = vector(LATE.values(), NOMINAL)
    assert surge_acceleration(*at, late) - plain == pytest.approx(-0.01 * 0.03 * 5.0, rel=1e-9)
    assert memory_rate(3.0, 0.4, -0.25, 0.03, 5.0, -9.0, late) == pytest.approx((-9.0 - 5.0) / 2.0)
    p[slot("law.force")] = 0.0
    assert surge_acceleration(*still, p) == plain


def test_a_latch_holds_between_its_levels():
    latch = Formula("force", (Factor("w", "power", 1.0),), Memory("latches", Factor("n", "signed", 1.0), 8.0, 3.0))
    p = vector(latch.values(), NOMINAL)
    rates = [memory_rate(0.0, 0.0, 0.0, 0.0, w, n, p) for w, n in ((0.0, 9.0), (1.0, 5.0), (0.0, 5.0), (1.0, 2.0))]
    assert np.sign(rates).tolist() == [1.0, 0.0, 0.0, -1.0]


def test_units_make_the_whole_an_acceleration():
    assert DRAG.unit == "m^-0.5 s^-0.5" and NEAR.unit == "m^-1" and LATE.unit == "rev^-1 s"
    assert NEAR.unit_of("law.a2") == "m" and LATE.unit_of("law.memory_a") == "s"
    assert NEAR.text() == "du/dt += -0.8 u|u| [gap < 2.5 within 0.1]" and LATE.channel == "actuator"
    assert sentence(DRAG) == "A force per unit of moving mass goes with the power 1.5 of speed."


def held(memory: Memory, n: np.ndarray, t: np.ndarray) -> np.ndarray:
    """What a memory gives along an input, in the state that the equation of motion carries, and the force it makes."""
    p, w, out = vector(Formula("force", (Factor("w", "signed", 1.0),), memory).values(), NOMINAL), 0.0, []
    for now, h in zip(n, np.diff(t), strict=False):
        out.append(surge_acceleration(0.0, 0.0, 0.0, 0.0, w, now, 3.0, 0.0, p))
        for _ in range(4):
            w += 0.25 * h * memory_rate(0.0, 0.0, 0.0, 0.0, w, now, p)
    return np.array(out)


def test_a_delay_is_what_the_input_was_and_play_takes_up_what_it_gives():
    t = np.arange(0.0, 60.0, 0.05)
    n = 10.0 * np.sin(0.4 * t)
    late, slack = held(Memory("delays", Factor("n", "signed", 1.0), 1.5), n, t), held(SLACK.memory, n, t)
    assert np.max(np.abs(late - np.interp(t[:-1] - 1.5, t, n))[t[:-1] > 6.0]) < 0.05 * 10.0
    assert np.max(np.abs(slack - n[:-1])) < 2.5 and np.ptp(slack[t[:-1] > 20.0]) == pytest.approx(16.0, abs=0.6)


def test_a_law_of_the_input_has_the_units_and_the_name_of_that_input():
    by_force, by_command = (replace(WASH, fed=fed) for fed in ("thrust_N", "command"))
    assert (WASH.unit, by_force.unit, by_command.unit) == ("m rev^-2", "N^-2 m s^-2", "m s^-2")
    assert SLACK.unit_of("law.memory_a") == "rev s^-1" and WASH.unit_of("law.memory_a") == "s"
    assert sentence(by_force).endswith("goes with what the power 2 of the thrust put in was 1.5 s before.")
    assert sentence(SLACK).endswith("goes with what a play of 2 rev/s to either side takes off propeller speed.")
    latch = Formula("force", (Factor("w", "from", 1.0),), Memory("latches", Factor("u", "signed", 1.0), 0.2, 0.1))
    assert sentence(latch).endswith("while a latch that speed sets above 0.2 m/s and frees below 0.1 m/s is off.")
    above = Formula("force", (Factor("turning", "beyond", 0.4, 1.0),), fed="command")
    assert sentence(above).endswith("in proportion to what the size of the command is above 0.4.")
    assert above.moved({"law.a1": 0.5}).fed == "command"


@pytest.mark.parametrize("formula", [DRAG, NEAR, LATE, WASH, replace(SLACK, fed="thrust_N")])
def test_a_law_is_read_back_as_it_was_written(formula, tmp_path: Path):
    path = tmp_path / "law.toml"
    path.write_text(TRUTH + "\n".join(law_lines(formula)))
    assert read_formula(open_table(path)) == formula == formula_of(read_law(open_table(path)), formula.fed)
    np.testing.assert_array_equal(load_truth(path).vector()[slot("law.force")], formula.size)


@pytest.mark.parametrize(("text", "message"), [
    ('acts = "push"', "acts: expected"), ('acts = "force"\nsize = 1\nfactors = ["v power 1 0"]', "found 'v' in"),
    ('acts = "force"\nsize = 1\nfactors = ["u power"]', "expected 2 words and 2 numbers"),
    ('acts = "force"\nsize = 1\nfactors = ["w power 1 0"]', "memory: missing"),
    ('acts = "range"\nsize = 1\nfactors = ["n power 1 0"]', "expected those of u, speed"),
])  # fmt: skip
def test_a_law_that_cannot_be_read_is_refused_by_key(text: str, message: str, tmp_path: Path):
    path = tmp_path / "law.toml"
    path.write_text(f"{TRUTH}[law]\n{text}\n")
    with pytest.raises(InputError, match="law.toml") as refused:
        load_truth(path)
    assert message in str(refused.value)


def flown(tmp_path: Path, law: Formula | None, effects: dict[str, float], simulate) -> np.ndarray:
    path = tmp_path / "truth.toml"
    path.write_text(TRUTH + "\n".join(law_lines(law) if law else []))
    quiet = ("duration_s=20", "sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0")
    scenario = replace(load_scenario("open-loop-sine", quiet), effects=effects)
    return simulate([plan_run(scenario, seed=3, truth=load_truth(path))])[0].run.columns["range_m"]


@pytest.mark.parametrize("simulate", [simulate_surge, simulate_tank])
def test_a_truth_with_a_law_flies_like_the_effect_it_spells_out(simulate, tmp_path: Path):
    linear = Formula("force", (Factor("u", "signed", 1.0),), None, -0.2)
    np.testing.assert_allclose(
        flown(tmp_path, linear, {}, simulate),
        flown(tmp_path, None, {"linear_drag.c": 0.2}, simulate),
        atol=1e-9,
        rtol=0.0,
    )
    stretched = Formula("range", (Factor("gap", "power", 1.0),), None, 0.01)
    np.testing.assert_allclose(
        flown(tmp_path, stretched, {}, simulate),
        flown(tmp_path, None, {"sonar_scale.s": 0.01}, simulate),
        atol=1e-9,
        rtol=0.0,
    )


def weighed(p: np.ndarray, seeds: tuple[int, int], error=lambda x: 0.0 * x):
    drives = (sine(14.0, 0.2), lambda t: 12.0 * np.sign(np.sin(0.3 * t + 1.0)) + 3.0 * np.sin(1.3 * t))
    runs = [observed(p, n, seed=seed, duration_s=80.0, name=f"r{seed}") for n, seed in zip(drives, seeds, strict=True)]
    runs = [replace(run, value=run.value + error(p[slot("standoff")] - run.value)) for run in runs]
    setting = prepare(runs, NOMINAL).with_noise(Noise((0.006**2,) * 3, 5e-4, 1.0))
    return setting, evaluate(setting, Hypothesis())


@pytest.mark.slow
def test_a_law_is_found_again_with_its_numbers():
    beyond = Formula("force", (Factor("u", "signed", 2.0), Factor("x", "above", 0.2, 0.05)), None, -0.8)
    setting, fit = weighed(vector(beyond.values(), NOMINAL), (1, 2))
    told = laws(setting, fit, "hydrodynamics", ())
    assert structure(told[0].formula) == structure(beyond), [law.formula.text() for law in told]
    assert told[0].parameters["a2"]["value"] == pytest.approx(0.2, abs=0.05)
    best = told[0]
    assert best.gap_closed > 0.8 and 0.0 < best.probability < 1.0
    assert best.document().keys() >= {"formula", "channel", "place", "parameters", "sentence", "gap_closed"}
    low, high = best.parameters["size"]["interval90"]
    assert low < best.parameters["size"]["value"] < high


def test_what_the_unknowns_take_up_does_not_show():
    _, fit = weighed(NOMINAL, (1, 2))
    seen = metric(fit, "range")
    assert any(run.time_s.size % BLOCKS for run in fit.problem.runs)
    ones = [s.patterns @ blocks(np.ones((run.time_s.size, 1))).sum(axis=1) for s, run in
            zip(seen.runs, fit.problem.runs, strict=True)]  # fmt: skip
    taken, _ = seen.moments(ones)
    total = sum(float(np.sum(one**2)) for one in ones)
    left = total - float(np.sum(taken * (seen.solve @ taken)))
    assert left < 1e-4 * total  # a constant error of the range is another start


@pytest.mark.slow
def test_an_error_of_the_range_is_found_in_all_its_slowness():
    wavy = Formula("range", (Factor("x", "sine", 4.0, 0.5),), None, 0.02)
    setting, fit = weighed(NOMINAL, (1, 2), lambda x: 0.02 * np.sin(4.0 * x + 0.5))
    told = laws(setting, fit, "sensor", ())
    assert structure(told[0].formula) == structure(wavy), [law.formula.text() for law in told]
    assert told[0].formula.factors[0].a == pytest.approx(4.0, rel=0.03)
    assert told[0].probability > 0.9 and len({law.formula.text() for law in told}) == len(told)


@pytest.mark.slow
def test_where_the_grammar_lacks_the_form_no_formula_is_called_probable(monkeypatch: pytest.MonkeyPatch):
    wavy = Formula("force", (Factor("u", "signed", 2.0), Factor("t", "sine", 0.11, 0.4)), None, 1.5)
    without = [lambda p: "t" not in {f.variable for f in p.formula.factors}, lambda p: True]
    chances = []
    for allowed in without:
        monkeypatch.setattr(found, "screened", lambda *a, ok=allowed: [p for p in screened(*a) if ok(p)])
        first = laws(*weighed(vector(wavy.values(), NOMINAL), (1, 2)), "hydrodynamics", ())[:1]
        chances.append(first[0].probability if first else 0.0)
    assert chances[0] < 0.1 and chances[1] > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [(1, 2), (3, 4), (5, 6)])
def test_no_law_is_invented_where_nothing_is_missing(seeds):
    assert laws(*weighed(NOMINAL, seeds), "hydrodynamics", ()) == ()


def test_a_draft_is_the_law_in_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "model.toml").write_text(TRUTH + "\n".join(law_lines(NEAR)))
    monkeypatch.chdir(tmp_path)
    assert main(["effects", "near_wall", "--draft", "model.toml"]) == 0
    text = (tmp_path / "near_wall.py").read_text()
    assert text == draft("near_wall", NEAR, sentence(NEAR)) and "finish" in capsys.readouterr().out
    space: dict = {}
    exec(text.replace("from ..compiled", "from vtank.compiled").replace("from .effect", "from vtank.effects.effect")
         .replace("@law\n", ""), space)  # fmt: skip
    p, at = vector(NEAR.values(), NOMINAL), (3.0, 0.4, -0.25, 0.03, 5.0, -9.0, 2.6, 0.0)
    expected = surge_acceleration(*at, p) - surge_acceleration(*at, NOMINAL)
    names = [q.name for q in space["EFFECT"].parameters]
    assert names == ["force", "a2", "b2"]
    assert space["EFFECT"].does and space["EFFECT"].depends_on == ("place",)  # nothing is left to be wired
    assert space["acceleration"](-0.25, 2.6, -0.8, 2.5, -0.1) == pytest.approx(expected)
    assert main(["effects", "near_wall", "--draft", "model.toml"]) == 2  # it is there already
