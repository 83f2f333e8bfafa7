"""How much of the gap the diagnosed model of a whole vehicle closes on runs that were held back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ....diagnose.whole import Known, free_gap, slots_of
from ....plant import Vehicle
from ....record import Run
from ....record.table import table_of
from ..closed import Closed


def closed(vehicle: Vehicle, answer: Mapping[str, Any], known: Known, held: Sequence[Run]) -> Closed:
    """Gaps of nominal, refit, oracle and diagnosed model, over the noise of each channel [-]."""
    models: dict[str, dict[str, float]] = {"nominal": {}, "refit": known.refit}
    if known.oracle is not None:
        models["oracle"] = known.oracle
    if "model" in answer:
        models["diagnosed"] = slots_of(table_of(answer["model"], Path("model.toml")), "diagnosed")
    gaps = {name: free_gap(vehicle, held, known.noise, slots) for name, slots in models.items()}
    return replace(Closed(), **gaps)  # type: ignore[arg-type]
