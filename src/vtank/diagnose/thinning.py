"""Long recordings, thinned: inputs averaged over each step of a coarser grid, measurements picked at its stamps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..estimate.observed import Observed

SHORTEST_S = 0.02  # [s] period below which recordings are thinned: vehicles and drives answer more slowly; a choice
FOREIGN_SAMPLES = 3000  # of all runs together, where hypotheses grow one effect at a time; for the time it takes
MOST_SAMPLES = 12_000  # of all runs together, where a nominal is given; for the time it takes


def thinned(runs: Sequence[Observed], held: bool) -> tuple[Observed, ...]:
    """The runs with as few samples as the diagnosis has time for; the same runs where they have no more.

    held: whether an input is held from stamp to stamp, as a command is, so that its thrust (n|n|) is averaged, exactly;
    else it is taken to be straight between its samples, as the record of a smooth signal.
    """
    length = sum(float(run.time_s[-1] - run.time_s[0]) for run in runs)
    if held and sum(run.time_s.size for run in runs) <= MOST_SAMPLES:
        return tuple(runs)
    period = max(SHORTEST_S, length / (MOST_SAMPLES if held else FOREIGN_SAMPLES))
    return tuple(thin(run, period, held) for run in runs)


def thin(run: Observed, period: float, held: bool = False) -> Observed:
    """The run on an even grid of stamps [s] where it is faster than that."""
    if float(np.median(np.diff(run.input_time_s))) > 0.75 * period:
        return run
    edges = np.arange(run.time_s[0], run.time_s[-1] + period, period)
    square = held and run.input_name != "thrust_N"
    value = run.input * np.abs(run.input) if square else run.input
    steps = (value[:-1] if held else 0.5 * (value[1:] + value[:-1])) * np.diff(run.input_time_s)
    stamps, total = run.input_time_s, np.concatenate([[0.0], np.cumsum(steps)])
    if held:  # the last value is held to the end
        stamps, total = np.append(stamps, edges[-1]), np.append(total, total[-1] + value[-1] * (edges[-1] - stamps[-1]))
    mean = np.diff(np.interp(edges, stamps, total)) / period
    keep = np.zeros(run.time_s.size, dtype=bool)
    for kind in run.first:
        own = np.flatnonzero(run.kind == kind)
        keep[own[np.unique(np.searchsorted(run.time_s[own], edges[:-1] - 1e-6).clip(max=own.size - 1))]] = True
    return replace(
        run,
        input_time_s=edges[:-1],
        input=np.sign(mean) * np.sqrt(np.abs(mean)) if square else mean,
        lone=np.zeros(edges.size - 1),
        time_s=run.time_s[keep],
        value=run.value[keep],
        kind=run.kind[keep],
    )
