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
from vtank.studies.blind.cause import draw_cause
from vtank.studies.blind.experiment import amplitude_m
from vtank.studies.blind.fly import quiet, stalled
from vtank.studies.blind.generator import FAMILIES, LOCAL, Scene, draw_law
from vtank.studies.blind.laws import DELAYED, EVEN, LAGGED, ODD, PLAY, SINE, Factor, Law, N, T, U, aboard, series
from vtank.studies.blind.noise import FAMILIES as NOISES
from vtank.studies.blind.noise import Noise
from vtank.studies.blind.outside import OUTSIDE
from vtank.studies.blind.refit import own_parameters, parameters, refit
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
    assert max(abs(a.causes["single"][name] - b.causes["single"][name]) for name in a.causes["single"]) > 0.01
    assert "thrust_lag" not in a.causes["single"]  # the nominal has a lag of its own
    with pytest.raises(InputError, match="no effect 'drag'"):
        draw_frequencies(1, names=("drag",))


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
    assert label(only("beta", "varying")) == "varying" and label(only("burst", "local")) == "unknown"
    assert label(draw_case(1, 0, 0, draw_frequencies(1, ("triple",)))).count("+") == 2


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
    return np.array(sources).T @ np.array(sources) + np.diag(w.variance)


def test_whitening_is_the_cholesky_factor() -> None:
    random, samples = np.random.default_rng(3), 40
    w = Whitener(random.uniform(0.0, 2.0, samples), random.uniform(0.0, 0.1, samples), (0.05, 0.7, 0.004),
                 (1.5, 0.7, 0.5), random.uniform(1e-6, 1e-4, samples), 0.1)  # fmt: skip
    columns = random.normal(size=(samples, 3))
    expected = np.linalg.solve(np.linalg.cholesky(linear_covariance(w, samples)), columns)
    assert w.whiten(columns) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_whitening_leaves_out_missing_pings() -> None:
    random, samples = np.random.default_rng(4), 30
    w = Whitener(
        np.full(samples, 0.5), np.zeros(samples), (0.05, 0.0, 0.0), (1.5, 0.7, 0.0), np.full(samples, 1e-6), 0.1
    )
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
    own = [slot(name) for name in own_parameters(case.truth.vector())]
    assert fit.p[0, own] == pytest.approx(case.truth.vector()[own], rel=1e-4)


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


SCENE = Scene(load_truth("paper-ii"), 10.0, (120.0, 90.0, 120.0), 2)


def along(law: Law, size: float = 1.0, run: int = 0) -> np.ndarray:
    """What a law adds along a slow oscillation, half a tick not looked ahead."""
    plan, t = replace(given(only("tether"))[0], run=run), 0.1 * np.arange(1200)
    x, u, n = 0.3 * np.sin(0.5 * t), 0.15 * np.cos(0.5 * t), 10.0 * np.sin(0.5 * t + 1.0)
    return series(aboard(plan, [(law, size)], t.size, 0.0, np.inf), x, u, n)  # type: ignore[no-any-return]


def test_factors_do_what_they_say() -> None:
    t = 0.1 * np.arange(1200)
    u, n = 0.15 * np.cos(0.5 * t), 10.0 * np.sin(0.5 * t + 1.0)

    def one(*factors: Factor) -> np.ndarray:
        return along(Law("mine", "force", 2.0, factors=factors), 3.0)

    assert one(Factor(U, 0.1, bent=ODD, c=2.0)) == pytest.approx(6.0 * (u / 0.1) * abs(u / 0.1))
    assert one(Factor(U, 0.1, bent=EVEN, c=0.5), Factor(N, 5.0)) == pytest.approx(6.0 * abs(u / 0.1) ** 0.5 * n / 5.0)
    assert one(Factor(T, 1.0, bent=SINE, c=7.0, w=0.4)) == pytest.approx(6.0 * np.sin(2.0 * np.pi * t / 7.0 + 0.4))
    assert one(Factor(N, 1.0, DELAYED, 1.5))[15:] == pytest.approx(6.0 * n[:-15])
    late = one(Factor(N, 1.0, LAGGED, 2.0))[600:] / 6.0  # a lag of 2 s at 0.5 rad/s: 10 cos(45 deg)
    assert np.ptp(late) / 2.0 == pytest.approx(10.0 / math.sqrt(2.0), rel=0.05)
    play = one(Factor(N, 1.0, PLAY, 4.0)) / 6.0
    assert play.max() == pytest.approx(1.0) and play.min() == pytest.approx(-1.0)
    assert np.sign(play[np.abs(play) > 1.0 - 1e-9]) == pytest.approx(
        np.sign(np.diff(n, prepend=8.0)[np.abs(play) > 1.0 - 1e-9])
    )


def test_a_law_of_some_windows_does_nothing_outside() -> None:
    law = Law("mine", "force", 1.0, windows=(((2.0, 4.0),), ()), swells=True)
    once = along(law)
    assert once[:21] == pytest.approx(0.0) and once[40:] == pytest.approx(0.0)
    assert once[30] == pytest.approx(1.0) and not along(law, run=1).any()


@pytest.mark.parametrize("name", FAMILIES)
def test_laws_are_drawn_again_alike_and_do_something(name: str) -> None:
    drawn = [draw_law(name, np.random.default_rng(seed), SCENE) for seed in (1, 1, 2, 3, 4)]
    assert drawn[0] == drawn[1] and len({str(law) + str(law.windows) for law in drawn}) == 4
    for law in drawn:
        assert bool(law.windows) == (name in LOCAL) and (not law.windows or not law.windows[2])
        spans = [span for spans in law.windows for span in spans]
        assert all(0.0 <= a < b <= 120.0 for a, b in spans)
        acted = sum(float(np.abs(along(law, run=run)).max()) for run in (0, 1))
        assert law.stalls or 0.0 < acted < 1e3 * abs(law.unit)
        assert not along(law, 0.0).any()


@pytest.mark.parametrize("law", OUTSIDE.values(), ids=OUTSIDE)
def test_outside_laws_do_nothing_at_size_zero_and_something_at_size_one(law: Law) -> None:
    assert law.name not in BY_NAME
    assert not along(law, 0.0).any() and np.ptp(along(law)) > 0.0


def test_a_push_balances_the_thrust_with_the_drag() -> None:
    """At a steady propeller speed the hull settles where beta n^2 = |alpha| u^2 + 4 x 0.04 m/s2 (u/(0.2 m/s))^3."""
    case = only("cubic_drag", "outside").sized([4.0])
    replay = Replay(given(case)[0])
    replay.pushed(case.causes, np.full(1201, 12.0))
    u = replay.motion[1, 1000]
    drag = abs(case.truth.alpha_per_m) * u**2 + 0.16 * (u / 0.2) ** 3
    assert drag == pytest.approx(case.truth.beta_m_per_rev2 * 144.0, rel=1e-6) and u > 0.05


def test_a_stalled_sensor_repeats_its_last_reading() -> None:
    read = np.array([1.0, 2.0, np.nan, 4.0, 5.0])
    found = stalled(read, np.array([False, False, True, True, False]))
    assert found == pytest.approx([1.0, 2.0, np.nan, 2.0, 5.0], nan_ok=True)


@pytest.mark.parametrize("family", NOISES)
def test_noise_of_every_family_has_unit_deviation(family: str) -> None:
    share, values = NOISES[family]
    noise = Noise(family, **values(np.random.default_rng(1)))
    drawn = noise.unit(np.random.default_rng(2), 200_000, 0.1)
    assert share > 0.0 and np.std(drawn) == pytest.approx(1.0, rel=0.1)
    assert noise.blocks(np.random.default_rng(3), 3000, 0.1).mean() == pytest.approx(noise.lost, abs=0.02)
    assert noise.growth(0.0, 0.0) == 1.0


def test_own_parameters_that_vary_are_found_by_d_and_differ_from_run_to_run() -> None:
    case = only("beta", "varying")
    gains = {plan.p[slot("beta")] for plan in given(case)}
    assert len(gains) > 1 and {plan.p[slot("alpha")] for plan in given(case)} == {case.truth.alpha_per_m}
    assert post_refit(case, noise_free(case, given(case))).size > 1.0
    alike = case.sized([0.0])
    assert post_refit(alike, noise_free(alike, given(alike))).size < 0.01


def test_held_out_runs_repeat_the_given_ones() -> None:
    case = only("seiche")
    scenarios = case.experiment.scenarios
    assert scenarios[4:6] == scenarios[:2] and scenarios[-1].excitation.kind != case.experiment.family
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
