"""The likelihood on many seeds of the paper's experiments, a small edition of `vtank identify --monte-carlo 400`."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.stats import binom, chi2
from synthetic import observed, sine

import vtank.cli as cli
from vtank.estimate.cramer_rao import cramer_rao, rounded_variance
from vtank.plant.parameters import vector
from vtank.studies.design.montecarlo import monte_carlo, trials_sheet

SEEDS = 60
EXACT_TACHOMETER = ("tachometer.noise_rev_s=0",)


@pytest.mark.slow
def test_model_ii_on_its_own_truth():
    """Unbiased within 1 %, intervals that cover, and no more variance than the bound allows."""
    t = monte_carlo("paper-ii", "II", SEEDS, settings=EXACT_TACHOMETER)
    assert np.all(np.abs(t.bias / t.true) < 0.01)
    assert np.all(np.abs(t.bias) < 4 * t.claimed.mean(axis=0) / np.sqrt(SEEDS))
    assert np.all(t.coverage * SEEDS >= binom.ppf(1e-4, SEEDS, 0.95))
    low, high = chi2.ppf([1e-4, 1 - 1e-4], SEEDS - 1) / (SEEDS - 1)
    assert np.all((low < t.variance_over_bound) & (t.variance_over_bound < high))
    assert np.all((low < t.variance_over_claim) & (t.variance_over_claim < high))
    assert t.disturbed <= 1 and t.correlation[0, 1] == pytest.approx(-0.93, abs=0.05)


@pytest.mark.slow
def test_noise_of_the_tachometer_is_taken_for_what_it_does():
    """It disturbs the thrust that the model believes in: found as process noise, and the intervals still cover."""
    t = monte_carlo("paper-ii", "II", 12)
    assert t.disturbed >= 9
    assert np.all(np.mean(((t.found - t.true) / t.claimed) ** 2, axis=0) < chi2.ppf(1 - 1e-4, 12) / 12)
    assert np.all(t.claimed.mean(axis=0) > 1.05 * t.bound.mean(axis=0))


@pytest.mark.slow
def test_model_iii_on_its_own_truth():
    t = monte_carlo("paper-iii", "III", 12, settings=EXACT_TACHOMETER)
    assert np.all(np.mean(((t.found - t.true) / t.claimed) ** 2, axis=0) < chi2.ppf(1 - 1e-4, 12) / 12)
    assert abs(t.correlation[1, 2]) > 0.8  # beta and gamma


def test_trials_are_the_same_again_and_in_the_tank():
    first, again = (monte_carlo("paper-ii", "II", 2, settings=EXACT_TACHOMETER, seed=5) for _ in range(2))
    np.testing.assert_array_equal(first.found, again.found)
    settings = (*EXACT_TACHOMETER, "hold=rigid", "duration_s=30")
    tank = monte_carlo("paper-ii", "II", 2, "tank", settings, seed=5)
    surge = monte_carlo("paper-ii", "II", 2, "surge", settings, seed=5)
    assert np.all(np.abs(tank.found - surge.found) < 0.1 * tank.claimed)


def test_command(tmp_path, capsys):
    out = tmp_path / "trials.json"
    assert cli.main(["identify", "--monte-carlo", "3", "--set", "duration_s=30", "--json", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "Model II on 3 seeds" in shown and "coverage %" in shown
    assert [row["parameter"] for row in json.loads(out.read_text())["rows"]] == ["alpha", "beta", "tau"]


def test_the_sheet_states_the_ratios():
    t = monte_carlo("paper-ii", "I", 3, settings=(*EXACT_TACHOMETER, "duration_s=30"))
    row = trials_sheet(t).rows[0]
    assert row[0] == "alpha" and float(row[2]) == pytest.approx(100 * t.bias[0] / abs(t.true[0]), abs=1e-3)
    assert float(row[5]) == pytest.approx(100 * t.coverage[0], abs=0.1)


# --- the bound -------------------------------------------------------------------------------------------------------


def test_bound_of_a_drift():
    """Hull without drag under a constant push: x is a parabola in t, and the bound that of its coefficients."""
    p = vector({"beta": 5e-4})
    run = observed(p, lambda t: np.full_like(t, 3.0), duration_s=10.0)
    t = run.time_s
    design = np.column_stack([4.5 * t**2, np.ones_like(t), t])  # beta n|n| t^2 / 2 with n = 3
    expected = 0.01**2 * np.linalg.inv(design.T @ design)[0, 0]
    assert cramer_rao([run], p, ("beta",), 0.01**2)[0, 0] == pytest.approx(expected, rel=1e-4)


def test_bound_falls_with_the_noise_and_with_the_number_of_runs():
    p = vector({"alpha": -2.5, "beta": 5e-4, "thrust_lag.tau": 0.7})
    run, free = observed(p, sine(15.0, 0.5)), ("alpha", "beta", "thrust_lag.tau")
    one, two = cramer_rao([run], p, free, 1e-4), cramer_rao([run, run], p, free, 1e-4)
    np.testing.assert_allclose(two, one / 2, rtol=1e-6)
    np.testing.assert_allclose(cramer_rao([run], p, free, 4e-4), 4 * one, rtol=1e-6)


def test_variance_of_a_rounded_reading():
    rng = np.random.default_rng(0)
    reading = rng.uniform(0.0, 10.0, 200_000)
    error = np.round(reading + 0.006 * rng.standard_normal(reading.size), 2) - reading
    assert np.var(error) == pytest.approx(rounded_variance(0.006, 0.01), rel=0.02)
