"""Station keeping before the wall in waves: how far the hull is carried off, and how hard the propellers work.

The vehicle is asked to stay where it is, at a given share of the water's depth, by the range to the wall. A sea state
is held when the hull stays within ERROR_M for HELD of the time and the propellers are at their limit for no more than
the rest of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...experiment import Excitation, Plan, Result, Scenario, plan_run, simulate_surge, simulate_tank
from ...plant import Truth
from ...waves import Waves, breaking_height
from .loop import Array
from .response import TAKEN_OVER, passage, rms, share_at_limit, struck

ERROR_M = 0.3  # [m] greatest error of a held station; a choice
HELD = 1.0 - TAKEN_OVER  # share of the time for which it must not be passed
WATER_DEPTHS_M = (4.0, 8.0, 16.0)  # [m] shallow water, of which the paper speaks; a choice
HEIGHTS_M = (0.1, 0.2, 0.3, 0.45, 0.7, 1.0)  # [m] a choice
PERIODS_S = (2.5, 4.0, 6.0, 8.0, 12.0)  # [s] a choice
DEPTH_SHARE = 0.5  # of the water's depth, at which the vehicle stays: a choice
SETTLING_S = 60.0  # [s] for the fade-in of the waves and what it leaves; a choice
MEASURED_S = {"regular": 120.0, "irregular": 480.0}  # [s] 40 waves of 12 s make an rms good to about 10 %; a choice


@dataclass(frozen=True, eq=False)
class Stations:
    """What was predicted; axes water depth, wave height, wave period. NaN where waves break or bare the vehicle.

    Attributes:
        kind: "regular" (height crest to trough, period) or "irregular" (significant height, peak period).
        water_depth_m: shape (D,); height_m: shape (H,); period_s: shape (P,).
        rms_m: of the position error, shape (D, H, P).
        most_m: error that is passed for 5 % of the time, shape (D, H, P).
        at_limit: share of the time with the propellers at their limit, shape (D, H, P).
        n_rms_rev_s, water_rms_m_s: of propeller speed, and of the water's speed ahead and astern, shape (D, H, P).
    """

    kind: str
    water_depth_m: Array
    height_m: Array
    period_s: Array
    rms_m: Array
    most_m: Array
    at_limit: Array
    n_rms_rev_s: Array
    water_rms_m_s: Array

    @property
    def burden(self) -> Array:
        """Greater of error and time at the limit, each over what is allowed, shape (D, H, P): held up to 1."""
        return np.maximum(self.most_m / ERROR_M, self.at_limit / TAKEN_OVER)

    def held_height_m(self) -> Array:
        """Greatest height that is held, shape (D, P): linear between the heights that were tried.

        NaN where even the lowest is not held; the greatest that was tried, or does not break, where all are.
        """
        return np.array([[held_height(self.height_m, b) for b in by_height.T] for by_height in self.burden])


def held_height(height_m: Array, burden: Array) -> float:
    """Height at which the burden reaches 1, of increasing heights; NaN where the first is too much or unknown."""
    known = np.isfinite(burden)
    if not known.any() or burden[known][0] > 1.0:
        return float("nan")
    reached = passage(height_m[known], burden[known] - 1.0)
    return float(height_m[known][-1]) if np.isnan(reached) else reached


def station_plan(
    scenario: Scenario, waves: Waves, depth_m: float, truth: Truth | str | None = None, run: int = 0
) -> Plan:
    """The scenario's vehicle and sensors, kept at that depth in open water before a wall."""
    kept = replace(
        scenario,
        excitation=Excitation("station", "position", ()),
        waves=replace(waves, ramp_s=0.5 * SETTLING_S),
        walls="sea",
        depth_m=depth_m,
        duration_s=SETTLING_S + MEASURED_S[waves.kind],
    )
    name = f"{scenario.name}-{waves.water_depth_m:g}-{waves.height_m:g}-{waves.period_s:g}"
    return plan_run(kept, run, truth=truth, name=name)


def possible(waves: Waves, depth_m: float) -> bool:
    """Whether the waves neither break nor come near the vehicle."""
    return waves.height_m <= min(breaking_height(waves.period_s, waves.water_depth_m), depth_m)


def keep_station(
    scenario: Scenario,
    kind: str,
    water_depth_m: Sequence[float] = WATER_DEPTHS_M,
    height_m: Sequence[float] = HEIGHTS_M,
    period_s: Sequence[float] = PERIODS_S,
    truth: Truth | str | None = None,
    model: str = "tank",
    nthread: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Stations:
    """Every sea state of the grid, in the tank or on the surge model; random phases are the seed's, one sea each."""
    grid = [(d, h, t) for d in water_depth_m for h in height_m for t in period_s]
    plans = {}
    for i, (water, height, period) in enumerate(grid):
        waves = replace(scenario.waves, kind=kind, height_m=height, period_s=period, water_depth_m=water)
        if possible(waves, DEPTH_SHARE * water):
            plans[i] = station_plan(scenario, waves, DEPTH_SHARE * water, truth, run=i)
    simulate = simulate_tank if model == "tank" else simulate_surge
    table = np.full((len(grid), 5), np.nan)
    table[list(plans)] = [measure(result) for result in simulate(list(plans.values()), nthread, progress)]
    shape = (5, len(water_depth_m), len(height_m), len(period_s))
    axes = (np.asarray(axis, dtype=np.float64) for axis in (water_depth_m, height_m, period_s))
    return Stations(kind, *axes, *table.T.reshape(shape))


def measure(result: Result) -> tuple[float, float, float, float, float]:
    """Rms and 95 % error [m], share at the limit, rms of n [rev/s] and of the water's speed [m/s] of one run.

    Infinite errors where the hull struck the wall.
    """
    later = result.run.time_s >= SETTLING_S
    error, n, water = (result.true[name][later] for name in ("position_m", "n_rev_s", "water_m_s"))
    used = (share_at_limit(result.plan, n), rms(n), rms(water))
    if struck(result):
        return float("inf"), float("inf"), *used
    return rms(error), float(np.quantile(np.abs(error), HELD)), *used
