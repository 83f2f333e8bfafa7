"""Sonar and tachometer on board: each imperfection does what its key says, and nothing at its null value."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vtank.effects.catalogue import CATALOGUE
from vtank.experiment.flight import RANGE, READING, SPEED, SPEED_READING, Flight, prepare
from vtank.experiment.noise import SONAR
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario
from vtank.experiment.tick import stamp, tick, true_range

TICKS = 6000
STILL = ("duration_s=599.9", "sonar.noise_m=0", "sonar.resolution_m=0", "tachometer.noise_rev_s=0")


def flown(
    settings: tuple[str, ...] = (), history: np.ndarray | None = None, scenario: str = "open-loop-sine"
) -> Flight:
    """A flight past a given history of range and rate, shape (2, K); at rest at 3.048 m unless given."""
    plan = plan_run(load_scenario(scenario, (*STILL, "tachometer.governor_per_s=0", *settings)))
    flight = prepare([plan])
    length = flight.history.shape[2]
    if history is None:
        history = np.vstack([np.full(length, 3.048), np.zeros(length)])
    flight.history[0] = history[:, :length]
    for k in range(length):
        tick(flight, 0, k)
    stamp(flight, 0, plan.scenario.samples)
    return flight


def readings(*settings: str, history: np.ndarray | None = None) -> np.ndarray:
    return flown(settings, history).record[0, READING, :TICKS]


def tachometer(*settings: str) -> np.ndarray:
    flight = flown(settings)
    return (flight.record[0, SPEED_READING] - flight.record[0, SPEED])[:TICKS]


def cubic(t: np.ndarray) -> np.ndarray:
    """A range and its rate that are cubic in time."""
    c = (3.0, -0.02, 3e-5, -2e-8)
    return np.vstack(
        [np.polynomial.polynomial.polyval(t, c), np.polynomial.polynomial.polyval(t, (c[1], 2 * c[2], 3 * c[3]))]
    )


def share(events: np.ndarray, probability: float) -> None:
    """Assert a share of independent events within four standard deviations."""
    assert events.mean() == pytest.approx(
        probability, abs=4.0 * math.sqrt(probability * (1 - probability) / events.size)
    )


def test_a_perfect_sonar_and_tachometer_read_what_is() -> None:
    history = cubic(np.arange(TICKS) * 0.1)
    np.testing.assert_array_equal(readings(history=history), history[RANGE])
    assert not tachometer().any()


def test_range_between_ticks_is_exact_for_a_cubic_motion() -> None:
    flight = flown(history=cubic(np.arange(TICKS) * 0.1))
    for t in (0.0, 0.04, 17.33, 599.85):
        assert true_range(flight, 0, t) == pytest.approx(cubic(np.array([t]))[RANGE, 0], abs=1e-12)
    assert true_range(flight, 0, -0.7) == flight.history[0, RANGE, 0]


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.3, 0.137, 1.0])
def test_latency_reads_the_range_of_the_time_before(delay: float) -> None:
    t = np.arange(TICKS) * 0.1
    read = readings(f"effects.sonar_latency.d_s={delay}", history=cubic(t))
    later = t >= delay
    np.testing.assert_allclose(read[later], cubic(t[later] - delay)[RANGE], rtol=0, atol=1e-12)
    np.testing.assert_allclose(read[~later], 3.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("skew", [0.02, 0.0017, -0.01])
def test_clock_skew_stamps_ranges_by_a_clock_that_drifts(skew: float) -> None:
    t = np.arange(TICKS) * 0.1
    beyond = cubic(np.arange(int(TICKS * 1.05)) * 0.1)
    read = readings(f"effects.clock_skew.s={skew}", "effects.sonar_latency.d_s=0.05", history=beyond)
    expected = cubic(np.maximum(t * (1.0 + skew) - 0.05, 0.0))[RANGE]
    np.testing.assert_allclose(read, expected, rtol=0, atol=1e-12)


def test_the_on_board_filter_does_not_see_the_future() -> None:
    """With a clock that runs ahead, what is flown is what would be flown without: only the stamps differ."""
    plain, skewed = (flown((f"effects.clock_skew.s={s}",), scenario="paper-ds1") for s in (0, 0.02))
    np.testing.assert_array_equal(plain.record[0, SPEED, :TICKS], skewed.record[0, SPEED, :TICKS])


def test_noise_and_resolution() -> None:
    error = readings("sonar.noise_m=0.006") - 3.048
    assert error.std() == pytest.approx(0.006, rel=4.0 / math.sqrt(2 * TICKS))
    assert error.mean() == pytest.approx(0.0, abs=4.0 * 0.006 / math.sqrt(TICKS))
    assert np.corrcoef(error[1:], error[:-1])[0, 1] == pytest.approx(0.0, abs=4.0 / math.sqrt(TICKS))
    rounded = readings("sonar.noise_m=0.006", "sonar.resolution_m=0.01")
    np.testing.assert_allclose(rounded, np.round(rounded, 2), atol=1e-12)
    np.testing.assert_array_less(np.abs(rounded - 3.048 - error), 0.005 + 1e-12)


def test_drop_outs_pings_and_the_longest_range() -> None:
    share(np.isnan(readings("sonar.dropout=0.2")), 0.2)
    slow = readings("sonar.rate_hz=2.5")
    np.testing.assert_array_equal(np.isfinite(slow), np.arange(TICKS) % 4 == 0)
    history = np.vstack([np.where(np.arange(TICKS) < 100, 3.0, 5.0), np.zeros(TICKS)])
    near = readings("sonar.max_range_m=4", history=history)
    np.testing.assert_array_equal(np.isfinite(near), np.arange(TICKS) < 100)
    assert np.isnan(readings(history=np.full((2, TICKS), np.inf))).all()


def test_multipath_scale_and_offset() -> None:
    error = readings("effects.sonar_multipath.p=0.1", "effects.sonar_multipath.extra_m=0.4") - 3.048
    share(error > 0.2, 0.1)
    np.testing.assert_allclose(np.unique(np.round(error, 9)), [0.0, 0.4])
    np.testing.assert_allclose(readings("effects.sonar_scale.s=0.03"), 3.048 * 1.03)
    np.testing.assert_allclose(readings("effects.sonar_offset.o_m=-0.2"), 2.848)


def test_tachometer_noise_bias_and_spikes() -> None:
    noise = tachometer("tachometer.noise_rev_s=0.3")
    assert noise.std() == pytest.approx(0.3, rel=4.0 / math.sqrt(2 * TICKS))
    np.testing.assert_allclose(tachometer("effects.tachometer_bias.b_rev_s=0.7"), 0.7)
    spikes = tachometer("effects.tachometer_spikes.p=0.1", "effects.tachometer_spikes.size_rev_s=5")
    share(spikes > 2, 0.05)
    share(spikes < -2, 0.05)
    np.testing.assert_allclose(np.unique(np.round(spikes, 9)), [-5.0, 0.0, 5.0])


def test_the_governor_turns_the_propeller_until_its_tachometer_reads_what_is_wanted() -> None:
    settings = ("tachometer.governor_per_s=1", "effects.tachometer_bias.b_rev_s=0.7", "excitation.amplitude_rev_s=0")
    record = flown((*settings, "excitation.offset_rev_s=8")).record[0]
    assert record[SPEED, 0] == 8.0
    assert record[SPEED, 200] == pytest.approx(7.3) and record[SPEED_READING, 200] == pytest.approx(8.0)
    assert record[SPEED, 10] == pytest.approx(7.3 + 0.7 * 0.9**10)


def test_the_propeller_speed_keeps_its_limit() -> None:
    wild = flown(("n_limit_rev_s=9", "sonar.noise_m=0.5"), scenario="paper-ds1").record[0, SPEED]
    assert np.abs(wild).max() == 9.0 and (np.abs(wild) == 9.0).mean() > 0.2
    assert np.abs(flown(("n_limit_rev_s=9",)).record[0, SPEED]).max() == 9.0


def test_the_controller_waits_for_the_first_ping_and_flies_through_missed_ones() -> None:
    flight = flown(("sonar.dropout=1",), scenario="paper-ds1")
    assert not flight.record[0, SPEED].any() and np.isnan(flight.estimate).all()
    gaps = flown(("sonar.dropout=0.5", "sonar.noise_m=0.006"), scenario="paper-ds1")
    assert np.isfinite(gaps.record[0, SPEED]).all() and gaps.estimate[0, 0] == pytest.approx(3.048, abs=0.03)
    assert gaps.covariance[0, 0, 0] > prepare_covariance()


def prepare_covariance() -> float:
    return float(prepare([plan_run(load_scenario("paper-ds1"))]).covariance[0, 0, 0])


def test_switching_one_source_on_leaves_the_others_alone() -> None:
    plain = flown(("sonar.noise_m=0.006", "tachometer.noise_rev_s=0.1"))
    more = flown(
        ("sonar.noise_m=0.006", "tachometer.noise_rev_s=0.1", "sonar.dropout=0.3", "turbulence.acceleration_m_s2=0.01")
    )
    kept = np.isfinite(more.record[0, READING])
    np.testing.assert_array_equal(more.record[0, READING, kept], plain.record[0, READING, kept])
    np.testing.assert_array_equal(more.record[0, SPEED_READING], plain.record[0, SPEED_READING])
    without = flown(("tachometer.noise_rev_s=0.1",))
    np.testing.assert_array_equal(without.record[0, SPEED_READING], plain.record[0, SPEED_READING])


@pytest.mark.parametrize("effect", [effect.name for effect in CATALOGUE if effect.channel != "hydrodynamics"])
def test_an_effect_at_its_null_value_changes_no_bit(effect: str) -> None:
    (found,) = (e for e in CATALOGUE if e.name == effect)
    plan = plan_run(load_scenario("paper-ds1"))
    base = plan.parameters
    settings = tuple(
        f"effects.{effect}.{q.key}={q.scale if q.shape else base[f'{effect}.{q.name}']}" for q in found.parameters
    )
    noisy = ("sonar.noise_m=0.006", "tachometer.noise_rev_s=0.1", "duration_s=60")
    plain, null = (flown((*noisy, *extra), scenario="paper-ds1").record for extra in ((), settings))
    np.testing.assert_array_equal(plain, null)


@pytest.mark.parametrize("skew", [0.004, -0.004])
def test_a_skewed_echo_carries_the_noise_that_the_controller_hears_then(skew: float) -> None:
    settings = ("sonar.noise_m=0.01", f"effects.clock_skew.s={skew}", "duration_s=119.9")
    flight = flown(settings)
    heard = np.ceil(np.arange(1200) * (1.0 + skew) - 1e-6).astype(int)
    noise = flight.noise[0, SONAR, heard]
    np.testing.assert_allclose(flight.record[0, READING, :1200] - 3.048, noise, atol=1e-9)
