"""What a diagnosis is given: runs that go together, and a nominal simulator."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..estimate.observed import FEWEST, Observed, observe, stretches
from ..plant.parameters import SIZE
from ..plant.truth import Truth, load_truth
from ..record import Run

FOREIGN = "none"  # in place of a nominal: the recordings' own refit


def observed(runs: Iterable[Run]) -> list[Observed]:
    """The runs as the diagnosis sees them; InputError where they do not go together or hold too little."""
    found = [observe(run) for run in stretches(tuple(runs))]
    if not found:
        raise InputError("no runs: nothing can be diagnosed")
    first = found[0]
    for run in found:
        if run.input_name != first.input_name:
            raise InputError(
                f"run {run.name}: its input is {run.input_name}, that of run {first.name} is {first.input_name}; "
                "all runs of a diagnosis need the same input"
            )
        if run.time_s.size < FEWEST:
            raise InputError(f"run {run.name}: {run.time_s.size} measurements, expected at least {FEWEST} to diagnose")
        if run.input.size < 2:
            raise InputError(f"run {run.name}: one value of {run.input_name}, expected one for every change of it")
    if all(float(abs(run.input).max()) == 0.0 for run in found):
        raise InputError(
            f"{first.input_name} is zero in all runs: nothing drives the vehicle, nothing can be diagnosed"
        )
    return found


@dataclass(frozen=True)
class Nominal:
    """The simulator that recordings are compared with.

    Attributes:
        name: by which it is told; FOREIGN where there is none.
        p: parameter vector, shape (P,), or None.
        mass_kg: moving mass of its vehicle, where the truth is derived from one.
    """

    name: str
    p: np.ndarray | None
    mass_kg: float | None = None


def nominal_of(nominal: str | Path | Truth | np.ndarray, run: Observed) -> Nominal:
    """The nominal simulator; InputError if it cannot be read, or cannot be driven by the input of the run.

    nominal: a truth preset, its name or path, a parameter vector, shape (P,), or "none" for a foreign vehicle.
    """
    if isinstance(nominal, np.ndarray):
        if nominal.shape != (SIZE,):
            raise InputError(f"nominal: found an array of shape {nominal.shape}, expected ({SIZE},)")
        return Nominal("given parameters", nominal)
    if nominal == FOREIGN:
        return Nominal(FOREIGN, None)
    truth = nominal if isinstance(nominal, Truth) else load_truth(nominal)
    if run.input_name != "n_rev_s":
        raise InputError(
            f"run {run.name}: its input is {run.input_name}, but the nominal simulator {truth.name} is driven "
            'by a propeller speed, n_rev_s; for a foreign vehicle use --nominal none, in Python nominal="none"'
        )
    return Nominal(truth.name, truth.vector(), truth.moving_mass_kg)
