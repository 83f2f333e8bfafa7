"""The noise level of all hypotheses: near what was simulated, though a gap is there that it could swallow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import NOISE_M, NOMINAL, differing, misread, record, recordings, sine, turbulent

from vtank.diagnose.evidence import STILL_SIGMA, Fitted, Setting, evaluate
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.noise_floor import (
    SEVERAL,
    STILL_MEMORY_S,
    log_prior,
    noise_at,
    plausible,
    rarity,
    settle,
    still,
)
from vtank.diagnose.selection import prepare
from vtank.estimate.observed import SPEED, Observed
from vtank.estimate.problem import Noise
from vtank.plant.parameters import slot

SIGMA, MEMORY_S = 1e-3, 2.0  # m/s2 and s of the turbulence simulated
BETA = NOMINAL[slot("beta")]


def refitted(runs: list[Observed]) -> tuple[Setting, Fitted, Fitted]:
    """Setting, nominal and refit at the noise level that the refit, left to itself, prefers."""
    setting = prepare(runs, NOMINAL)
    refit = evaluate(setting, Hypothesis())
    setting = setting.with_noise(noise_at(refit.problem, refit.optimum.theta))
    return setting, evaluate(setting, Hypothesis(refit=False)), evaluate(setting, Hypothesis(), [refit.start()])


def test_the_disturbance_is_found_where_nothing_is_missing() -> None:
    setting, *fits = refitted(recordings(seed=30, force=turbulent(SIGMA, MEMORY_S, 30)))
    noise = settle(setting, fits)[0].noise
    assert SIGMA / 2.0 < noise.sigma < 2.0 * SIGMA
    assert noise.variance[0] == pytest.approx(NOISE_M**2, rel=0.1)
    assert plausible(noise)


@pytest.mark.parametrize("gap", ["gain by run", "force over speed"])
def test_the_disturbance_is_found_beside_a_gap_that_it_could_swallow(gap: str) -> None:
    water = turbulent(SIGMA, MEMORY_S, 31)
    if gap == "gain by run":
        runs = differing([{"beta": BETA * (1.0 + g)} for g in (0.08, -0.08, 0.04, -0.04)], 31, water)
    else:
        runs = recordings(seed=31, force=lambda t, u, n: water(t, u, n) + 0.02 * np.exp(-((u / 0.03) ** 2)))
    setting, *fits = refitted(runs)
    assert setting.noise.sigma > 2.0 * SIGMA  # left to itself, the refit calls the gap a disturbance
    noise = settle(setting, fits)[0].noise
    assert SIGMA / 2.0 < noise.sigma < 2.0 * SIGMA
    assert noise.variance[0] == pytest.approx(NOISE_M**2, rel=0.15)


def test_a_disturbance_beyond_still_water_s_has_to_be_paid_for() -> None:
    levels = [log_prior(Noise(sigma=s)) for s in (0.0, 1e-5, STILL_SIGMA, 2.0 * STILL_SIGMA, 10.0 * STILL_SIGMA)]
    assert levels[:3] == [0.0, 0.0, 0.0] and 0.0 > levels[3] > levels[4]
    assert levels[4] < -4.0
    slow = Noise(sigma=STILL_SIGMA, correlation_time=10.0 * STILL_MEMORY_S)
    assert log_prior(slow) == levels[4] and rarity(slow) == 0.0
    assert plausible(Noise(sigma=SEVERAL * STILL_SIGMA)) and not plausible(Noise(sigma=1.01 * SEVERAL * STILL_SIGMA))


def test_still_water_has_no_more_than_that_and_no_coloured_error() -> None:
    rough, calm = Noise(sigma=0.02, colour_sigma=0.01), Noise(sigma=1e-4, colour_sigma=0.01)
    assert still(rough).sigma == STILL_SIGMA and still(rough).colour_sigma == 0.0
    white = replace(calm, variance=(calm.variance[0] + 0.01**2, *calm.variance[1:]), colour_sigma=0.0)
    assert still(calm) == white  # a reading is as uncertain as it was
    slow = replace(calm, correlation_time=30.0)
    assert still(slow) == replace(white, correlation_time=STILL_MEMORY_S)


def test_channels_begin_with_the_ratio_of_their_own_noise() -> None:
    """Of a sonar of 6 mm and a log of 0.6 mm/s, whatever a common level would say."""
    runs = []
    for k, run in enumerate(recordings()):
        calm = record(run.name, run.input, NOMINAL, 0.0, k)
        speed = np.gradient(-calm.value, run.time_s)
        speed += 6e-4 * np.random.default_rng(k).normal(size=speed.size)
        order = np.argsort([*run.time_s, *run.time_s], kind="stable")
        value, kind = (
            np.concatenate(both)[order] for both in ((run.value, speed), (run.kind, np.full(speed.size, SPEED)))
        )
        runs.append(replace(run, time_s=np.repeat(run.time_s, 2), value=value, kind=kind))
    variance = prepare(runs, NOMINAL).noise.variance
    assert variance[SPEED] / variance[0] == pytest.approx((6e-4 / NOISE_M) ** 2, rel=0.2)


def test_errors_of_the_readings_settle_beside_what_repeats_in_them() -> None:
    """An error that hardly moves the disturbance, but would pass for twice the noise."""
    runs = [replace(run, value=run.value + 0.012 * np.sin(40.0 * run.value)) for run in recordings(seed=5)]
    setting, *fits = refitted(runs)
    assert setting.noise.variance[0] + setting.noise.colour_sigma**2 > 1.5 * NOISE_M**2
    noise = settle(setting, fits)[0].noise
    assert noise.variance[0] + noise.colour_sigma**2 == pytest.approx(NOISE_M**2, rel=0.3)


def test_a_sonar_that_drifts_off_for_a_while_is_no_colour_of_all_its_readings() -> None:
    """It creeps along a side lobe at 6 mm/s until it finds its echo again, in one run once and in another twice."""

    def creeping(run: Observed, *windows: tuple[float, float]) -> Observed:
        return misread(run, lambda t: sum(np.where((t >= a) & (t < b), 0.006 * (t - a), 0.0) for a, b in windows))

    plain = [
        record(f"run_{k}", sine(*drive), NOMINAL, NOISE_M, 60 + k) for k, drive in enumerate(((0.5, 12.0), (0.3, 9.0)))
    ]
    setting, *fits = refitted([creeping(plain[0], (37.4, 60.4)), creeping(plain[1], (24.1, 45.0), (66.2, 74.5))])
    assert setting.noise.colour_sigma > NOISE_M  # left to itself, the refit calls it a coloured error
    noise = settle(setting, fits)[0].noise
    assert noise.colour_sigma < 0.001 and noise.variance[0] == pytest.approx(NOISE_M**2, rel=0.3)
