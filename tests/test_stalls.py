"""A sensor that repeats itself is found by that; one whose scale is coarse, or whose vehicle rests, is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import DRIVES, NOISE, NOISE_M, NOMINAL, record, sine

from vtank.diagnose.evidence import evaluate
from vtank.diagnose.freeform import Component, pursue
from vtank.diagnose.freeform.stalls import bridged, stalls
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.selection import prepare
from vtank.estimate.observed import Observed

COURSE = 0.1 * np.sin(0.01 * np.arange(1000))


def noisy(seed: int) -> np.ndarray:
    return COURSE + 0.01 * np.random.default_rng(seed).normal(size=COURSE.size)


def test_a_stretch_that_repeats_is_found_to_the_reading() -> None:
    values = noisy(1)
    values[300:310], values[990:] = values[299], values[989]
    assert stalls(values) == stalls(values, COURSE) == [(299, 309), (989, 999)]


@pytest.mark.parametrize("step", [0.005, 0.02, 0.1])
def test_a_coarse_scale_repeats_by_chance(step: float) -> None:
    assert stalls(step * np.round(noisy(2) / step), COURSE) == []


def test_commands_that_are_held_do_not_stall() -> None:
    assert stalls(np.repeat([1.0, -1.0, 2.0, 0.0], 100)) == []
    assert stalls(np.repeat(noisy(3), 4)) == []  # read four times as often as it is measured


def test_a_bridge_goes_from_the_last_true_reading_to_the_next() -> None:
    values = np.array([0.0, 1.0, 1.0, 1.0, 4.0])
    np.testing.assert_allclose(bridged(values, (1, 3)), [0.0, 1.0, 2.0, 3.0, 4.0])
    np.testing.assert_allclose(bridged(values[:4], (1, 3)), values[:4])


def recorded_again(column: str) -> list[Observed]:
    """Two runs, in the second of which a column stalls for two seconds."""
    runs = []
    for k, (w, n) in enumerate(DRIVES[:2]):
        drive = sine(w, n, 60.0) + 0.03 * np.random.default_rng(k).normal(size=600)
        runs.append(record(f"run_{k}", drive, NOMINAL, NOISE_M, k))
    values = getattr(runs[1], column).copy()
    values[301:321] = values[300]
    return [runs[0], replace(runs[1], **{column: values})]


def found(runs: list[Observed]) -> tuple[Component, ...]:
    return pursue(evaluate(prepare(runs, NOMINAL).with_noise(NOISE), Hypothesis())).components


@pytest.mark.parametrize("column", ["value", "input"])
def test_a_stall_is_the_first_thing_found_missing(column: str) -> None:
    first = max(found(recorded_again(column)), key=lambda c: c.gain)
    assert (first.channel, first.about) == ("sensor", "repeated reading")
    ((run, start, end),) = first.windows
    assert run == 1 and start == pytest.approx(30.1, abs=0.11) and end == pytest.approx(32.0, abs=0.11)
