"""Samples of a column as they are judged by: averaged where they come faster than any hull moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..record.columns import ATTITUDE, channel_of
from ..record.run import Run
from .driven import Driven
from .known import onward
from .layout import Layout

Array = NDArray[np.float64]
BIN_S, ALMOST = 0.1, 1.2  # over which samples of a channel that come (clearly) faster are averaged: no hull is quicker
MOST = 150_000  # measurements of all runs; beyond, some stretches are looked at, so that memory holds; a choice
SPENT = 1.0  # log-likelihood that averages beside jumps may cost a column; a choice
ANSWERED = 4.5  # deviations of a correlation from which inputs answer the noise of a column
TICK_S = 1e-6  # by which stamps of one time may differ: a recording has so many digits


def bins_of(runs: Sequence[Run], layout: Layout, driven: Sequence[Driven]) -> tuple[dict[str, float], float]:
    """Time over which samples of each column are averaged [s], and the share of all time that can be looked at."""
    bins, count = dict[str, float](), 0.0
    for name in layout.columns:
        late_s = latency_s(layout, name)
        each = [
            (*samples(run, name), told, late_s) for run, told in zip(runs, driven, strict=True) if name in run.columns
        ]
        bins[name] = min(_bin_s(*taken) for taken in each)
        count += sum(min(time.size, np.ptp(time) / bins[name] + told.jumps.size) for time, _, told, _ in each)
    return bins, min(MOST / max(count, 1.0), 1.0)


def latency_s(layout: Layout, name: str) -> float:
    """By how much a column is late, as the vehicle file has its instrument [s]."""
    owner = layout.vehicle.instrument(name)
    return sum(sensor.late_s for sensor in layout.vehicle.sensors if sensor.name == owner)


def _bin_s(time: Array, value: Array, driven: Driven, late_s: float) -> float:
    """Time over which averaging leaves no more that is faster than a parabola than there was, at most BIN_S [s].

    Nor more of what follows jumps of the inputs than noise would hide. And no longer than inputs are held that answer
    the noise of these samples: an average would hold what a pilot has answered meanwhile.
    """
    stamps, jumps, bin_s, least = driven.stamps, driven.jumps + late_s, BIN_S, scatter(value)
    if _interval_s(stamps) < BIN_S and answered(time, value, stamps, np.hstack((driven.inputs, driven.angles))):
        bin_s = _interval_s(stamps)
    while bin_s > ALMOST * _interval_s(time):
        bins = Bins.of(time, value, bin_s, stamps, jumps)
        if scatter(bins.straightened) <= least and bins.spent(least) <= SPENT:
            break
        bin_s *= 0.5
    return bin_s


def answered(time: Array, value: Array, stamps: Array, inputs: Array) -> bool:
    """Whether some of inputs, (I, C), held from their stamps on, steps at that after a sample with what is fast in it.

    time, value: of samples, shape (M,).
    """
    fast, at = np.diff(value, 2), np.searchsorted(stamps, time[2:] - TICK_S)
    there = (at > 0) & (at < stamps.size)
    fast, steps = fast[there], inputs[at[there]] - inputs[at[there] - 1]
    size = np.sqrt(np.sum(fast**2) * np.sum(steps**2, axis=0)) + 1e-300
    return bool(np.any(np.abs(fast @ steps) > ANSWERED * size / np.sqrt(max(fast.size, 1))))


def _interval_s(time: Array) -> float:
    return float(np.median(np.diff(time))) if time.size > 1 else np.inf


def thinned(time: Array, value: Array, bin_s: float, stamps: Array, jumps: Array) -> tuple[Array, Array]:
    """Samples that come faster averaged over bins of a time [s], each from after a stamp of the input up to another.

    A pilot that goes by these samples answers their noise: an average that held it, about a time after the answer,
    would seem to have foreseen it. What averaging takes off where a series curves, half its curvature times the spread
    of the times, is given back. No bin goes across a jump of the inputs: an average of what was before and after would
    seem to have followed at another time.
    """
    if time.size < 3 or bin_s <= ALMOST * _interval_s(time):
        return time, value
    bins = Bins.of(time, value, bin_s, stamps, jumps)
    return bins.at, bins.straightened


@dataclass(frozen=True, eq=False)
class Bins:
    """Averages over bins of time, (B,).

    at, mean: mean time [s] and value. count: of samples. curved: what averaging took off each as the series curves;
    doubt: its variance, over that of a sample. beside: which lie beside a jump of the inputs, where the curvature is
    that of the bins after it, or before; none where these are not three.
    """

    at: Array
    mean: Array
    count: NDArray[np.int64]
    curved: Array
    doubt: Array
    beside: NDArray[np.bool_]

    @classmethod
    def of(cls, time: Array, value: Array, bin_s: float, stamps: Array, jumps: Array) -> Bins:
        """Of samples; the rest as of `thinned`."""
        edges = np.union1d(_edges(time[0], time[-1], bin_s, stamps), jumps)
        bins = np.searchsorted(edges, time - TICK_S, side="right")
        count = np.bincount(bins)
        full = count > 0
        count = count[full]
        at, mean, square = (np.bincount(bins, series)[full] / count for series in (time, value, time * time))
        since, (bend, doubt) = np.searchsorted(jumps, at), np.zeros((2, at.size))
        amid = np.zeros(at.size, dtype=bool)
        amid[1:-1] = since[2:] == since[:-2]
        ahead, behind = 1.0 / (at[2:] - at[1:-1]), 1.0 / (at[1:-1] - at[:-2])
        weights = np.array([behind, -ahead - behind, ahead]) * 2.0 / (1.0 / ahead + 1.0 / behind)
        bend[1:-1] = np.sum(weights * (mean[:-2], mean[1:-1], mean[2:]), axis=0)
        doubt[1:-1] = np.sum(weights**2 / (count[:-2], count[1:-1], count[2:]), axis=0)
        nearest = np.arange(at.size)  # whose curvature is that of a bin
        nearest[1:] -= ~amid[1:] & amid[:-1] & (since[1:] == since[:-1])
        nearest[:-1] += ~amid[:-1] & amid[1:] & (since[1:] == since[:-1])
        spread = np.where(amid[nearest], 0.5 * (square - at * at), 0.0)
        return cls(at, mean, count, spread * bend[nearest], spread**2 * doubt[nearest], ~amid)

    @property
    def straightened(self) -> Array:
        """The averages with what curvature took off, (B,)."""
        return self.mean - self.curved

    def spent(self, noise: float) -> float:
        """Log-likelihood that averages may cost beside jumps, where hardly half of what is curved is given back.

        noise: deviation of a sample, whose own share in a curvature is taken off.
        """
        lost = self.count * ((self.curved / noise) ** 2 - self.doubt)
        return 0.5 * float(np.sum(lost[self.beside]))


def _edges(first: float, last: float, bin_s: float, stamps: Array) -> Array:
    """Ends of bins: a time apart, each moved to the nearest stamp within half of it."""
    ends = first + bin_s * np.arange(1.0, np.ceil((last - first) / bin_s) + 1.0)
    after = np.searchsorted(stamps, ends)
    around = np.r_[-np.inf, stamps, np.inf]
    before, behind = around[after], around[after + 1]
    near = np.where(ends - before < behind - ends, before, behind)
    return np.unique(np.where(np.abs(near - ends) <= 0.5 * bin_s, near, ends))


def samples(run: Run, name: str) -> tuple[Array, Array]:
    """Samples of a column; angles go on beyond half a turn."""
    time, value = run.samples(name)
    return time, onward(value) if channel_of(name) in ATTITUDE else value


def scatter(series: Array) -> float:
    """Standard deviation of what is faster than a parabola through neighbours, by third differences, robustly.

    The third difference of white noise has 20 times its variance.
    """
    if series.size < 8:
        return float(np.std(series)) + 1e-12
    third = np.diff(series, 3)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0)) + 1e-12
