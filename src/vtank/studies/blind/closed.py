"""How much of the gap is closed on runs that were held back.

Against the oracle the gaps are free of noise (`held_out.py`). The stated interval is a statement about what
`vtank predict` will show on new runs of the same experiments, noise and all, so it is checked with that very command's
code, the floor being what the true model leaves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...effects import PARAMETERS
from ...plant import vector
from ...record import read_run
from ...record.table import table_of
from .held_out import HeldOut, gaps


@dataclass(frozen=True)
class Closed:
    """Held-out gaps of a case.

    Attributes:
        nominal, refit, oracle, diagnosed: root mean square over all held-out runs, free of noise; NaN if unknown [m].
        interval: stated 90 % interval of the fraction closed, if any.
        realised: fraction closed on new runs of the same experiments, noise and all; None where nothing was reducible.
    """

    nominal: float = float("nan")
    refit: float = float("nan")
    oracle: float = float("nan")
    diagnosed: float = float("nan")
    interval: tuple[float, float] | None = None
    realised: float | None = None

    @property
    def fraction(self) -> float:
        """Share of what the oracle closes of the refit's gap that the diagnosis closes."""
        return (self.refit - self.diagnosed) / (self.refit - self.oracle)

    @property
    def reducible(self) -> bool:
        """Whether the oracle closes a gap worth the name, and the diagnosis left a model."""
        known = np.isfinite([self.refit, self.oracle, self.diagnosed]).all()
        return bool(known) and self.refit > 1.1 * self.oracle

    @property
    def covered(self) -> bool | None:
        """Whether the stated interval holds the realised fraction; None where one of them is missing."""
        if self.interval is None or self.realised is None:
            return None
        return self.interval[0] <= self.realised <= self.interval[1]


def closed(case: str, truth: Mapping[str, Any], answer: Mapping[str, Any], folder: Path) -> Closed:
    """The gaps of one case; folder: where the truths lie."""
    known: dict[str, Any] = {name: _together(values) for name, values in truth["held_out"].items()}
    if "model" not in answer:
        return Closed(**known)
    from ...diagnose import ModelFile, read_model

    models: ModelFile = read_model(table_of(answer["model"], Path("model.toml")))
    files = [folder / "held_out" / case / file for file in sorted(truth["held_out_files"])]
    count = truth["experiment"]["runs"]
    standoff = truth["experiment"]["standoff_m"][count:]
    held = [HeldOut(read_run(file), metres) for file, metres in zip(files, standoff, strict=True)]
    diagnosed = _together(gaps(held, models.diagnosed.p, models.diagnosed.per_run))
    shrink = answer["document"].get("shrink") or {}
    stated = shrink.get("interval90")
    interval = (float(stated[0]), float(stated[1])) if stated else None
    realised = _realised(models, truth["slots"][count:-1], files[:-1]) if interval else None
    return Closed(**known, diagnosed=diagnosed, interval=interval, realised=realised)


def _together(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _realised(models: Any, slots: Sequence[Mapping[str, float]], files: Sequence[Path]) -> float | None:
    """Fraction closed on these runs, by the predictor of `vtank predict`."""
    from ...diagnose import Model, Prediction, fraction_closed, rms, target_of
    from ...estimate import observe

    errors: list[list[np.ndarray]] = [[], [], []]
    for file, true in zip(files, slots, strict=True):
        target = target_of(observe(read_run(file)), models.noise)
        own = [name for name in true if name in PARAMETERS and PARAMETERS[name].per_run]
        truth = Model(vector(dict(true)), tuple(own))
        for i, model in enumerate((models.refit, models.diagnosed, truth)):
            errors[i].append(Prediction(model, target).errors())
    refit, diagnosed, floor = map(rms, errors)
    return fraction_closed(refit, diagnosed, floor)
