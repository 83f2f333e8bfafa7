"""What is left beside a named cause speaks for it, or for a cause without a name that it imitates."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vtank.diagnose.whole.model import Model
from vtank.diagnose.whole.own import Unknown

diagnosis = importlib.import_module("vtank.diagnose.whole.diagnosis")
odds = importlib.import_module("vtank.diagnose.whole.odds")
Block = importlib.import_module("vtank.diagnose.whole.unnamed").Block


def _model(log_evidence: float) -> SimpleNamespace:
    return SimpleNamespace(log_evidence=log_evidence, effects=(), names=(), unknowns=(1,))


def _named_over_unknown(explained: float, left: float) -> float:
    best, own = _model(explained), _model(0.0)
    return float(odds.imperfect(left, best, own) - odds.imitated(left, best, own))


def test_rough_water_is_no_cause_and_a_storm_in_a_tank_is_one():
    """Where nothing repeats: rougher than plausible by a little it is water still, ten times as rough hardly ever."""
    chances = [1.0 / (1.0 + np.exp(-odds.strange(times))) for times in (1.0, 1.5, 3.0, 10.0)]
    assert chances == sorted(chances)
    assert chances[1] < 0.5 < chances[2] and chances[3] > 0.99


@pytest.mark.parametrize(
    ("effects", "gained", "part", "visible", "beyond"),
    [
        (("linear_drag@yaw",), 400.0, -3.0, True, True),
        (("linear_drag@yaw",), 200.0, -3.0, True, False),
        ((), 0.0, 400.0, True, True),
        ((), 0.0, 400.0, False, False),
    ],
)
def test_a_gap_stands_where_recordings_tell_far_more_of_it_than_a_simulators_own_runs(
    effects: tuple[str, ...], gained: float, part: float, visible: bool, beyond: bool
):
    """Whatever free runs go astray by. A plant mimics 100 of log evidence here."""
    best, own = SimpleNamespace(log_evidence=gained, effects=effects), _model(0.0)
    block = SimpleNamespace(gain=part, visible=visible)
    trial = SimpleNamespace(best=best, own=own, blocks_alone=[block])
    assert diagnosis.outweighs(trial, {"unknown": 100.0, "coulomb_friction@surge": 20.0}) == beyond


@pytest.mark.parametrize("explained", [300.0, 3e4])
def test_what_is_left_decides_by_its_share(explained):
    assert _named_over_unknown(explained, 0.0) > 3.0
    assert _named_over_unknown(explained, 0.003 * explained) > 2.0
    assert _named_over_unknown(explained, 0.15 * explained) < -3.0
    shares = [_named_over_unknown(explained, share * explained) for share in (0.01, 0.03, 0.1, 0.3, 1.0)]
    assert shares == sorted(shares, reverse=True)


def test_what_leaves_nothing_is_the_surer_the_more_it_explains():
    sure = [_named_over_unknown(explained, -3.0) for explained in (50.0, 500.0, 5000.0)]
    assert sure == sorted(sure)


def test_free_form_parts_of_one_place_add_up():
    """Of an instrument with several columns the least of them counted, whatever the others gained."""

    def block(place: str, gain: float) -> Block:
        return Block(place, "", gain, gain, (), 1.0)

    ground = _model(0.0)
    several = odds.nameless([block("ahrs", 500.0), block("yaw", 40.0), block("ahrs", -6.0)], ground, ground, -np.inf)
    assert several["unknown@ahrs"] > several["unknown@yaw"] + 400.0


def test_what_a_named_cause_imitates_is_where_free_form_parts_are():
    def block(place: str, gain: float) -> Block:
        return Block(place, "", gain, gain, (), 1.0)

    found = odds.nameless([block("yaw", 30.0), block("imu", 10.0)], _model(0.0), _model(0.0), 1000.0)
    assert found["unknown@yaw"] == pytest.approx(1000.0, abs=0.01)
    assert found["unknown@imu"] == pytest.approx(980.0, abs=0.01)


@dataclass
class Disturbed:
    """What the chance of a strange disturbance is read from: 100 kg, pushed by 10 N, 1 % of which is usual."""

    best: SimpleNamespace
    probabilities: dict[str, float]
    told: tuple[bool, ...] = (True,) * 6
    sizes = SimpleNamespace(force=10.0 * np.ones(6))

    @property
    def disturbance(self) -> np.ndarray:
        return self.best.fit.noise.sigma

    @property
    def runs(self) -> tuple[SimpleNamespace]:
        body = np.diag([100.0] * 3 + [1.0] * 3)  # 0.1 m off its axes
        hull = SimpleNamespace(body=body, water=np.zeros((6, 6)))
        return (SimpleNamespace(hull=lambda p: hull, asked=np.array(self.told)),)


def of_water(trial: Disturbed) -> Disturbed:
    return diagnosis.disturbed(trial, *diagnosis.too_large(trial))


@pytest.mark.parametrize(("sigma", "chance"), [(0.009, 0.0), (0.012, 0.25), (0.03, 0.75), (0.1, 0.98)])
def test_a_disturbance_that_no_water_makes_is_a_cause_without_a_name(
    monkeypatch: pytest.MonkeyPatch, sigma: float, chance: float
):
    """The surer the larger it is; what is within 10 % of the usual force, or 10 mm/s2, is water, and what might be."""
    monkeypatch.setattr(diagnosis, "needed", lambda selection, least: least[1] == pytest.approx(0.01))
    fit = SimpleNamespace(noise=SimpleNamespace(sigma=np.array([0.0, sigma, 0.0, 0.0, 0.0, 0.0])))
    best = SimpleNamespace(effects=(), vector=lambda: None, fit=fit)
    before = {"none": 0.8, "parameters": 0.1, "linear_drag@yaw": 0.1}
    after = of_water(Disturbed(best, before)).probabilities
    assert sum(after.values()) == pytest.approx(1.0)
    assert (after == before) if chance == 0.0 else (chance < after["unknown@sway"] < chance + 0.1)
    untold = (True, False, True, True, True, True)
    assert of_water(Disturbed(best, before, untold)).probabilities == before
    named = SimpleNamespace(**(vars(best) | {"effects": ("linear_drag@yaw",)}))
    assert of_water(Disturbed(named, before)).probabilities == before
    monkeypatch.setattr(diagnosis, "needed", lambda selection, least: False)
    assert of_water(Disturbed(best, before)).probabilities == before


@pytest.mark.parametrize(("sigma", "axis"), [(0.09, ""), (0.2, "roll")])
def test_what_turns_a_slender_hull_a_little_is_water(monkeypatch: pytest.MonkeyPatch, sigma: float, axis: str):
    """1 N m is usual, and 0.1 rad/s2 moves a point 0.1 m off the axis by 10 mm/s2."""
    monkeypatch.setattr(diagnosis, "needed", lambda selection, least: True)
    fit = SimpleNamespace(noise=SimpleNamespace(sigma=np.array([0.0, 0.0, 0.0, sigma, 0.0, 0.0])))
    trial = Disturbed(SimpleNamespace(effects=(), vector=lambda: None, fit=fit), {})
    trial.sizes = SimpleNamespace(force=np.array([10.0] * 3 + [0.5] * 3))
    assert diagnosis.too_large(trial)[0] == axis


def test_what_is_small_beside_what_own_parameters_explain_decides_nothing():
    """An effect is as likely as beforehand, not ruled out; one that gains far more is not held back by it."""
    own, nominal = _model(0.0), _model(-500_000.0)
    assert odds.of_own(own, nominal, 6.0) == 6.0 and odds.of_own(own, nominal, -2.0) == 0.0
    assert odds.of_own(own, nominal, 900.0) == 500_000.0 * odds.OWN_IMPERFECT


@pytest.mark.parametrize(("likelihood", "size", "seen"), [(200.0, 0.01, True), (40.0, 0.01, False), (40.0, 0.03, True)])
def test_what_is_ten_deviations_off_is_a_gap_however_small(likelihood: float, size: float, seen: bool):
    """A moment of a hundredth of the usual one is no gap while the noise hides it, and one where it does not.

    Whatever part of its likelihood the freedom of its form costs.
    """
    block = Block("pitch", "hydrodynamics", likelihood - 20.0, likelihood, ("surge speed",), size)
    assert block.visible is seen
    named = odds.nameless([block], _model(0.0), _model(0.0), -np.inf)["unknown@pitch"]
    assert np.isfinite(named) is np.bool_(seen)


def of(log_evidence: float, *names: str, pulled: float = 0.0) -> SimpleNamespace:
    effects = tuple(SimpleNamespace(effect=name, place="surge", name=name, mimicry=0.0) for name in names)
    return SimpleNamespace(log_evidence=log_evidence, effects=effects, names=names, unknowns=(1,), pulled=pulled)


@pytest.mark.parametrize(("pulled", "odds_of_effect"), [(0.0, 0.0), (38.0, 38.0), (60.0, 40.0)])
def test_that_own_parameters_must_go_too_far_is_no_matter_of_the_form_of_their_laws(
    pulled: float, odds_of_effect: float
) -> None:
    """Of 40 nats beside own parameters that explain a million, those count that are not due to a better fit."""
    own, nominal, effect = of(0.0, pulled=pulled), of(-1e6), of(40.0, "A")
    found = odds.prior_odds({"A": effect, "parameters": own}, own, nominal, effect.effects, {})
    prior = odds.log_prior(effect, effect.effects) - odds.log_prior(own, ())
    assert found["A"] - found["parameters"] - prior == pytest.approx(odds_of_effect)


def test_an_effect_is_not_held_to_the_form_of_one_that_explains_far_less():
    """B is found beside A and beside C; that B alone was looked at, too, takes nothing from A and B together."""

    own = of(0.0)
    sets = {"A": of(160_000.0, "A"), "A+B": of(162_000.0, "A", "B"), "A+C": of(161_900.0, "A", "C")}
    sets |= {"B": of(18_000.0, "B"), "parameters": own}
    candidates = tuple(of(0.0, *"ABC").effects)
    found = odds.prior_odds(sets, own, own, candidates, {"A": 30.0, "B": 5000.0})
    assert found["A+B"] - found["A+C"] == pytest.approx(100.0)
    assert found["A+B"] < 162_000.0 - 30.0


def test_an_unknown_along_which_the_motion_runs_away_tells_nothing():
    model = importlib.import_module("vtank.diagnose.whole.model")
    unknown = SimpleNamespace(step=0.5, high=np.inf)
    answers = np.array([[1.0, 1e200, np.nan], [2.0, 1.0, 1.0]])
    fit = SimpleNamespace(answers=lambda paths, moved: answers)
    some = SimpleNamespace(unknowns=[unknown] * 3, theta=np.zeros(3), vector=lambda theta: theta, fit=fit)
    np.testing.assert_array_equal(model.slopes(some, []), [[2.0, 0.0, 0.0], [4.0, 0.0, 0.0]])


@pytest.mark.parametrize(
    ("chances", "kind"),
    [
        ({"none": 0.2, "parameters": 0.25, "A@surge": 0.22, "B@yaw": 0.2, "unknown@yaw": 0.13}, "undecided"),
        ({"none": 0.3, "parameters": 0.25, "unknown@yaw": 0.35, "A@surge": 0.1}, "none"),
        ({"none": 0.1, "parameters": 0.8, "A@surge": 0.1}, "parameters"),
        ({"A@surge": 0.3, "unknown@yaw": 0.25, "unknown@surge": 0.2, "none": 0.25}, "undecided"),
    ],
)
def test_an_answer_that_less_than_half_speaks_for_is_none(chances: dict[str, float], kind: str):
    """No effect, none that has a name, or a set of effects: one of the three must have half of it."""
    sets = {name: SimpleNamespace(effects=()) for name in chances if not name.startswith("unknown")}
    selection = SimpleNamespace(probabilities=chances, blocks=(), sets=sets)
    verdict = diagnosis.verdict_of(selection, SimpleNamespace(lines=()))
    assert verdict.kind == kind
    if kind == "undecided":
        assert verdict.effects == () and len(verdict.rivals) > 1


def test_a_set_is_not_told_from_the_one_that_has_the_same_law_in_place_of_one_of_its_effects():
    late, weak = (
        SimpleNamespace(name=f"{effect}@{place}", effect=effect, place=place, exchange=False, channel="sensor")
        for effect, place in (("sensor_latency", "gyro"), ("fin_weak", "rudder"))
    )
    model = SimpleNamespace(effects=(weak, late), names=(weak.name, late.name))
    name = "fin_weak@rudder+sensor_latency@gyro"
    selection = SimpleNamespace(probabilities={name: 0.97, "unknown@yaw": 0.03}, blocks=(), sets={name: model})
    verdict = diagnosis.verdict_of(selection, SimpleNamespace(lines=()))
    assert verdict.rivals == (name, "clock_offset@gyro+fin_weak@rudder")


@pytest.mark.parametrize(
    ("apart", "strained", "alike"), [(2.5, 0.0, True), (3.5, 0.0, False), (2.5, 1.0, True), (0.0, 5.0, False)]
)
def test_sets_that_no_instrument_tells_apart_are_one_answer(apart: float, strained: float, alike: bool):
    """A moment that is constant, and a centre of buoyancy that lies elsewhere under a vehicle that stays upright.

    What own parameters do beside it in the place of an effect is no effect's: strained, half the squares of how far.
    """
    made = {"A@pitch": 0.0, "B@vehicle": apart, "C@yaw": 40.0}

    def of_one(name: str) -> SimpleNamespace:
        effect, _, place = name.partition("@")
        placed = SimpleNamespace(name=name, effect=effect, place=place, exchange=False, channel="hydrodynamics")
        strain = strained if effect == "B" else 0.0
        return SimpleNamespace(effects=(placed,), names=(name,), vector=lambda: made[name], fit=fit, strained=strain)

    def residuals(vectors: list[float], found: object) -> np.ndarray:
        return np.array([[10.0] * len(vectors), vectors])

    fit = SimpleNamespace(residuals=residuals)
    chances = {"A@pitch": 0.9, "B@vehicle": 0.04, "unknown@yaw": 0.05, "C@yaw": 0.01}
    sets = {name: of_one(name) for name in made}
    selection = SimpleNamespace(probabilities=chances, blocks=(), sets=sets, found=None)
    verdict = diagnosis.verdict_of(selection, SimpleNamespace(lines=()))
    assert verdict.rivals == (("A@pitch", "B@vehicle") if alike else ("A@pitch",))
    assert verdict.probability == pytest.approx(0.94 if alike else 0.9)


def test_own_parameters_in_the_place_of_an_effect_are_believed_less_the_farther_they_go() -> None:
    unknown = Unknown("gain@thrusters", np.array([0]), np.ones(1), 0.03, -1.0, 1.0, 1e-3)
    of_effect = replace(unknown, name="thruster_dead@port.share")
    effects: Any = (SimpleNamespace(name="thruster_dead@port"),)
    nothing: Any = SimpleNamespace()
    model = Model(nothing, effects, (unknown, of_effect), np.array([0.12, 0.9]), np.ones(1))
    assert model.strained == pytest.approx(0.5 * (0.12 / 0.03) ** 2)
