"""Runs on the surge model: order and company do not matter, steps are short enough, delays are exact."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import advance

from vtank.errors import InputError
from vtank.experiment import Plan, Result, plan_run, simulate_surge, surge_model
from vtank.experiment.scenario import load_scenario, scenario_names
from vtank.plant.truth import truth_names

QUIET = ("sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0")


def plan(name: str, *settings: str, run: int = 0, seed: int | None = None, truth: str | None = None) -> Plan:
    return plan_run(load_scenario(name, settings), run, seed, truth)


def same(a: Result, b: Result) -> None:
    for name in a.run.columns:
        np.testing.assert_array_equal(a.run.columns[name], b.run.columns[name])
    for name in a.true:
        np.testing.assert_array_equal(a.true[name], b.true[name])


def of_the_phoenix() -> list[str]:
    """Scenarios in which the Phoenix surges in the test tank."""
    scenarios = map(load_scenario, scenario_names())
    return [s.name for s in scenarios if (s.vehicle, s.walls, s.excitation.axis) == ("phoenix", "basin", "surge")]


@pytest.mark.parametrize("truth", [truth for truth in truth_names() if not truth.startswith("bluerov2")])
@pytest.mark.parametrize("name", of_the_phoenix())
def test_every_scenario_keeps_clear_of_the_walls_with_every_truth(name: str, truth: str) -> None:
    (result,) = simulate_surge([plan(name, truth=truth)])
    result.check_clearance()
    assert np.isfinite(result.run.columns["range_m"]).all()
    assert np.ptp(result.true["position_m"]) > 0.1
    assert np.abs(result.true["n_rev_s"]).max() <= 20.0


def test_runs_do_not_depend_on_company_or_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    noisy = ("sonar.dropout=0.1", "turbulence.acceleration_m_s2=0.005", "effects.clock_skew.s=0.01")
    plans = [plan("paper-ds3", f"duration_s={20 + 3 * (i % 3)}", *noisy[: i % 4], run=i) for i in range(11)]
    alone = [simulate_surge([each])[0] for each in plans]
    monkeypatch.setattr(surge_model, "CHUNK", 3)
    for results in (simulate_surge(plans), simulate_surge(plans, nthread=2), simulate_surge(plans[::-1])[::-1]):
        for one, other in zip(alone, results, strict=True):
            same(one, other)


def test_seed_and_run_number_choose_the_noise() -> None:
    ranges = [
        simulate_surge([plan("paper-ds1", "duration_s=20", run=run, seed=seed)])[0].run.columns["range_m"]
        for seed, run in [(1, 0), (1, 0), (1, 1), (2, 0)]
    ]
    np.testing.assert_array_equal(ranges[0], ranges[1])
    assert (ranges[0] != ranges[2]).mean() > 0.2 and (ranges[0] != ranges[3]).mean() > 0.2


@pytest.mark.parametrize("truth", ["paper-ii", "physical"])
@pytest.mark.parametrize("name", ["paper-ds1", "paper-ds3", "paper-ds4"])
def test_the_step_is_short_enough(name: str, truth: str) -> None:
    (coarse,), (fine,) = (
        simulate_surge([plan(name, *QUIET, truth=truth)], step_s=h) for h in (surge_model.STEP_S, 0.002)
    )
    np.testing.assert_allclose(coarse.true["position_m"], fine.true["position_m"], rtol=0, atol=1e-6)


def test_the_record_follows_the_surge_equation_under_the_held_speed() -> None:
    (result,) = simulate_surge([plan("paper-ds1", "duration_s=30", "turbulence.acceleration_m_s2=0")])
    x = u = z = wake = 0.0
    for k, n in enumerate(result.true["n_rev_s"]):
        assert x == pytest.approx(result.true["position_m"][k], abs=1e-12)
        for j in range(2):
            x, u, z, wake = advance(0.1 * k + 0.05 * j, 0.05, x, u, z, wake, n, 0.0, result.plan.p)


@pytest.mark.parametrize("delay", [0.1, 0.3, 0.26])
def test_a_command_delay_shifts_the_motion_and_not_the_record(delay: float) -> None:
    t = np.arange(200) * 0.1
    settings = (*QUIET, "duration_s=40")
    (late,), (plain,) = (
        simulate_surge([plan("open-loop-sine", *settings, f"effects.command_delay.d_s={d}")]) for d in (delay, 0.0)
    )
    np.testing.assert_array_equal(late.run.columns["n_rev_s"], plain.run.columns["n_rev_s"])
    whole = int(np.floor(delay / 0.1 + 1e-9))
    moved, still = late.true["position_m"], plain.true["position_m"]
    assert not moved[: whole + 1].any()
    if delay == pytest.approx(0.1 * whole):
        np.testing.assert_allclose(moved[whole : whole + t.size], still[: t.size], rtol=0, atol=1e-9)
    else:
        fraction = delay / 0.1 - whole
        before, after = still[: t.size], np.concatenate([[0.0], still[: t.size - 1]])
        between = (1.0 - fraction) * before + fraction * after
        np.testing.assert_allclose(moved[whole : whole + t.size], between, rtol=0, atol=2e-4)


def test_turbulence_moves_the_hull() -> None:
    level = 0.01
    still = ("excitation.amplitude_rev_s=0", *QUIET)
    plans = [plan("open-loop-sine", *still, f"turbulence.acceleration_m_s2={level}", run=i) for i in range(40)]
    speed = np.array([result.true["surge_m_s"] for result in simulate_surge(plans)])
    short = speed[:, 3]  # before drag acts: u = a t for a correlation time well above 0.3 s
    assert short.std() == pytest.approx(level * 0.3, rel=0.5)
    assert not simulate_surge([plan("open-loop-sine", *still)])[0].true["surge_m_s"].any()


def test_a_motion_that_struck_a_wall_is_told() -> None:
    settings = ("excitation.amplitude_rev_s=0", "excitation.offset_rev_s=20", "duration_s=60")
    (result,) = simulate_surge([plan("open-loop-sine", *settings)])
    with pytest.raises(InputError, match="open-loop-sine.toml.*hits the wall ahead"):
        result.check_clearance()


def test_truth_tells_all_and_the_run_nothing() -> None:
    (result,) = simulate_surge([plan("paper-ds1", "duration_s=20", "effects.linear_drag.c_per_s=0.2", run=3, seed=8)])
    truth = result.truth()
    assert truth["effects"] == {"linear_drag.c": 0.2} and truth["parameters"]["linear_drag.c"] == 0.2
    assert (truth["truth"], truth["seed"], truth["run_number"]) == ("paper-ii", 8, 3)
    assert set(truth["true"]) == {"n_rev_s", "range_m", "position_m", "surge_m_s"}
    assert set(result.run.columns) == {"n_rev_s", "range_m"}
    assert "true" not in result.truth(channels=False)
    np.testing.assert_allclose(truth["true"]["range_m"] + truth["true"]["position_m"], 3.048)
