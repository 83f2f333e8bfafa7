"""What a user calls: runs loaded or simulated, models identified, gaps diagnosed, recordings predicted."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .blas import one_blas_thread
from .errors import InputError
from .record import Run, meant, read_dataset, read_run
from .resources import NOMINAL

if TYPE_CHECKING:
    from .diagnose.whole.identified import WholeEstimate
    from .diagnosed import Diagnosis, WholeDiagnosis
    from .effects.effect import Effect
    from .estimate.maximum_likelihood import Estimate
    from .plant.truth import Truth
    from .plant.vehicle import Vehicle

Given = Run | Iterable[Run | Path | str] | Path | str  # runs, or where they lie


def load(path: Path | str) -> tuple[Run, ...]:
    """The runs of a data set, a folder of CSV files, or of one CSV file.

    Runs come in natural order of their names. InputError names file, line and column of what breaks the rules for
    recordings; a truth beside the runs is never opened.
    """
    return read_dataset(path).runs


def _loaded(runs: Given) -> tuple[Run, ...]:
    """Runs that are given as such or by where they lie, one alone or several; InputError where it is something else."""
    given = list[Run]()
    for some in [runs] if isinstance(runs, Run | str | Path) else runs:
        given += load(some) if isinstance(some, str | Path) else [some]
    for run in given:
        if not isinstance(run, Run):
            raise InputError(f"runs: found {type(run).__name__}, expected runs, as vt.load gives them, or their folder")
        if not np.all(np.diff(run.time_s) > 0.0) or not np.all(np.isfinite(run.time_s)):
            raise InputError(f"run {run.name}: time_s: expected finite times, each later than the one before")
    return tuple(given)


def _whole(name: str, value: int | None, least: int) -> None:
    """InputError for an argument that is no whole number of at least so much; None is one that was not given."""
    if value is not None and (not isinstance(value, int | np.integer) or value < least):
        raise InputError(f"{name} {value!r}: expected a whole number of at least {least}")


def run(
    *scenarios: Path | str,
    seed: int | None = None,
    truth: str | None = None,
    settings: Sequence[str] = (),
    simulator: Literal["tank", "surge"] = "tank",
    threads: int = 1,
    out: Path | str | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[Run, ...]:
    """Simulate scenarios, by name or path of a TOML file, and return what was recorded.

    seed: of all noise (default: the first scenario's). truth: preset or path of one (default: each scenario's).
    settings: KEY=VALUE laid over all scenarios, such as "effects.linear_drag.c_per_s=0.08".
    simulator: the MuJoCo tank, or the surge equation alone, a hundred times as fast.
    out: folder of a data set to write, with the truth in a file of its own.
    progress: told the share that is done, 0 to 1. InputError for bad input and where the vehicle strikes a wall.
    """
    from .experiment.fly import fly, plan_all, write_results
    from .experiment.whole_scenario import fly_scenarios, is_whole, write_flights
    from .record.dataset import refuse_strangers

    if simulator not in ("tank", "surge"):
        raise InputError(f"simulator {simulator!r}: expected tank or surge")
    if isinstance(settings, str):
        raise InputError(f"settings {settings!r}: found a text, expected a list of KEY=VALUE")
    _whole("seed", seed, 0)
    _whole("threads", threads, 1)
    if not scenarios:
        raise InputError("no scenario: nothing can be simulated")
    if out is not None:
        refuse_strangers(Path(out))
    if any(map(is_whole, scenarios)):
        if truth or simulator != "tank":
            raise InputError(
                "truth and simulator go with experiments of one axis; expected neither for a whole vehicle"
            )
        whole, flights = fly_scenarios(scenarios, settings, seed, progress)
        if out is not None:
            write_flights(Path(out), whole, flights, settings)
        return tuple(flown.run for flown in flights)
    results = fly(plan_all(scenarios, settings, seed, truth), simulator, threads, progress)
    if out is not None:
        write_results(out, results, simulator, settings)
    return tuple(result.run for result in results)


@one_blas_thread
def identify(
    runs: Given,
    model: str = "II",
    process_noise: bool | None = None,
    nominal: str | Path | Vehicle | None = None,
    axes: Sequence[str] | None = None,
) -> Estimate | WholeEstimate:
    """Maximum-likelihood estimate of a surge model from all runs together, with `values` and `sd` by parameter, SI.

    runs: or the folder, or file, in which they lie.
    model: "I" alpha [1/m], beta [m/rev2]; "II" and thrust_lag.tau [s]; "III" and thrust_loss.gamma [1/rev].
    process_noise: whether turbulence is allowed for (default: where the residuals ask for it).
    nominal: of recordings of a whole vehicle, its file; what is found are then its own parameters by place, those of
    the `axes` that are asked about (default: all). InputError where runs do not go together or cannot carry the model.
    """
    from .diagnose.given import vehicle_of
    from .estimate.maximum_likelihood import MODELS, identify
    from .estimate.observed import observe, stretches

    runs = _loaded(runs)
    vehicle = vehicle_of(nominal, runs, axes)
    if vehicle is not None:
        from .diagnose.whole.identified import identify as identify_whole

        return identify_whole(runs, vehicle, axes)
    if model not in MODELS:
        raise InputError(f"no model {model!r}{meant(model, MODELS)}")
    return identify([observe(run) for run in stretches(runs)], model, process_noise=process_noise)


@one_blas_thread
def diagnose(
    runs: Given,
    nominal: str | Path | Truth | Vehicle | np.ndarray | None = None,
    seed: int = 0,
    effects: Sequence[str] | None = None,
    progress: Callable[[str], None] | None = None,
    axes: Sequence[str] | None = None,
    against: Given | None = None,
) -> Diagnosis | WholeDiagnosis:
    """Where runs and a nominal simulator part, which effect causes it, and how far the gap shrinks once it is added.

    runs: or the folder, or file, in which they lie.
    nominal: a truth preset, its name or the path of its TOML file, a parameter vector, shape (P,), or "none" for a
    foreign vehicle, whose own refit is the simulator; left out, the Phoenix of paper-ii, and it is said. A vehicle, its
    name or the path of its TOML file, is the simulator of a recording of a whole vehicle, with several inputs or axes.
    effects: to consider (default: the whole catalogue); of a whole vehicle by name, or by name and place.
    axes: of a whole vehicle, that are asked about (default: all that something tells of).
    seed: of the simulated new data. progress: told in a few words what is being done.
    against: runs that a simulator of any make has flown, or their folder: a plant that is fitted to them is the
    nominal; of a whole vehicle, whose file gives layout and first guesses, or of one axis, with no other nominal.
    InputError where runs do not go together, hold too little, or tell no parameters apart, and where the plant is too
    unlike the simulator.
    """
    from .diagnose import diagnosis
    from .diagnose.against import plant_of
    from .diagnose.given import nominal_of, observed, vehicle_of
    from .diagnosed import Diagnosis, WholeDiagnosis

    _whole("seed", seed, 0)
    runs, folder = _loaded(runs), str(against) if isinstance(against, str | Path) else "the runs given"
    simulated = None if against is None else _loaded(against)
    if simulated == ():
        raise InputError("against: no runs of a simulator; expected at least one")
    vehicle = vehicle_of(nominal, runs, axes)
    if vehicle is not None:
        from .diagnose.whole import diagnose as diagnose_whole

        whole = diagnose_whole(runs, vehicle, axes, effects, progress, simulated, folder)
        return WholeDiagnosis(**{field.name: getattr(whole, field.name) for field in fields(whole)})
    seen, plant = observed(runs), None
    if simulated is None:
        compared = nominal_of(NOMINAL if nominal is None else nominal, seen[0])
    else:
        plant = plant_of(simulated, seen, nominal, folder, progress)
        compared = plant.nominal
    found = diagnosis.diagnose(seen, compared.p, seed, effects, progress, plant.likeness if plant else None)
    known = {field.name: getattr(found, field.name) for field in fields(found)}
    named = {"nominal": compared.name, "by_default": nominal is None and plant is None, "mass_kg": compared.mass_kg}
    return Diagnosis(**known | named)


@one_blas_thread
def predict(model: Path | str, run: Run | Path | str) -> dict[str, Any]:
    """How well the simulators of a model file, written by `Diagnosis.save`, predict a run from its input alone.

    Returns {"unit": "m" or "m/s", "rms": {"nominal", "refit", "diagnosed"}, "floor"}: root mean square errors, and
    what noise and turbulence leave to a model that knows everything else. Of a whole vehicle {"columns": {column:
    {"nominal", "refit", "diagnosed", "noise"}}}, each in the column's unit. InputError where model or run cannot be
    read, do not go together, or hold too little.
    """
    from .diagnose.model_file import predict_gaps, read_model
    from .diagnose.whole import model_file as whole_file
    from .estimate.observed import observe, stretches
    from .record.table import open_table

    (given,) = _loaded(run) if isinstance(run, Run) else (read_run(run),)
    if whole_file.is_whole(Path(model)):
        return whole_file.predict(open_table(Path(model)), given)
    return predict_gaps(read_model(model), *map(observe, stretches([given])))


def effects() -> tuple[Effect, ...]:
    """The catalogue: every effect that a simulator may leave out, with law, parameters, units, bounds and source."""
    from .effects.catalogue import CATALOGUE

    return CATALOGUE
