"""Cases: drawing, the scorer's own noise model and refit, replays, and the laws outside the catalogue."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2_contingency

from vtank.effects.catalogue import BY_NAME, CATALOGUE
from vtank.errors import InputError
from vtank.experiment import simulate_surge
from vtank.plant.parameters import null_vector, slot, vector
from vtank.plant.truth import load_truth
from vtank.studies.blind.case import KINDS, draw_case, draw_frequencies, given, label
from vtank.studies.blind.cause import RUNS, draw_cause
from vtank.studies.blind.experiment import amplitude_m
from vtank.studies.blind.fly import Passenger, passengers, quiet
from vtank.studies.blind.outside import OUTSIDE, Sight
from vtank.studies.blind.refit import NUISANCE, parameters, refit
from vtank.studies.blind.replay import Replay, repair, spikes_of
from vtank.studies.blind.rivals import best_fit, best_pair, others
from vtank.studies.blind.sizing import noise_free, post_refit, ready_case
from vtank.studies.blind.whitening import Whitener


def only(name: str, kind: str = "single", seed: int = 11, number: int = 0):  # type: ignore[no-untyped-def]
    frequencies = draw_frequencies(seed, (kind,), (name,))
    return draw_case(seed, number, 0, frequencies, familiar=True)


def test_a_case_is_drawn_again_bit_for_bit() -> None:
    frequencies = draw_frequencies(5)
    a, b = (draw_case(5, 3, 1, frequencies) for _ in range(2))
    assert a == b
    other = draw_case(5, 3, 2, frequencies)
    assert (other.kind, other.wanted) == (a.kind, a.wanted) and other.seed != a.seed


def test_frequencies_are_drawn_from_the_seed() -> None:
    a, b = draw_frequencies(1), draw_frequencies(2)
    assert sum(a.kinds.values()) == pytest.approx(1.0) and a.kinds.keys() == set(KINDS)
    assert max(abs(a.effects[name] - b.effects[name]) for name in a.effects) > 0.01
    assert "thrust_lag" not in a.effects  # the nominal has a lag of its own
    with pytest.raises(InputError, match="no effect 'drag'"):
        draw_frequencies(1, effects=("drag",))


def test_the_order_of_cases_tells_nothing() -> None:
    frequencies = draw_frequencies(6)
    kinds = [draw_case(6, number, 0, frequencies).kind for number in range(400)]
    halves = [Counter(kinds[:200]), Counter(kinds[200:])]
    table = [[half[kind] for half in halves] for kind in KINDS if half_total(halves, kind) >= 10]
    assert chi2_contingency(table).pvalue > 0.01
    assert set(kinds) == set(KINDS)


def half_total(halves: list[Counter[str]], kind: str) -> int:
    return sum(half[kind] for half in halves)


def test_labels() -> None:
    assert label(only("tether")) == "tether"
    assert label(only("command_delay")) == "sonar_latency"
    assert label(only("sonar_scale")) == "parameters"
    assert label(only("tether", "left_out")) == "unknown" and only("tether", "left_out").withheld == ("tether",)
    assert only("command_delay", "left_out").withheld == ("command_delay", "sonar_latency")
    assert label(only("cubic_drag", "outside")) == "unknown"
    assert label(only("tether", "none")) == "none" and label(only("tether", "parameters")) == "parameters"
    frequencies = draw_frequencies(1, ("pair",), ("tether", "seiche"))
    assert label(draw_case(1, 0, 0, frequencies)) == "seiche+tether"


@pytest.mark.parametrize("effect", [e.name for e in CATALOGUE if e.name != "thrust_lag"])
def test_every_cause_stays_within_its_bounds(effect: str) -> None:
    for seed in range(5):
        cause = draw_cause(effect, np.random.default_rng(seed))
        slots = cause.sized(1e9 if cause.solved else 1.0).slots(0)
        for p in BY_NAME[effect].parameters:
            low, high = p.bounds
            assert low <= slots[f"{effect}.{p.name}"] <= high
            assert BY_NAME[effect].outliers or p.shape or slots[f"{effect}.{p.name}"] != p.null


def test_amplitude_takes_the_wanted_thrust() -> None:
    truth = load_truth("paper-ii")
    for rad_s in (0.6, 1.0, 1.5):
        a = amplitude_m(rad_s, 12.0, truth)
        inertia, drag = a * rad_s**2, abs(truth.alpha_per_m) * (a * rad_s) ** 2
        assert math.hypot(inertia, drag) == pytest.approx(truth.beta_m_per_rev2 * 144.0)


def linear_covariance(w: Whitener, samples: int) -> np.ndarray:
    """Covariance of the ranges by sending a unit of every independent noise through the model, one at a time."""
    h, keep = w.period_s, w.keep
    sources = []
    for j in range(3):
        for k in range(samples):
            state, out = np.zeros(5), np.empty(samples)
            for i in range(samples):
                if i == k:
                    state[2 + j] += w.deviation[j] * (1.0 if k == 0 else math.sqrt(1.0 - keep[j] ** 2))
                out[i] = state[0] + state[4]
                x, u, d, q, s = state
                a, decay = d + w.push[i] * q, math.exp(-w.damping[i] * h)
                mean = (1.0 - decay) / w.damping[i] if w.damping[i] > 0.0 else h
                state = np.array([x + mean * u + 0.5 * h * h * a, decay * u + mean * a, *(keep * (d, q, s))])
            sources.append(out)
    return np.array(sources).T @ np.array(sources) + w.variance * np.eye(samples)


def test_whitening_is_the_cholesky_factor() -> None:
    random, samples = np.random.default_rng(3), 40
    w = Whitener(random.uniform(0.0, 2.0, samples), random.uniform(0.0, 0.1, samples), (0.05, 0.7, 0.004),
                 (1.5, 0.7, 0.5), 0.003**2, 0.1)  # fmt: skip
    columns = random.normal(size=(samples, 3))
    expected = np.linalg.solve(np.linalg.cholesky(linear_covariance(w, samples)), columns)
    assert w.whiten(columns) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_whitening_leaves_out_missing_pings() -> None:
    random, samples = np.random.default_rng(4), 30
    w = Whitener(np.full(samples, 0.5), np.zeros(samples), (0.05, 0.0, 0.0), (1.5, 0.7, 0.0), 1e-6, 0.1)
    column, missing = random.normal(size=samples), random.random(samples) < 0.3
    there = ~missing
    covariance = linear_covariance(w, samples)[np.ix_(there, there)]
    white = w.whiten(np.where(missing, np.nan, column)[:, None])[:, 0]
    assert np.all(white[missing] == 0.0)
    assert white[there] == pytest.approx(np.linalg.solve(np.linalg.cholesky(covariance), column[there]))


def test_a_replay_is_the_surge_model() -> None:
    plan = given(only("thrust_deadband"))[0]
    n_read, range_m, n = Replay(plan).pushed(())
    simulated = simulate_surge([quiet(plan)])[0]
    assert np.array_equal(range_m, simulated.run.columns["range_m"])
    assert np.array_equal(n_read, simulated.run.columns["n_rev_s"])
    again = Replay(plan).pushed((), n)
    assert again[1] == pytest.approx(range_m, abs=1e-12)
    assert Replay(plan).model(plan.p, n_read, np.zeros(4)) == pytest.approx(range_m, abs=1e-12)


@pytest.mark.parametrize("effect", ["tachometer_bias", "clock_skew", "sonar_latency", "seiche"])
def test_the_model_foretells_sensor_effects(effect: str) -> None:
    plan = given(only(effect).sized([2.0]))[1]
    n_read, range_m, _ = Replay(plan).pushed(())
    # a sonar clock that runs ahead reads ranges of a time when the recorded propeller speed has ended
    inside = slice(0, 1170)
    assert Replay(plan).model(plan.p, n_read, np.zeros(4))[inside] == pytest.approx(range_m[inside], abs=1e-9)


def test_refit_finds_parameters_and_d_vanishes_without_an_effect() -> None:
    case = only("tether", "parameters")
    clean = noise_free(case, given(case))
    fit = refit(clean, load_truth("paper-ii").vector())
    assert fit.size < 0.01
    assert fit.p[0, [slot(name) for name in NUISANCE]] == pytest.approx(
        case.truth.vector()[[slot(name) for name in NUISANCE]], rel=1e-4
    )


def test_d_grows_with_the_effect_and_falls_with_the_noise() -> None:
    case = only("tether").sized([0.05])
    clean = noise_free(case, given(case))
    d = post_refit(case, clean).size
    double = case.sized([0.1])
    assert post_refit(double, noise_free(double, given(double))).size == pytest.approx(2.0 * d, rel=0.1)
    loud = [replace(r, whitener=louder(r.whitener, 3.0)) for r in clean]
    assert post_refit(case, loud).size == pytest.approx(d / 3.0, rel=1e-3)


def louder(w: Whitener, factor: float) -> Whitener:
    """All noise larger by a factor; the tachometer process is scaled by its push, so by its deviation here."""
    deviation = tuple(factor * value for value in w.deviation)
    return replace(w, deviation=deviation, variance=factor**2 * w.variance)  # type: ignore[arg-type]


def test_the_true_effect_leaves_nothing_and_a_rival_something() -> None:
    case = only("supply_sag").sized([1.0])
    clean = noise_free(case, given(case))
    left = post_refit(case, clean)
    own, rival = (best_fit([BY_NAME[name]], clean, left).size for name in ("supply_sag", "coulomb_friction"))
    assert own < 0.02 * left.size < rival <= left.size
    assert list(parameters([BY_NAME["supply_sag"]])) == ["supply_sag.r"]


def test_sizes_are_solved_for_the_wanted_ratio() -> None:
    case, _ = ready_case(21, 0, draw_frequencies(21, ("single",), ("linear_drag",)), familiar=True)
    d = post_refit(case, noise_free(case, given(case))).size
    assert d == pytest.approx(case.wanted[0], rel=0.3) or case.causes[0].size == case.causes[0].largest


@pytest.mark.parametrize("law", OUTSIDE.values(), ids=OUTSIDE)
def test_outside_laws_do_nothing_at_size_zero_and_something_at_size_one(law) -> None:  # type: ignore[no-untyped-def]
    assert law.name not in BY_NAME and (law.push is None) != (law.distort is None)
    plan = given(only(law.name, "outside"))[0]
    n, range_m = 10.0 * np.sin(0.3 * np.arange(300)), 3.0 + 0.3 * np.sin(0.03 * np.arange(300))
    for size in (0.0, 1.0):
        passenger = Passenger(law, size, plan)
        pushed = [passenger.push(0.1, 0.2 * math.sin(0.05 * k), float(n[k])) for k in range(300)]
        written = passenger.record(n, range_m)
        changed = any(pushed) or not (np.array_equal(written[0], n) and np.array_equal(written[1], range_m))
        assert changed == (size > 0.0)


def test_an_outside_push_moves_the_hull_as_its_catalogue_twin_would() -> None:
    """Cubic drag written as an outside law, against quadratic drag that is equal at one speed: both slow the hull."""
    case = only("cubic_drag", "outside")
    plan = given(case)[0]
    pushed, plain = Replay(plan), Replay(plan)
    n = plain.pushed(())[2]
    with_law = pushed.pushed(case.causes, n)[1]
    sight = Sight(0.1, 0.0, 0.3, 0.0, 10.0, -2.5, 5e-4)
    assert OUTSIDE["cubic_drag"].push(2.0, sight, {}) == pytest.approx(-2.0 * 5.0 * 0.027)  # type: ignore[misc]
    assert np.ptp(with_law) < np.ptp(plain.pushed((), n)[1])
    assert passengers(plan, case.causes)[0].law.name == "cubic_drag"


def test_held_out_runs_repeat_the_given_ones() -> None:
    case = only("seiche")
    scenarios = case.experiment.scenarios
    assert scenarios[RUNS : 2 * RUNS] == scenarios[:RUNS] and scenarios[-1].excitation.kind != case.experiment.family
    phases = {case.plan(k).p[slot("seiche.phase")] for k in range(len(scenarios))}
    assert len(phases) == len(scenarios) and null_vector()[slot("seiche.phase")] not in phases


def test_spikes_of_a_plan_are_those_on_record() -> None:
    case = only("tachometer_spikes")
    slots = {"tachometer_spikes.p": 0.03, "tachometer_spikes.size": 4.0}
    plan = replace(given(case)[0], p=vector(slots, case.truth.vector()))
    n_read, _, n = Replay(plan).pushed(())
    spikes = spikes_of(plan)
    assert 0.01 < np.mean(spikes != 0.0) < 0.06
    np.testing.assert_allclose(n_read - n, spikes, atol=1e-12)
    np.testing.assert_allclose(repair(n_read, spikes, 4.0), n, atol=1e-12)
    np.testing.assert_array_equal(repair(n_read, np.zeros_like(n), 4.0), n_read)


@pytest.mark.slow
def test_two_known_effects_leave_no_more_than_the_best_of_them() -> None:
    case = only("cubic_drag", "outside").sized([2.0])
    clean = noise_free(case, given(case))
    left = post_refit(case, clean)
    best = min(best_fit([effect], clean, left).size for effect in others(case))
    pair = best_pair(case, clean, left)
    assert 0.0 < pair["d"] <= best <= left.size and 1 <= len(pair["names"]) <= 2
