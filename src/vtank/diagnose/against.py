"""Diagnosis of one axis against a simulator of any make, of which there is nothing but runs that it has flown.

Drag and thrust, and every effect of the catalogue that these runs ask for, are fitted to them as to those of a foreign
vehicle; what is found takes the place of the nominal. Before that, the runs are given the recordings' sensor noise: a
simulator has none, and what the recordings could not show need not be met. An effect that the misfit left over would
feign there is then in the plant already, and finds nothing in recordings of the same noise; and what has to be named
is larger than what the plant misses, or nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..effects.catalogue import CATALOGUE
from ..errors import InputError
from ..estimate.observed import CHANNELS, Observed
from ..plant.surge import LINEAR_INPUT
from ..record import Run
from ..rigid.thinned import scatter
from .evidence import Fitted
from .foreign import explained
from .given import Nominal, observed
from .holdout import Prediction, Target, model_of, rms, target_of
from .likeness import Likeness

SEED = 0  # of the sensor noise


@dataclass(frozen=True, eq=False)
class Plant:
    """A simulator, as the surge equation has it: the nominal that stands for it, and how like it that is."""

    nominal: Nominal
    likeness: Likeness


def plant_of(
    runs: Sequence[Run], recorded: Sequence[Observed], nominal: object, folder: str, say: Callable[[str], None] | None
) -> Plant:
    """The plant of a simulator's runs, to diagnose recordings against.

    nominal: what else was named. InputError where that is a simulator, too, and where no plant is like the runs.
    """
    if nominal is not None:
        raise InputError(
            f"nominal {nominal}: against {folder}, the simulator there is the nominal; expected none beside it, or the "
            "file of a whole vehicle, vehicle.toml"
        )
    simulated = observed(runs)
    first, heard = simulated[0], recorded[0]
    if first.input_name != heard.input_name:
        raise InputError(
            f"{folder}: run {first.name}: its input is {first.input_name}, that of recording {heard.name} is "
            f"{heard.input_name}; simulator and recordings need the same input"
        )
    if say:
        say("a plant for the simulator")
    steady = [e.name for e in CATALOGUE if not e.outliers and not any(q.per_run for q in e.parameters)]
    selection = explained(_noisy(simulated, recorded), steady)
    likeness = _likeness(selection.best, [target_of(run, selection.setting.noise) for run in simulated], folder)
    p = selection.best.vector()
    if first.input_name != "thrust_N":  # a share of 1 means a measured force
        p[LINEAR_INPUT] = min(p[LINEAR_INPUT], np.nextafter(1.0, 0.0))
    return Plant(Nominal(f"a plant fitted to {folder}", p), likeness.checked())


def _likeness(fit: Fitted, targets: Sequence[Target], folder: str) -> Likeness:
    """Error of simulation after each run's start, and what the scored column does."""
    error = rms([Prediction(model_of(fit), target).errors() for target in targets])
    values = [target.run.value[target.scored] for target in targets]
    moves = rms([value - value.mean() for value in values])
    kind = targets[0].run.kind[targets[0].scored][0]
    column = next(name for name, number in CHANNELS.items() if number == kind)
    own = tuple((name, None, value) for name, value in fit.values.items())
    runs = tuple(target.run.name for target in targets)
    return Likeness(folder, runs, {column: {"error": error, "moves": moves}}, error / max(moves, 1e-12), own)


def _noisy(simulated: Sequence[Observed], recorded: Sequence[Observed]) -> list[Observed]:
    """The simulator's runs as the recordings' instruments would have read them."""
    kinds = {kind for run in recorded for kind in run.first}
    sd = {kind: np.median([scatter(run.value[run.kind == kind]) for run in recorded if kind in run.first])
          for kind in kinds}  # fmt: skip
    rng, least = np.random.default_rng(SEED), min(sd.values())
    found = []
    for run in simulated:
        noise = np.array([sd.get(int(kind), least) for kind in run.kind])
        found.append(replace(run, value=run.value + noise * rng.standard_normal(run.value.size)))
    return found
