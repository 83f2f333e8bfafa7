"""A vehicle that is steered by its own sonar: the input carries the sonar's noise, and no error of the readings."""

from __future__ import annotations

import numpy as np
import pytest
from recorded import NOISE, NOISE_M, STANDOFF_M, TICK_S
from synthetic import advance

from vtank.diagnose.evidence import Fitted, evaluate
from vtank.diagnose.freeform import motion
from vtank.diagnose.freeform.pursuit import pursue
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.selection import prepare
from vtank.estimate.observed import RANGE, Observed
from vtank.plant.parameters import vector

QUICK = vector({"alpha": -7.5, "beta": 2e-3, "thrust_lag.tau": 0.12})  # a small vehicle with strong thrusters


def steered(name: str, rad_s: float, seed: int) -> Observed:
    """Four minutes at 10 Hz of a vehicle that answers to every reading at once."""
    rng, time = np.random.default_rng(seed), TICK_S * np.arange(2400)
    x = u = z = wake = 0.0
    read, driven = np.empty(time.size), np.empty(time.size)
    for k, t in enumerate(time):
        read[k] = STANDOFF_M - x + NOISE_M * rng.normal()
        wanted = 3.0 * (read[k] - STANDOFF_M + 0.25 * np.sin(rad_s * t)) - 1.5 * u  # [m/s2]
        driven[k] = np.sign(wanted) * np.sqrt(abs(wanted) / 2e-3)
        x, u, z, wake = advance(t, TICK_S, x, u, z, wake, driven[k], 0.0, QUICK)
    return Observed(name, "n_rev_s", time, driven, time, read, np.full(time.size, RANGE))


@pytest.fixture(scope="module")
def fit() -> Fitted:
    runs = [steered(f"run_{k}", rad_s, k) for k, rad_s in enumerate((0.7, 0.2, 0.25, 0.55, 0.45))]
    return evaluate(prepare(runs, QUICK).with_noise(NOISE), Hypothesis())


def test_nothing_is_missing_where_the_controller_answers_to_noise(fit: Fitted) -> None:
    assert pursue(fit).components == ()


@pytest.mark.slow
def test_a_rate_that_knows_the_answer_would_pass_for_an_error(fit: Fitted, monkeypatch: pytest.MonkeyPatch) -> None:
    rate = motion.rate
    monkeypatch.setattr(motion, "rate", lambda t, values, past=0: rate(t, values))
    assert any(c.channel == "sensor" and c.about == "acceleration" for c in pursue(fit).components)
