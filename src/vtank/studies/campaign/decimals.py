"""The CSV text of a run, compiled: the same bytes as `vtank.record` writes, a dozen times faster, the GIL released.

The decimals are an argument of what is compiled: a constant would be baked into machine code that outlives its change.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...compiled import law
from ...record import DECIMALS, TIME, Run, run_bytes

Array = NDArray[np.float64]
UNITS = 10.0**DECIMALS  # steps of the last decimal in one
LARGEST = 2.0**52 / UNITS / 2.0  # beyond it a number has fewer binary places than the decimals asked for
CELL = 24  # bytes that suffice for sign, digits, point and comma of a number below LARGEST
SPLIT = 134217729.0  # 2**27 + 1, which halves a float64's digits


@law
def nearest_step(value: float, units: float) -> float:
    """value * units rounded to the nearest whole number, ties to even, as if by exact arithmetic; NaN stays NaN.

    The product's rounding error is found exactly (Dekker, Numerische Mathematik 18 (1971)) and decides apparent ties.
    """
    product = value * units
    high = value * SPLIT
    high = high - (high - value)
    low = value - high
    error = (high * units - product) + low * units  # exact: a million has 20 bits
    nearest = np.rint(product)
    if product - nearest == 0.5 and error > 0.0:
        return nearest + 1.0
    if product - nearest == -0.5 and error < 0.0:
        return nearest - 1.0
    return nearest


@law
def steps_of(values: Array, units: float) -> Array:
    """The values, shape (C, T), in steps of the last decimal, of which one has `units`."""
    steps = np.empty_like(values)
    for c in range(values.shape[0]):
        for k in range(values.shape[1]):
            steps[c, k] = nearest_step(values[c, k], units) + 0.0  # + 0: no negative zero
    return steps


@law
def write_cells(steps: Array, places: int, text: NDArray[np.uint8]) -> int:
    """Write rows of decimal numbers, (C, T) steps as T lines of C cells; returns the number of bytes."""
    digits = np.empty(24, np.uint8)
    end = 0
    for k in range(steps.shape[1]):
        for c in range(steps.shape[0]):
            if not math.isnan(steps[c, k]):
                end = write_number(np.int64(steps[c, k]), places, digits, text, end)
            text[end] = 44 if c < steps.shape[0] - 1 else 10  # comma, line feed
            end += 1
    return end


@law
def write_number(steps: int, places: int, digits: NDArray[np.uint8], text: NDArray[np.uint8], end: int) -> int:
    """Write steps / 10**places without trailing zeros from byte `end` on; returns the byte after it."""
    if steps < 0:
        text[end] = 45  # minus
        end += 1
        steps = -steps
    while places > 0 and steps % 10 == 0:
        steps //= 10
        places -= 1
    count = 0
    while steps > 0 or count <= places:
        digits[count] = 48 + steps % 10
        steps //= 10
        count += 1
    for place in range(count - 1, -1, -1):
        text[end] = digits[place]
        end += 1
        if place == places and places > 0:
            text[end] = 46  # point
            end += 1
    return end


def table_of(run: Run) -> Array:
    """Time and all columns of a run, shape (C, T), rounded to the decimals that are written."""
    values = np.array([run.time_s, *run.columns.values()])
    return steps_of(values, UNITS) / UNITS if np.nanmax(np.abs(values)) < LARGEST else values


def csv_of(run: Run) -> bytes:
    """The CSV file of a run that obeys the rules for runs."""
    values = np.array([run.time_s, *run.columns.values()])
    if not np.nanmax(np.abs(values)) < LARGEST:
        return run_bytes(run)
    text = np.empty(values.size * CELL, np.uint8)
    header = ",".join([TIME, *run.columns]) + "\n"
    return header.encode() + text[: write_cells(steps_of(values, UNITS), DECIMALS, text)].tobytes()
