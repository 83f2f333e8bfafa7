"""From a record to what the paper's regression sees: surge speed and propeller speed at the regression step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...units import FOOT_M
from .regression import Array
from .settings import PaperSettings
from .sonar_filter import sonar_filter, sonar_filter_compiled

if TYPE_CHECKING:
    from ...record.run import Run

SPARSEST = 100  # grid points per sample beyond which a record is refused


@dataclass(frozen=True)
class Signals:
    """What the regression sees: surge speed [m/s] and propeller speed [rev/s] at the regression step, shape (K,)."""

    time_s: Array
    u_m_s: Array
    n_rev_s: Array
    step_s: float


def range_signals(range_m: Array, n_rev_s: Array, period_s: float, settings: PaperSettings) -> Signals:
    """Signals from the range to the wall ahead, shape (T,), and the propeller speed, shape (T,); NaN: no sample.

    InputError if too little is left after the filter has settled.
    """
    run_filter = sonar_filter_compiled if settings.compiled else sonar_filter
    q, r = settings.filter_q_ft2_s5 * FOOT_M**2, settings.filter_r_ft2 * FOOT_M**2
    u = -run_filter(range_m, period_s, q, r)[:, 1]
    n = run_filter(n_rev_s, period_s, q, r)[:, 0] if settings.filter_propeller else _held(n_rev_s)
    return decimated(u, n, period_s, settings.regression_step_s, settings.settle_s)


def speed_signals(u_m_s: Array, n_rev_s: Array, period_s: float, settings: PaperSettings) -> Signals:
    """Signals from a measured surge speed, shape (T,), which passes no filter; gaps in it are interpolated."""
    return decimated(_interpolated(u_m_s), _held(n_rev_s), period_s, settings.regression_step_s)


def run_signals(run: Run, settings: PaperSettings) -> Signals:
    """Signals of a run: from range_m if it has one (the paper's way), else surge_m_s, else position_m.

    Samples are put on the grid of the output channel's median period. A thrust_N input takes the place of n|n|, so
    that b is one over the moving mass [1/kg]; a command takes the place of n.
    """
    output = next((name for name in ("range_m", "surge_m_s", "position_m") if name in run.columns), None)
    if output is None:
        raise InputError(f"run {run.name}: none of range_m, surge_m_s, position_m to identify from")
    time, measured = run.samples(output)
    if time.size < 3:
        raise InputError(f"run {run.name}: {output} has {time.size} samples, expected at least 3")
    start_s, period_s, span_s = float(time[0]), float(np.median(np.diff(time))), float(time[-1] - time[0])
    size = round(span_s / period_s) + 1
    if size > SPARSEST * time.size:
        raise InputError(
            f"run {run.name}: {output} has {time.size} samples {period_s:g} s apart and gaps that span "
            f"{span_s:g} s; split the run at its gaps"
        )
    y, n = (_placed(*of, start_s, period_s, size) for of in ((time, measured), run.samples(run.input)))
    if output == "surge_m_s":
        signals = speed_signals(y, n, period_s, settings)
    else:
        signals = range_signals(y if output == "range_m" else -y, n, period_s, settings)
    if run.input != "thrust_N":
        return signals
    force = signals.n_rev_s
    return Signals(signals.time_s, signals.u_m_s, np.sign(force) * np.sqrt(np.abs(force)), signals.step_s)


def _placed(time_s: Array, values: Array, start_s: float, period_s: float, size: int) -> Array:
    """Each sample at its nearest point of a regular grid, shape (size,), NaN between."""
    on_grid = np.full(size, np.nan)
    index = np.rint((time_s - start_s) / period_s).astype(int)
    inside = (index >= 0) & (index < size)
    on_grid[index[inside]] = values[inside]
    return on_grid


def decimated(u: Array, n: Array, period_s: float, regression_step_s: float, settle_s: float = 0.0) -> Signals:
    """Signals at every regression step from speeds at every period, both shape (T,), NaN: none.

    settle_s: dropped at the start [s]. InputError if too little is left.
    """
    every = max(1, round(regression_step_s / period_s))
    both = np.isfinite(u) & np.isfinite(n)
    if not both.any():
        raise InputError("no time at which both an output and an input are known")
    known = np.flatnonzero(both)
    take = np.arange(known[0] + round(settle_s / period_s), known[-1] + 1, every)
    if take.size < 4:
        raise InputError(
            f"{u.size * period_s:g} s of record are too few steps of {every * period_s:g} s to identify from"
        )
    return Signals(take * period_s, u[take], n[take], every * period_s)


def _held(values: Array) -> Array:
    """Gaps filled with the sample before (zero-order hold); NaN before the first."""
    known = np.isfinite(values)
    last = np.maximum.accumulate(np.where(known, np.arange(values.size), -1))
    return np.where(last >= 0, values[last], np.nan)


def _interpolated(values: Array) -> Array:
    """Gaps filled linearly; NaN before the first and after the last sample."""
    known = np.flatnonzero(np.isfinite(values))
    if known.size == 0:
        return values
    return np.interp(np.arange(values.size), known, values[known], left=np.nan, right=np.nan)
