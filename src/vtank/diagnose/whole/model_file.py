"""The diagnosed simulator of a whole vehicle as a file, and back: the vehicle, and each number that differs from it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InputError
from ...plant.vehicle import CORRECTED, Vehicle, load_vehicle
from ...record.run import Run
from ...record.table import Table, open_table
from ...resources import models_dir
from ...rigid.fit import Fit
from ...rigid.layout import AXES, Layout
from ...rigid.noise import first_noise
from ...rigid.recorded import Recorded
from ...rigid.recordings import record
from ..given import known_vehicle
from .budget import free_errors, spikes_of
from .model import Model
from .plant_file import plant_lines, read_plant

if TYPE_CHECKING:
    from .diagnosis import WholeDiagnosis


def model_text(diagnosis: WholeDiagnosis) -> str:
    """The file: verdict, axes, noise, and the slots that own parameters and effects moved from the vehicle file's."""
    selection = diagnosis.selection
    names, null = selection.layout.names, selection.layout.null
    values = {}
    for part, model in (("refit", selection.own), ("diagnosed", selection.best)):
        p = model.vector()
        values[part] = {names[i]: float(p[i]) for i in np.flatnonzero(p != null)}
    noise, verdict = selection.best.fit.noise, diagnosis.verdict
    lines = [
        "# A whole vehicle's simulator, found by vtank diagnose: what differs from the vehicle file.",
        f"schema = {_word(CORRECTED)}",
        f"vehicle = {_word(_called(diagnosis.vehicle.path))}",
        *_asked(selection.runs[0]),
        "",
        "[verdict]",
        f"kind = {_word(verdict.kind)}",
        f"effects = {_words(verdict.effects)}",
        f"places = {_words(verdict.places)}",
        f"probability = {verdict.probability:.4g}",
        "",
        "[noise]",
        f"sigma = [{', '.join(f'{s:.6g}' for s in selection.disturbance)}]  # of the disturbance, m/s2 and rad/s2",
        f"memory_s = [{', '.join(f'{s:g}' for s in noise.memory_s)}]",
    ]
    for part, changed in values.items():
        lines += ["", f"[{part}]", *(f"{_word(name)} = {value:.12g}" for name, value in changed.items())]
    if diagnosis.plant:
        lines += ["", *plant_lines(diagnosis.plant)]
    return "\n".join(lines) + "\n"


def _asked(run: Recorded) -> list[str]:
    """The axes that were asked about, if not all, and those that do not move."""
    still = np.isin(np.arange(6), run.still)
    some = {"axes": run.asked & np.any(~run.moves & ~still), "still": still}
    return [f"{key} = {_words([AXES[i] for i in np.flatnonzero(each)])}" for key, each in some.items() if each.any()]


def _called(path: Path) -> str:
    """A vehicle file as another file names it: one that comes with vtank by its name."""
    return path.stem if path.parent == models_dir() else str(path.resolve())


def _word(text: str) -> str:
    """Text as TOML has it."""
    return json.dumps(text, ensure_ascii=False)


def _words(texts: Sequence[str]) -> str:
    return f"[{', '.join(map(_word, texts))}]"


def is_whole(path: Path) -> bool:
    """Whether a model file is that of a whole vehicle, by its schema."""
    return path.is_file() and open_table(path).entries.get("schema") == CORRECTED


def _axes(table: Table, key: str) -> tuple[str, ...]:
    """Names of axes, none where the key is missing; InputError names the file, line and key of another name."""
    names = table.texts(key) if table.has(key) else ()
    for name in names:
        if name not in AXES:
            raise table.error(key, f"expected some of {', '.join(AXES)}, found '{name}'")
    return names


def predict(table: Table, run: Run) -> dict[str, Any]:
    """Root mean square errors by column of nominal, refit and diagnosed, simulated through stretches of a run.

    InputError where the file or the run cannot be used.
    """
    vehicle = _vehicle(table)
    axes, still = (_axes(table, key) for key in ("axes", "still"))
    if table.has("plant"):
        layout, runs, _ = read_plant(table.table("plant"), vehicle, axes).record([run.from_start()])
    else:
        layout, runs, _ = record([run.from_start()], vehicle, axes)
    runs = tuple(seen.keeping_still([AXES.index(axis) for axis in still]) for seen in runs)
    noise = replace(first_noise(runs), sigma=np.array(table.table("noise").numbers("sigma", 0.0, 1e6)))
    found: dict[str, dict[str, float]] = {}
    vectors = {"nominal": layout.null} | {part: _vector(layout, table.table(part)) for part in ("refit", "diagnosed")}
    fit = Fit(tuple(seen.ordered(vectors["diagnosed"]) for seen in runs), noise)
    models = {part: Model(fit, (), (), np.array([]), p) for part, p in vectors.items()}
    spikes = spikes_of(models["diagnosed"])
    for part, model in models.items():
        squares, counts = free_errors(model, spikes)
        for c, name in enumerate(layout.columns):
            if counts[:, c].sum():
                found.setdefault(name, {})[part] = float(np.sqrt(squares[:, c].sum() / counts[:, c].sum()))
    for c, name in enumerate(layout.columns):
        if name in found:
            found[name]["noise"] = float(np.sqrt(noise.variance[c]))
    return {"columns": found}


def slots_of(table: Table, part: str) -> dict[str, float]:
    """The slots that a part of the file, refit or diagnosed, moves from the vehicle file's, by name; InputError."""
    moved = table.table(part)
    return {name: moved.number(name) for name in moved.entries}


def _vehicle(table: Table) -> Vehicle:
    return known_vehicle(load_vehicle(table.file("vehicle", presets=(models_dir(), "vehicle"))))


def _vector(layout: Layout, table: Table) -> np.ndarray:
    p = layout.null.copy()
    for name in table.entries:
        if name not in layout.slots:
            if name.partition("@")[0] in ("latency", "skew", "scale", "bias", "earth") or "rotation" in name:
                continue  # of an instrument that this run has not
            raise InputError(f"{table.path}: {table.name}.{name}: no such parameter of {layout.vehicle.name}")
        p[layout.slot(name)] = table.number(name)
    return p
