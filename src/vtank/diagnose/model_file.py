"""The diagnosed simulator as a file, and back.

The file is a truth preset: `[lumped]` and `[effects.*]` are the diagnosed simulator, so that a scenario or
`vtank run --truth MODEL.toml` switches the diagnosed effect on in the tank. Beside them stand the nominal, the refit,
the noise level and the verdict. Keys carry their unit; what drag and thrust are divided by is the moving mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import remainder, tau
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..effects.catalogue import CATALOGUE
from ..effects.effect import Effect
from ..errors import InputError
from ..estimate.observed import CHANNELS, Observed
from ..estimate.problem import Noise
from ..plant.formula import law_lines, read_law
from ..plant.parameters import slot, switched_on
from ..plant.truth import key_of
from ..record.table import Table, open_table
from .holdout import START_WINDOW_S, Model, Prediction, Target, model_of, rms, target_of, targets_of
from .simulator_file import OWN, simulator
from .thinning import straightened

if TYPE_CHECKING:
    from .diagnosis import Diagnosis
    from .laws.found import Law

SCHEMA = "vtank.model/1"
FEWEST = 10  # measurements that a prediction is compared with at least; a choice
SCATTER_REV_S = 0.5  # [rev/s] by which the tachometer may read past a limit; ten times its usual noise, a guess
LEAST_LIMIT_REV_S = 20.0  # [rev/s] largest propeller speed granted in the tank, the presets' (models/truths)


@dataclass(frozen=True)
class ModelFile:
    """What a model file holds.

    Attributes:
        input_name: the input's column.
        nominal, refit, diagnosed: the three simulators.
        noise: noise level.
        verdict: kind, effects, class, channel, probability.
        straight: whether the input went straight from sample to sample; else each is held to the next.
    """

    input_name: str
    nominal: Model
    refit: Model
    diagnosed: Model
    noise: Noise
    verdict: dict[str, Any]
    straight: bool = False


def model_text(diagnosis: Diagnosis, law: Law | None = None) -> str:
    """The file's text; law: one of the diagnosis' laws that is accepted into the diagnosed simulator."""
    selection, v = diagnosis.selection, diagnosis.verdict
    runs, nominal = selection.setting.runs, selection.setting.nominal
    effects, name = v.fit.hypothesis.effects, runs[0].input_name
    limit = max((float(np.max(np.abs(run.input))) for run in runs if name == "n_rev_s"), default=0.0)
    limit = LEAST_LIMIT_REV_S if limit < LEAST_LIMIT_REV_S + SCATTER_REV_S else np.ceil(limit)
    said = ", ".join(v.effects)
    refit, diagnosed = map(model_of, (selection.refit, v.fit))
    given = refit if selection.setting.foreign else Model(nominal)  # no simulator is given but the recordings' own
    if law:
        diagnosed, effects = model_of(law.fit), law.fit.hypothesis.effects
    lines = [
        "# A simulator found by vtank diagnose" + "; it can be used wherever a truth preset can." * (name == "n_rev_s"),
        "# [lumped] and [effects] are the diagnosed simulator; nominal, refit, noise and verdict stand beside it.",
        f'schema = "{SCHEMA}"',
        'name = "diagnosed"',
        f'source = "vtank diagnose of {len(runs)} run{"s" * (len(runs) > 1)}: {v.kind}{": " * bool(said)}{said}"',
        f'input = "{name}"',
        *(['between_samples = "straight"'] if runs[0].straight else []),
        *([f"n_limit_rev_s = {limit:g}"] if name == "n_rev_s" else []),
        *([f"moving_mass_kg = {diagnosis.mass_kg:.12g}"] if diagnosis.mass_kg else []),
        "",
        "[lumped]",
        *_own(diagnosed.p, name, effects),
        *_effects(diagnosed, name, "", effects),
        *(["", *law_lines(law.formula)] if law else ()),
        "",
        "[nominal]",
        *_own(given.p, name),
        *_effects(given, name, "nominal."),
        "",
        "[refit]",
        *_own(refit.p, name),
        *_effects(refit, name, "refit."),
        "",
        "[noise] # standard deviations of measurements, turbulence and coloured errors, and their memories",
        *_noise(targets_of(selection.setting)[0].noise, runs),
        "",
        "[verdict]",
        f'kind = "{v.kind}"',
        f"effects = {_texts(v.effects)}",
        f"class = {_texts(v.rivals)}",
        f'channel = "{v.channel or ""}"',
        f"probability = {v.probability:.4f}",
    ]
    return "\n".join(lines) + "\n"


def _own(p: np.ndarray, input_name: str, effects: Sequence[Effect] = ()) -> list[str]:
    """Drag, thrust gain, loss, lag and what else is the simulator's own; at zero where they are written as effects."""
    apart = {name for effect in effects for name in effect.slots()}
    return [f"{key} = {0.0 if name in apart else p[slot(name)]:.12g}" for name, key in OWN[input_name].items()]


def _effects(model: Model, input_name: str, prefix: str, effects: Sequence[Effect] = ()) -> list[str]:
    """Tables of the effects that are not at their null values, and of those named."""
    lines = []
    apart = [effect for effect in switched_on(model.p) if not {*OWN[input_name]} & {*effect.slots()}]
    for effect in CATALOGUE:
        if effect in effects or effect in apart:
            lines += ["", f"[{prefix}effects.{effect.name}]"]
            for name, q in zip(effect.slots(), effect.parameters, strict=True):
                own = " # of the first run; every run has its own" if q.per_run else ""
                value = float(model.p[slot(name)])
                if q.unit == "rad" and abs(value) > q.bounds[1]:  # a fit may go round more than once
                    value = remainder(value, tau)
                lines.append(f"{key_of(name, input_name)} = {value:.12g}{own}")
    return lines


def _noise(noise: Noise, runs: Sequence[Observed]) -> list[str]:
    measured = {kind for run in runs for kind in run.first}
    lines = [f"{key} = {np.sqrt(noise.variance[kind]):.6g}" for key, kind in CHANNELS.items() if kind in measured]
    lines += [f"turbulence_m_s2 = {noise.sigma:.6g}", f"turbulence_time_s = {noise.correlation_time:.6g}"]
    if noise.colour_sigma > 0.0:
        key = "coloured_m" if any(run.has_position for run in runs) else "coloured_m_s"
        lines += [f"{key} = {noise.colour_sigma:.6g}", f"coloured_time_s = {noise.colour_time:.6g}"]
    return lines


def _texts(names: Sequence[str]) -> str:
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"


def read_model(path: Path | str | Table) -> ModelFile:
    """The model file at `path`, or one that is open already; InputError names file and key of what is wrong."""
    file = path if isinstance(path, Table) else open_table(Path(path))
    if file.text("schema", "") != SCHEMA:
        raise file.error("schema", f'expected "{SCHEMA}", a model written by vtank diagnose')
    name = file.text("input")
    if name not in OWN:
        raise file.error("input", f"expected one of {', '.join(OWN)}, found {name!r}")
    return ModelFile(
        name,
        simulator(file.table("nominal"), name),
        simulator(file.table("refit"), name),
        simulator(file.table("lumped"), name, file.table("effects"), read_law(file)),
        _read_noise(file.table("noise")),
        file.table("verdict").entries,
        file.choice("between_samples", ("held", "straight"), "held") == "straight",
    )


def predict_gaps(models: ModelFile, *runs: Observed) -> dict[str, Any]:
    """How well the three simulators predict runs from their recorded input: {"unit", "rms": {...}, "floor"}.

    runs: one, or the stretches of one (`observed.stretches`); floor: expected error of a model that knows everything
    but measurement noise and turbulence. InputError where a run has another input or is too short.
    """
    targets = [_target(models, run) for run in runs]
    named = {"nominal": models.nominal, "refit": models.refit, "diagnosed": models.diagnosed}
    squares = [np.sum(Prediction(models.diagnosed, target).floor_squares(), axis=0) for target in targets]
    return {
        "unit": "m" if runs[0].has_position else "m/s",
        "rms": {name: rms([Prediction(model, target).errors() for target in targets]) for name, model in named.items()},
        "floor": float(np.sqrt(np.mean(np.concatenate(squares)))),
    }


def _target(models: ModelFile, run: Observed) -> Target:
    if run.input_name != models.input_name:
        raise InputError(f"run '{run.name}': input {run.input_name}, but the model was found with {models.input_name}")
    target = target_of(straightened(run) if models.straight else run, models.noise)
    if np.sum(target.scored) < FEWEST:
        found = f"expected at least {FEWEST} measurements after its first {START_WINDOW_S:g} s to compare with"
        raise InputError(f"run '{run.name}': {found}; found {np.sum(target.scored)}")
    return target


def _read_noise(table: Table) -> Noise:
    table.check_keys(
        (*CHANNELS, "turbulence_m_s2", "turbulence_time_s", "coloured_m", "coloured_m_s", "coloured_time_s")
    )
    known = [table.positive(key) for key in CHANNELS if key in table.entries]
    if not known:
        raise table.error("range_m", f"missing; expected at least one of {', '.join(CHANNELS)}")
    variance = tuple(table.number(key, known[0]) ** 2 for key in CHANNELS)
    key = "coloured_m_s" if "coloured_m_s" in table.entries else "coloured_m"
    coloured = table.number(key, 0.0), table.number("coloured_time_s", 1.0)
    return Noise(variance, table.number("turbulence_m_s2"), table.positive("turbulence_time_s"), *coloured)
