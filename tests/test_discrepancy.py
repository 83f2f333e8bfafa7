"""Causes without a name: each is noticed by the functions that it belongs to, and nothing by any where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import DRIVES, NOISE_M, NOMINAL, record, recordings, select, sine

from vtank.diagnose.lone_speeds import with_lone_speeds
from vtank.estimate.observed import Observed
from vtank.plant.parameters import slot
from vtank.present.words import WORDS

BETA = NOMINAL[slot("beta")]
SEEN = 5.0  # log evidence


def gains(runs: list[Observed], *names: str) -> dict[str, float]:
    """Gain of every family on top of the most probable of the named effects."""
    return {d.family: d.gain for d in select(runs, names).unnamed}


def test_nothing_is_noticed_where_nothing_is_missing() -> None:
    assert max(gains(recordings()).values()) <= 0.0
    assert max(gains(recordings({"linear_drag.c": 0.1}), "linear_drag").values()) <= 0.5


def test_every_family_has_a_caption() -> None:
    assert set(gains(recordings()[:1])) == set(WORDS["unnamed"])


def test_a_thrust_gain_that_wanders_is_noticed_as_one() -> None:
    found = gains(recordings(force=lambda t, u, n: 0.15 * BETA * n * abs(n) * np.sin(0.31 * t)))
    assert max(found, key=lambda family: found[family]) == "wandering thrust"
    assert found["wandering thrust"] > SEEN


def test_inertia_that_grows_with_speed_is_noticed_as_a_force() -> None:
    last = [0.0]

    def force(t: float, u: float, n: float) -> float:
        rate, last[0] = (u - last[0]) / 0.1 if t > 0.0 else 0.0, u
        return -8.0 * u * u * rate

    assert gains(recordings(force=force))["smooth force"] > SEEN


@pytest.mark.parametrize("spiked", [True, False])
def test_readings_that_the_hull_did_not_follow_are_noticed(spiked: bool) -> None:
    """The same jumps on record: in the tachometer alone, or of the propeller itself."""
    rng = np.random.default_rng(12)
    runs = recordings()
    jumps = [5.0 * rng.choice([-1.0, 0.0, 1.0], run.input.size, p=[0.02, 0.96, 0.02]) for run in runs]
    if spiked:
        found = gains([replace(run, input=run.input + jump) for run, jump in zip(runs, jumps, strict=True)])
    else:
        drives = [sine(*drive) + jump for drive, jump in zip(DRIVES, jumps, strict=True)]
        true = [record(f"run_{k}", drive, NOMINAL, NOISE_M, k) for k, drive in enumerate(drives)]
        assert all(np.mean(run.lone != 0.0) > 0.02 for run in with_lone_speeds(true))
        found = gains(true)
    assert (found["lone speeds"] > SEEN) == spiked
