"""Memory that fades in no exponential: which way a variable went last, and what rings on after it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import TICK_S, recordings, sine
from scipy.integrate import solve_ivp
from test_freeform import first

from vtank.diagnose.freeform.functions import PLAYS, dragged, ways_of
from vtank.diagnose.freeform.motion import DAMPING, RINGS_RAD_S, rung

HALF, TOP = 0.2, 1.0


def triangle(count: int) -> np.ndarray:
    """From 0 up and down between both tops, in steps that are the same everywhere."""
    phase = np.linspace(0.0, 3.0, count)
    return TOP * (1.0 - np.abs((phase + 1.0) % 4.0 - 2.0))


def test_play_drags_behind_by_half_of_it_and_turns_round_after_all_of_it() -> None:
    t, values = np.linspace(0.0, 3.0, 3001), triangle(3001)
    out = dragged(values, HALF)
    assert np.all(np.abs(values - out) <= HALF + 1e-12)
    ahead = (t > HALF) & (t < 1.0)  # up to the first top
    assert out[ahead] == pytest.approx(values[ahead] - HALF, abs=1e-3)
    lost = (t > 1.0) & (t < 1.0 + 2.0 * HALF)  # play is taken up
    assert out[lost] == pytest.approx(TOP - HALF, abs=1e-3)
    back = (t > 1.0 + 2.0 * HALF) & (t < 3.0)
    assert out[back] == pytest.approx(values[back] + HALF, abs=1e-3)


def test_the_way_of_what_stands_still_stays() -> None:
    share = np.concatenate([np.linspace(0.2, 0.9, 50), np.full(50, 0.9), np.linspace(0.9, 0.1, 80), np.full(50, 0.1)])
    ways = ways_of(share)
    assert ways.shape == (share.size, 2 * len(PLAYS)) and np.abs(ways).max() <= 1.0 + 1e-12
    assert np.ptp(ways[60:100], axis=0).max() == 0.0 and np.ptp(ways[-40:], axis=0).max() == 0.0
    assert ways[70, 0] == pytest.approx(1.0) and ways[-1, 0] == pytest.approx(-1.0)


def test_a_sonar_on_a_slack_bracket_reads_by_which_way_it_went() -> None:
    slack_m = 0.012
    runs = recordings()
    runs = [replace(run, value=run.value + slack_m * way(run.value)) for run in runs]
    found = first(runs)
    assert (found.channel, found.about) == ("sensor", "which way the place went last")


def way(range_m: np.ndarray) -> np.ndarray:
    """-1 or 1 by which way a range went last, by more than its noise."""
    smooth = np.convolve(range_m, np.ones(9) / 9.0, mode="same")
    return np.asarray((smooth - dragged(smooth, 0.02)) / 0.02)


@pytest.mark.parametrize("rad_s", [1.2, 3.0])
def test_what_rings_is_a_damped_oscillator_driven_by_what_is_held(rad_s: float) -> None:
    """Against an independent integrator: z' = (i - damping) rad_s z + rad_s a."""
    t, values = np.arange(0.0, 20.0, 0.1), sine(0.7, 1.0, 20.0)
    k = int(np.argmin(np.abs(RINGS_RAD_S - rad_s)))
    pole = complex(-DAMPING, 1.0) * RINGS_RAD_S[k]

    def rate(at: float, z: np.ndarray) -> np.ndarray:
        return pole * z + RINGS_RAD_S[k] * values[min(int(at / 0.1 + 1e-9), values.size - 1)]

    z = [0j]
    for j in range(1, t.size):
        step = solve_ivp(rate, (t[j - 1], t[j] - 1e-9), [z[-1]], rtol=1e-9, atol=1e-12)
        z.append(step.y[0, -1])
    both = rung(t, values)[:, 2 * k : 2 * k + 2]
    assert both == pytest.approx(np.column_stack([np.real(z), np.imag(z)]), abs=1e-6)


def test_a_load_that_swings_under_the_hull_is_found_by_its_ringing() -> None:
    """A tenth of the hull's mass on a pendulum of 1.7 rad/s, which the hull's own acceleration sets swinging."""
    state, last = np.zeros(2), [0.0, 0.0]

    def swinging(t: float, u: float, n: float) -> float:
        if t == 0.0:
            state[:], last[:] = 0.0, [0.0, u]
        a, last[1] = (u - last[1]) / TICK_S, u
        for _ in range(10):
            state[1] += 0.1 * TICK_S * (-a - 1.7**2 * state[0] - 2.0 * 0.08 * 1.7 * state[1])
            state[0] += 0.1 * TICK_S * state[1]
        return 0.1 * (1.7**2 * state[0] + 2.0 * 0.08 * 1.7 * state[1])

    found = first(recordings(force=swinging))
    assert (found.channel, found.about) == ("hydrodynamics", "ringing after the acceleration")
