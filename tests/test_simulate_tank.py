"""Runs in the tank: agreement with the surge model, company, threads, stand-off and every scenario with every truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from vtank.effects.catalogue import CATALOGUE
from vtank.effects.effect import Parameter
from vtank.errors import InputError
from vtank.experiment import Plan, Result, plan_run, simulate_surge, simulate_tank, tank_model
from vtank.experiment.scenario import load_scenario, scenario_names
from vtank.plant.truth import truth_names

SONAR_NOISE_M = 0.006
PAPER = [f"paper-ds{i}" for i in (1, 2, 3, 4)]


def plan(name: str, *settings: str, run: int = 0, truth: str | None = None) -> Plan:
    return plan_run(load_scenario(name, settings), run, truth=truth)


def same(a: Result, b: Result) -> None:
    for name in a.run.columns:
        np.testing.assert_array_equal(a.run.columns[name], b.run.columns[name])
    for name in a.true:
        np.testing.assert_array_equal(a.true[name], b.true[name])


def test_every_scenario_walks_with_every_truth_of_its_vehicle() -> None:
    truths = {"bluerov2": ["bluerov2"], "phoenix": [name for name in truth_names() if name != "bluerov2"]}
    scenarios = [load_scenario(name, ["duration_s=8"]) for name in scenario_names()]
    for result in simulate_tank([plan_run(s, truth=truth) for s in scenarios for truth in truths[s.vehicle]]):
        result.check_clearance()
        surges = result.plan.scenario.excitation.axis == "surge"
        assert np.isfinite(result.run.columns["range_m" if surges else "thrust_N"]).all()
        assert np.ptp(result.true["position_m"] if surges else result.run.columns["position_m"]) > 0.005


@pytest.mark.parametrize("noise", [(), ("sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0")])
def test_tank_and_surge_model_agree_to_a_hundredth_of_the_sonar_noise(noise: tuple[str, ...]) -> None:
    """With the other axes held, over the four experiments of 120 s, closed loop; measured: 6e-7 m."""
    plans = [plan(name, "hold=rigid", *noise, run=i) for i, name in enumerate(PAPER)]
    for tank, surge in zip(simulate_tank(plans), simulate_surge(plans), strict=True):
        for channel in ("position_m", "range_m"):
            np.testing.assert_allclose(tank.true[channel], surge.true[channel], rtol=0, atol=0.01 * SONAR_NOISE_M)
        np.testing.assert_allclose(tank.true["n_rev_s"], surge.true["n_rev_s"], rtol=0, atol=1e-3)


def test_they_agree_with_every_kind_of_effect_switched_on() -> None:
    effects = [
        "linear_drag.c_per_s=0.2",
        "ambient_current.U_m_s=0.03",
        "seiche.amplitude_m_s=0.03",
        "wall_proximity.mass=0.1",
        "wall_proximity.drag=0.3",
        "tether.k_per_s2=0.01",
        "wake_memory.k=0.3",
        "thrust_deadband.n0_rev_s=1",
        "supply_sag.r_per_s=0.003",
        "command_delay.d_s=0.234",
        "sonar_latency.d_s=0.15",
        "sonar_multipath.p=0.05",
        "clock_skew.s=0.003",
        "tachometer_bias.b_rev_s=0.5",
    ]
    shared = ("hold=rigid", "duration_s=40", "turbulence.acceleration_m_s2=0.003")
    plans = [plan("open-loop-sine", *shared, f"effects.{effect}", run=i) for i, effect in enumerate(effects)]
    for tank, surge in zip(simulate_tank(plans), simulate_surge(plans), strict=True):
        np.testing.assert_allclose(tank.true["position_m"], surge.true["position_m"], rtol=0, atol=0.01 * SONAR_NOISE_M)


@pytest.mark.parametrize("simulate", [simulate_tank, simulate_surge])
def test_effects_at_their_null_values_change_no_bit(simulate: Callable[[list[Plan]], list[Result]]) -> None:
    plain = plan("paper-ds1", "duration_s=8")
    null = [f"effects.{e.name}.{q.key}={null_or_idle(q)}" for e in CATALOGUE for q in e.parameters if e.name not in OWN]
    assert len(null) > 20
    same(*simulate([plain, plan("paper-ds1", "duration_s=8", *null)]))


OWN = ("thrust_lag", "thrust_loss")  # what the truth presets have values of their own for


def null_or_idle(parameter: Parameter) -> float:
    """The null value, or for a parameter without influence there, another."""
    return parameter.scale if parameter.shape else parameter.null


def test_with_thrusters_the_hull_stays_near_depth_and_heading() -> None:
    for tank in simulate_tank([plan(name, run=i) for i, name in enumerate(PAPER)]):
        assert np.abs(tank.true["depth_m"] - 0.9144).max() < 0.01
        assert np.abs(tank.true["pitch_rad"]).max() < np.radians(1.0)
        assert np.abs(tank.true["pitch_rad"]).max() > 0.0
        assert max(np.abs(tank.true[name]).max() for name in ("sway_m", "roll_rad", "heading_rad")) < 1e-9


def test_runs_do_not_depend_on_company_or_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    extra = ("effects.command_delay.d_s=0.07", "sonar.dropout=0.1", "effects.clock_skew.s=0.01", "sonar.width_deg=0")
    plans = [plan("paper-ds3", "duration_s=6", *extra[i % 5 : i % 5 + 1], run=i) for i in range(9)]
    alone = [simulate_tank([each])[0] for each in plans]
    for chunk, threads in ((64, 1), (64, 2), (2, 2)):
        monkeypatch.setattr(tank_model, "CHUNK", chunk)
        for one, other in zip(alone, simulate_tank(plans, threads), strict=True):
            same(one, other)


def test_stand_off_moves_the_tank_and_nothing_else() -> None:
    settings = ("duration_s=10", "sonar.noise_m=0", "sonar.resolution_m=0")
    far, near = simulate_tank([plan("open-loop-sine", *settings, f"standoff_m={s}") for s in (3.048, 2.0)])
    np.testing.assert_array_equal(far.true["position_m"], near.true["position_m"])
    np.testing.assert_allclose(far.true["range_m"] - near.true["range_m"], 1.048, rtol=0, atol=1e-12)
    assert far.run.columns["range_m"][0] == pytest.approx(3.048)


def test_a_sector_beam_reads_the_wall_ahead_from_its_own_place() -> None:
    settings = ("duration_s=10", "hold=rigid", "sonar.noise_m=0", "sonar.resolution_m=0", "sonar.width_deg=24")
    (sector,) = simulate_tank([plan("open-loop-sine", *settings, "sonar.beam=sector")])
    np.testing.assert_allclose(sector.true["range_m"], 3.048 - sector.true["position_m"], rtol=0, atol=1e-9)


def test_progress_grows_to_one() -> None:
    shares: list[float] = []
    simulate_tank([plan("paper-ds1", "duration_s=2"), plan("paper-ds1", "duration_s=3")], progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == pytest.approx(1.0) and len(shares) > 10


def test_a_depth_below_the_floor_is_told() -> None:
    with pytest.raises(InputError, match="paper-ds1.toml: depth_m"):
        simulate_tank([plan("paper-ds1", "duration_s=2", "depth_m=5")])
