"""Station keeping in waves: still water, slow waves, fast sinusoids, tables, and what is held."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import Plan, plan_run, simulate_surge, simulate_tank
from vtank.experiment.scenario import Scenario, load_scenario
from vtank.present.document import plain
from vtank.studies.bandwidth.bounds import (
    drift_bound_m,
    standing_still_rev_s,
    thrust_bound_m,
    water_speed,
)
from vtank.studies.bandwidth.report import response_table, station_csv, station_tables
from vtank.studies.bandwidth.response import Response
from vtank.studies.bandwidth.station import Stations, held_height, keep_station, possible, station_plan
from vtank.units import G_M_S2
from vtank.waves import Waves, breaking_height

QUIET = ("sonar.noise_m=0", "sonar.resolution_m=0", "sonar.width_deg=0", "tachometer.noise_rev_s=0")


def scenario(*settings: str) -> Scenario:
    return load_scenario("station-keeping", settings)


def quiet_error_m(plan: Plan, speed_m_s: float) -> float:
    """Error at which the controller holds the hull in a steady current U [m], without noise.

    The demand c that balances drag follows from (beta/beta_c) c^2/(c + c_0) = |alpha| U^2, and the error is c over the
    position gain.
    """
    gains = plan.scenario.control
    ratio = plan.thrust_m_per_rev2 / plan.truth.beta_m_per_rev2
    needed = -plan.truth.alpha_per_m * speed_m_s**2 * ratio
    blunt = plan.thrust_m_per_rev2 * gains.blunt_rev_s**2
    return float(0.5 * (needed + np.sqrt(needed**2 + 4.0 * needed * blunt)) / gains.position_per_s2)


@pytest.mark.parametrize("waves", ["waves.significant_height_m=0", "waves={kind='none'}"])
def test_in_still_water_the_station_is_kept_exactly(waves: str) -> None:
    """Exactly nothing with the other axes held; with them free, rounding of weight and buoyancy tilts the hull."""
    for simulate in (simulate_tank, simulate_surge):
        (result,) = simulate([plan_run(scenario(*QUIET, waves, "duration_s=30", "hold=rigid"))])
        assert not result.true["position_m"].any() and not result.true["n_rev_s"].any()
    (free,) = simulate_tank([plan_run(scenario(*QUIET, waves, "duration_s=30"))])
    assert np.abs(free.true["position_m"]).max() < 1e-15 and np.abs(free.true["n_rev_s"]).max() < 1e-12


def test_waves_of_no_height_change_no_bit() -> None:
    flat, none = (scenario(w, "duration_s=20") for w in ("waves.significant_height_m=0", "waves={kind='none'}"))
    for simulate in (simulate_tank, simulate_surge):
        one, other = simulate([plan_run(flat), plan_run(none)])
        for name, values in other.true.items():
            np.testing.assert_array_equal(one.true[name], values)
        assert other.true["n_rev_s"].any()


@pytest.mark.parametrize("period", [2.5, 6.0])
def test_a_regular_wave_is_the_seiche_of_its_frequency(period: float) -> None:
    """The seiche's sinusoid is evaluated at every instant; the waves are linear between ticks: 1 mm in 0.3 m."""
    height, water, depth = 0.3, 4.0, 1.0
    wave = f"waves={{kind='regular',height_m={height},period_s={period},water_depth_m={water}}}"
    speed, w = water_speed(height, period, water, depth), 2.0 * np.pi / period
    seiche = {"seiche.amplitude": speed, "seiche.frequency": w, "seiche.phase": 0.5 * np.pi}
    shared = (*QUIET, f"depth_m={depth}", "hold=rigid", "duration_s=60")
    waving = scenario(*shared, wave)
    swaying = replace(waving, waves=Waves(), effects=seiche)
    for simulate in (simulate_tank, simulate_surge):
        one, other = simulate([plan_run(waving), plan_run(swaying)])
        assert np.ptp(other.true["position_m"]) > 0.3
        np.testing.assert_allclose(one.true["position_m"], other.true["position_m"], rtol=0, atol=1.5e-3)


def test_seas_do_not_depend_on_company_or_threads() -> None:
    waves = "waves={kind='irregular',significant_height_m=0.4,peak_period_s=5,water_depth_m=9,reflection=0.5}"
    plans = [plan_run(scenario(each, "duration_s=12"), run=i) for i, each in enumerate((waves, "seed=3", waves))]
    plans.append(plan_run(load_scenario("sway", ["duration_s=12", waves, "walls=sea"]), run=3))
    alone = [simulate_tank([each])[0] for each in plans]
    for one, other in zip(alone, simulate_tank(plans, 2), strict=True):
        assert one.true.keys() == other.true.keys()
        for name, values in one.true.items():
            np.testing.assert_array_equal(values, other.true[name])
    assert np.abs(alone[0].true["water_m_s"] - alone[2].true["water_m_s"]).max() > 0.02  # each run a sea of its own


def slow(height: float) -> str:
    """A wave so slow that the water's acceleration counts for nothing, over 2 m of water."""
    return f"waves={{kind='regular',height_m={height},period_s=2400,water_depth_m=2}}"


@pytest.mark.parametrize("simulate", [simulate_tank, simulate_surge])
@pytest.mark.slow
def test_in_slow_waves_thrust_balances_drag(simulate) -> None:  # type: ignore[no-untyped-def]
    """n = sqrt(|alpha|/beta)|U| and the error is the demand over the position gain, all through the slow cycle."""
    still = ("depth_m=1", "hold=rigid", "duration_s=800", "period_s=0.1")
    plan = plan_run(scenario(*QUIET, slow(0.1), *still))
    (result,) = simulate([plan])
    assert result.true["water_m_s"][0] == pytest.approx(0.05 * np.sqrt(G_M_S2 / 2.0), rel=1e-3)
    later = result.run.time_s > 100.0
    u, x, n = (result.true[name][later] for name in ("water_m_s", "position_m", "n_rev_s"))
    drag = plan.truth.alpha_per_m * np.abs(u) * u
    thrust = plan.truth.beta_m_per_rev2 * np.abs(n) * n
    np.testing.assert_allclose(thrust, drag, rtol=0, atol=0.015 * np.abs(drag).max())  # dU/dt is 1 % of the drag
    error = np.sign(u) * [quiet_error_m(plan, abs(speed)) for speed in u]
    strong = np.abs(u) > 0.3 * np.abs(u).max()
    np.testing.assert_allclose(x[strong], error[strong], rtol=0.05)
    assert np.sqrt(np.mean(x * x)) == pytest.approx(np.sqrt(np.mean(error * error)), rel=0.01)


def test_tank_and_surge_model_keep_the_station_alike() -> None:
    """With all axes free in the tank: heave and pitch move the range by little. Measured over the grid: 0.5 %."""
    grid = {"water_depth_m": (8.0,), "height_m": (0.3,), "period_s": (4.0, 8.0)}
    tank, surge = (keep_station(scenario(), "regular", model=model, **grid) for model in ("tank", "surge"))
    np.testing.assert_allclose(tank.rms_m, surge.rms_m, rtol=0.02)
    np.testing.assert_allclose(tank.at_limit, surge.at_limit, atol=0.03)


def test_worse_seas_carry_the_hull_further_and_depth_shelters() -> None:
    sea = keep_station(scenario(), "irregular", (4.0, 16.0), (0.1, 0.3, 1.0), (4.0, 8.0), model="surge")
    assert (np.diff(sea.rms_m, axis=1) > 0.0).all() and (sea.rms_m[1] < sea.rms_m[0]).all()
    assert (np.diff(sea.at_limit, axis=1) >= 0.0).all()
    held = sea.held_height_m()
    assert held.shape == (2, 2) and (held[1] > held[0]).all()
    assert sea.burden[0, 2, 1] > 1.0 > sea.burden[0, 0, 1]


def test_waves_that_break_or_bare_the_vehicle_are_left_out() -> None:
    assert not possible(Waves("regular", 1.01 * breaking_height(2.0, 8.0), 2.0, 8.0), 4.0)
    assert possible(Waves("regular", 0.99 * breaking_height(2.0, 8.0), 2.0, 8.0), 4.0)
    sea = keep_station(scenario(), "regular", (8.0,), (0.1, 1.2), (2.0,), model="surge")
    assert np.isfinite(sea.rms_m[0, 0, 0]) and np.isnan(sea.rms_m[0, 1, 0])
    assert len(station_csv([sea]).splitlines()) == 2


def test_a_hull_thrown_on_the_wall_is_not_held() -> None:
    feeble = scenario("n_limit_rev_s=1", "standoff_m=0.5")
    sea = keep_station(feeble, "regular", (4.0,), (1.0,), (12.0,), model="surge")
    assert np.isinf(sea.rms_m[0, 0, 0]) and np.isnan(sea.held_height_m()[0, 0])


def test_theory_bounds_in_their_limits() -> None:
    plan = plan_run(scenario(*QUIET))
    truth = plan.truth
    slowly = standing_still_rev_s(plan, 0.1, 1e6)
    assert slowly == pytest.approx(np.sqrt(-truth.alpha_per_m / truth.beta_m_per_rev2) * 0.1, rel=1e-3)
    w, speed = 2.0 * np.pi / 3.0, 1e-5  # no drag: beta n^2 = U w sqrt(1 + (w tau)^2)
    quick = np.sqrt(speed * w * np.hypot(1.0, w * truth.tau_s) / truth.beta_m_per_rev2)
    assert standing_still_rev_s(plan, speed, 3.0) == pytest.approx(quick, rel=1e-3)
    assert water_speed(0.2, 600.0, 5.0, 2.5) == pytest.approx(0.1 * np.sqrt(G_M_S2 / 5.0), rel=1e-4)
    for period in (4.0, 9.0):
        height = thrust_bound_m(plan, period, 8.0, 4.0)
        needed = standing_still_rev_s(plan, water_speed(height, period, 8.0, 4.0), period)
        assert needed == pytest.approx(plan.n_limit_rev_s, rel=1e-4)
    assert thrust_bound_m(plan, 1.5, 100.0, 50.0) == breaking_height(1.5, 100.0)
    excursion = water_speed(drift_bound_m(0.3, 7.0, 8.0, 4.0), 7.0, 8.0, 4.0) * 7.0 / (2.0 * np.pi)
    assert excursion == pytest.approx(0.3)


def test_held_heights_between_what_was_tried() -> None:
    height = np.array([0.1, 0.2, 0.4])
    assert held_height(height, np.array([0.2, 0.6, 1.4])) == pytest.approx(0.3)
    assert held_height(height, np.array([0.2, 0.6, np.nan])) == 0.2
    assert np.isnan(held_height(height, np.array([1.2, 1.6, 2.0])))
    assert np.isnan(held_height(height, np.full(3, np.nan)))


def test_a_plan_keeps_vehicle_sensors_and_seed() -> None:
    base = load_scenario("bluerov2-surge")
    plan = station_plan(base, Waves("irregular", 0.2, 5.0, 8.0), 4.0, run=3)
    kept = plan.scenario
    assert (kept.vehicle, kept.sonar, kept.control, plan.seed, plan.run) == (
        "bluerov2",
        base.sonar,
        base.control,
        1996,
        3,
    )
    assert (kept.depth_m, kept.walls, kept.excitation.kind) == (4.0, "sea", "station")


WRONG = {
    "height_m=0.3": "waves.kind: missing",
    "kind='regular',period_s=5": "waves.height_m: missing",
    "kind='regular',height_m=0.3,peak_period_s=5": "waves.period_s: missing",
    "kind='regular',height_m=2.5,period_s=3,water_depth_m=20": "break from",
    "kind='regular',height_m=0.3,period_s=5,water_depth_m=3": "more than the vehicle's depth_m of 4 m",
    "kind='irregular',significant_height_m=4.5,peak_period_s=20,water_depth_m=40": "well below",
    "kind='irregular',significant_height_m=1,peak_period_s=7,reflection=1.5": "from 0 to 1",
    "kind='swell',height_m=1": "none, regular, irregular",
}


@pytest.mark.parametrize("waves", WRONG)
def test_a_wrong_sea_is_told(waves: str) -> None:
    with pytest.raises(InputError, match=WRONG[waves]):
        scenario(f"waves={{{waves}}}")


def stations() -> Stations:
    error = np.array([[[0.1, np.nan], [0.4, np.nan]]])
    axes = (np.array([5.0]), np.array([0.2, 0.4]), np.array([4.0, 8.0]))
    return Stations("regular", *axes, error, error, np.where(np.isnan(error), np.nan, 0.0), error, error)


def test_tables_for_reading() -> None:
    text = plain(*station_tables(stations()))
    assert "0.33" in text and "< 0.2" in text and "Regular waves" in text
    one = np.ones((1, 2))
    measured = Response(
        np.array([0.1]), np.array([0.5, 1.0]), np.array([[1.0 + 0j, 0.5j]]), np.array([[0.0, 0.9]]), one, one, one
    )
    assert "0.50   +90*" in plain(response_table(measured)) and "-3 dB at" in plain(response_table(measured))


@pytest.mark.slow
def test_the_command_writes_tables_and_figures(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    fits: Callable[[Path], bool],
) -> None:
    from vtank.studies.bandwidth import response, station

    monkeypatch.setattr(response, "FREQUENCIES_RAD_S", W := np.array([0.8, 1.3, 2.0]))
    monkeypatch.setattr(response.sweep, "__defaults__", (response.AMPLITUDES_M, W, None, 1, None))
    small = ((4.0, 8.0), (0.1, 0.5), (4.0, 8.0), None, "tank", 1, None)
    monkeypatch.setattr(station.keep_station, "__defaults__", small)
    arguments = ["--out", str(tmp_path), "--amplitude", "0.2", "--amplitude", "0.1", "--seas", "surge"]
    assert main(["bandwidth", "paper-ds1", *arguments]) == 0
    out = capsys.readouterr().out
    assert "limit from" in out and "Irregular waves" in out
    rows = list(csv.DictReader((tmp_path / "response.csv").open()))
    assert len(rows) == 6 and {row["amplitude_m"] for row in rows} == {"0.1", "0.2"}
    assert 0.0 < float(rows[0]["gain"]) < 2.0
    seas = list(csv.DictReader((tmp_path / "seas.csv").open()))
    assert {row["kind"] for row in seas} == {"regular", "irregular"} and len(seas) == 16
    for name in ("response.png", "seas.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG") and (tmp_path / name).stat().st_size > 20000
    assert "waves in 8 m of water" in (tmp_path / "bandwidth.html").read_text() and fits(tmp_path / "bandwidth.html")
    assert main(["bandwidth", "paper-ds1", "--amplitude", "0"]) == 2
    assert main(["bandwidth", "paper-ds1", "--threads", "0"]) == 2
    assert main(["bandwidth", "sway", "--only", "seas", "--seas", "surge", "--set", "depth_m=x"]) == 2
