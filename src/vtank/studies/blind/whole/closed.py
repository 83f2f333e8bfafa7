"""How much of the gap the diagnosed model of a whole vehicle closes on runs that were held back."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ....diagnose.whole.budget import free_errors
from ....diagnose.whole.model import Model
from ....diagnose.whole.model_file import slots_of
from ....diagnose.whole.selection import bare
from ....errors import InputError
from ....plant.vehicle import Vehicle
from ....record import Run
from ....record.table import open_table
from ....rigid.layout import Layout
from ....rigid.noise import first_noise
from ....rigid.recorded import Recorded, record
from ..closed import Closed
from .fits import RUNAWAY, Fits


def closed(vehicle: Vehicle, answer: Mapping[str, Any], fits: Fits, held: Sequence[Run]) -> Closed:
    """Gaps of nominal, refit, oracle and diagnosed model, over the noise of each channel [-]."""
    models: dict[str, dict[str, float]] = {"nominal": {}, "refit": fits.refit}
    if fits.oracle is not None:
        models["oracle"] = fits.oracle
    if "model" in answer:
        with tempfile.TemporaryDirectory() as room:
            path = Path(room) / "model.toml"
            path.write_text(answer["model"], encoding="utf-8")
            models["diagnosed"] = slots_of(open_table(path), "diagnosed")
    layout, runs, _ = record(held, vehicle)
    gaps = {name: _gap(layout, runs, fits, slots) for name, slots in models.items()}
    return replace(Closed(), **gaps)  # type: ignore[arg-type]


def _gap(layout: Layout, runs: tuple[Recorded, ...], fits: Fits, slots: Mapping[str, float]) -> float:
    """Root mean square over columns of the error of free simulation, in deviations of their noise, which is taken off.

    The same filter noise for all models; a slot of an instrument that these runs have not is passed over.
    """
    noise = first_noise(runs)
    fit = bare(runs, layout, replace(noise, sigma=fits.noise.sigma * runs[0].moves, memory_s=fits.noise.memory_s))
    p = layout.vector({name: value for name, value in slots.items() if name in layout.slots})
    try:
        squares, counts = free_errors(Model(fit, (), (), np.array([]), p))
    except InputError:  # the simulation diverges
        return RUNAWAY
    seen = counts.sum(axis=0) > 0
    mean = (squares.sum(axis=0) / np.maximum(counts.sum(axis=0), 1) / noise.variance)[seen]
    return min(float(np.sqrt(max(float(np.mean(mean)) - 1.0, 0.0))), RUNAWAY)
