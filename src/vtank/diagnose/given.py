"""What a diagnosis is given: runs that go together, and a nominal simulator."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..estimate.observed import FEWEST, Observed, observe, stretches
from ..logs import decidable
from ..plant.parameters import SIZE
from ..plant.truth import Truth
from ..plant.vehicle import CORRECTED, Vehicle, load_vehicle
from ..record import Run
from ..record.columns import column
from ..record.run import INPUTS
from ..record.table import open_table
from ..record.toml import meant
from ..resources import models_dir
from .simulator_file import read_simulator
from .thinning import SHORTEST_S, told_once

SHORTEST_SPAN_S = FEWEST * SHORTEST_S  # [s] of a run, below which too little is left of it once it is thinned
FOREIGN = "none"  # in place of a nominal: the recordings' own refit


def observed(runs: Iterable[Run]) -> list[Observed]:
    """The runs as the diagnosis sees them; InputError where they do not go together or hold too little."""
    found = [told_once(observe(run)) for run in stretches(tuple(runs))]
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
        if (span := float(run.time_s[-1] - run.time_s[0])) < SHORTEST_SPAN_S:
            raise InputError(
                f"run {run.name}: spans {span:.3g} s, expected at least {SHORTEST_SPAN_S:g} s to diagnose; "
                "is time_s in another unit?"
            )
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
        input_name: column of the input that drives it.
    """

    name: str
    p: np.ndarray | None
    mass_kg: float | None = None
    input_name: str = "n_rev_s"


def vehicle_of(
    nominal: str | Path | Truth | Vehicle | np.ndarray | None, runs: Sequence[Run], axes: Sequence[str] | None
) -> Vehicle | None:
    """The vehicle that is the nominal of whole-vehicle recordings; None where one input and one axis are meant.

    A vehicle file is told by its [body], a diagnosed model by its schema; a name that is a truth's as well by the
    columns of the runs. InputError where runs are of a whole vehicle, or axes are asked about, and no vehicle is named.
    """
    if isinstance(nominal, Vehicle):
        return known_vehicle(nominal)
    single = all(set(INPUTS) & run.columns.keys() for run in runs)
    if isinstance(nominal, str | Path) and nominal != FOREIGN:
        path = Path(nominal)
        named = (models_dir() / f"{nominal}.toml").is_file() and (bool(axes) or not single)
        entries = open_table(path).entries if path.suffix == ".toml" and path.is_file() else {}
        if named or "body" in entries or entries.get("schema") == CORRECTED:
            return known_vehicle(load_vehicle(nominal))
    if axes or (runs and not single and any(column(name) for run in runs for name in run.columns)):
        telling(runs)
        raise InputError(
            "recordings of a whole vehicle need its file as the simulator: --nominal vehicle.toml, in Python "
            f'nominal="vehicle.toml"; {_named(nominal)}'
        )
    return None


def _named(nominal: object) -> str:
    """What was given where a vehicle is expected, and which there are."""
    if nominal is None:
        return "none was given"
    name = str(nominal)
    vehicles = sorted(path.stem for path in models_dir().glob("*.toml"))
    return f"found {name}{'' if name.endswith('.toml') else meant(name, vehicles)}"


def known_vehicle(vehicle: Vehicle) -> Vehicle:
    """With what its file leaves to the MJCF; InputError where the two differ."""
    from ..tank import described  # MuJoCo takes a while to load

    return described(vehicle)


def telling(runs: Sequence[Run]) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """The runs from which something can be decided, and what is said of all; InputError where there is none.

    A run is cut where recording paused.
    """
    judged = [(run, decidable(run)) for run in stretches(runs)]
    kept = tuple(run for run, found in judged if not found.refusal)
    if not kept and judged:
        run, found = judged[0]
        raise InputError(f"run {run.name}: nothing can be diagnosed: {found.refusal}")
    said = [f"run {run.name} is left out: {found.refusal}" for run, found in judged if found.refusal]
    for run, found in judged:
        said += [f"not decidable from run {run.name}: {what} ({why})" for what, why in found.undecidable if run in kept]
    return kept, tuple(said)


def nominal_of(nominal: str | Path | Truth | Vehicle | np.ndarray, run: Observed) -> Nominal:
    """The nominal simulator; InputError if it cannot be read, or cannot be driven by the input of the run.

    nominal: a truth preset, its name or path, a parameter vector, shape (P,), or "none" for a foreign vehicle.
    """
    if isinstance(nominal, np.ndarray):
        if nominal.shape != (SIZE,):
            raise InputError(f"nominal: found an array of shape {nominal.shape}, expected ({SIZE},)")
        return Nominal("given parameters", nominal)
    if nominal == FOREIGN:
        return Nominal(FOREIGN, None)
    assert not isinstance(nominal, Vehicle), "a vehicle is the nominal of whole-vehicle recordings"
    if isinstance(nominal, Truth):
        known = Nominal(nominal.name, nominal.vector(), nominal.moving_mass_kg)
    else:
        name, input_name, simulator, mass_kg = read_simulator(nominal)
        known = Nominal(name, simulator.p, mass_kg, input_name)
    if run.input_name != known.input_name:
        raise InputError(
            f"run {run.name}: its input is {run.input_name}, but the nominal simulator {known.name} is driven "
            f'by {known.input_name}; expected one whose file says input = "{run.input_name}"; for a foreign '
            'vehicle use --nominal none, in Python nominal="none"'
        )
    return known
