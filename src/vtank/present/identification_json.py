"""What was identified, as a dictionary for JSON: SI units, NaN as null."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..estimate.comparison import Comparison
from ..estimate.maximum_likelihood import Estimate
from ..estimate.observed import CHANNELS
from ..estimate.paper.estimate import PaperEstimate
from ..record import Kind, jsonable
from .identification import NAMES, UNITS, by_name, moving_mass, plain_names

SCHEMA = "vtank.identification/1"
IDENTIFICATION = Kind("results of vtank identify", "identification.json", SCHEMA)


def identification(
    dataset: str, found: Sequence[Comparison], truth: Mapping[str, float] | None = None
) -> dict[str, Any]:
    """All models of one data set."""
    content: dict[str, Any] = {"schema": SCHEMA, "dataset": dataset}
    if truth:
        content["truth"] = {NAMES[slot]: value for slot, value in truth.items()}
    written: dict[str, Any] = jsonable(content | {"models": {c.model: _model(c) for c in found}})
    return written


def _model(c: Comparison) -> dict[str, Any]:
    return {
        "likelihood": _estimate(c.joint),
        "simulation": _estimate(c.simulated),
        "runs": {run.name: _run(c, run.name) for run in c.runs},
        "residuals": c.residuals,
        "validation": {
            "parameters_from": [*(run.name for run in c.runs), "simulation", "likelihood"],
            "runs": [run.name for run in c.runs],
            "free_run_rms": c.validation,
        },
    }


def _estimate(e: Estimate) -> dict[str, Any]:
    kind, noise = e.problem.runs[0].input_name, e.problem.noise
    content: dict[str, Any] = {
        "parameters": {
            NAMES[slot]: {
                "value": value,
                "sd": e.sd[slot],
                "interval95": e.interval95(slot),
                "unit": UNITS[kind][NAMES[slot]],
            }
            for slot, value in e.values.items()
        },
        "correlation": e.correlation,
        "noise": {
            "sd": dict(zip(CHANNELS, np.sqrt(noise.variance), strict=False)),
            "disturbance_m_s2": noise.sigma,
            "memory_s": noise.correlation_time,
            "coloured_m": noise.colour_sigma,
            "coloured_memory_s": noise.colour_time,
            "freedom": noise.freedom if np.isfinite(noise.freedom) else None,
        },
        "log_likelihood": e.log_likelihood,
        "converged": e.converged,
        "warnings": [plain_names(warning) for warning in e.warnings],
    }
    if kind == "thrust_N":
        content["moving_mass_kg"] = dict(zip(("value", "sd"), moving_mass(e), strict=True))
    return content


def _run(c: Comparison, name: str) -> dict[str, Any]:
    content: dict[str, Any] = {"likelihood": _estimate(c.single[name])["parameters"]}
    for estimator, by_run in c.paper.items():
        found = by_run[name]
        content[estimator] = _paper(found) if isinstance(found, PaperEstimate) else {"skipped": found}
    if name in c.linear:
        line = c.linear[name]
        content["linear"] = (
            {"skipped": line} if isinstance(line, str) else {**vars(line.model), "residual_m_s": line.statistics}
        )
    return content


def _paper(found: PaperEstimate) -> dict[str, Any]:
    return {"parameters": by_name(found), "unstable": found.unstable, "residual_m_s": found.statistics}
