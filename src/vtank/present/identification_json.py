"""What was identified, as a dictionary for JSON: SI units, NaN as null."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..estimate.comparison import Comparison, Linear
from ..estimate.maximum_likelihood import Estimate
from ..estimate.paper.estimate import PaperEstimate
from ..record.folder import Kind
from .identification import NAMES, UNITS, moving_mass, plain_names

SCHEMA = "vtank.identification/1"
IDENTIFICATION = Kind("results of vtank identify", "identification.json", SCHEMA)


def identification(
    dataset: str, found: Sequence[Comparison], truth: Mapping[str, float] | None = None
) -> dict[str, Any]:
    """All models of one data set."""
    content: dict[str, Any] = {"schema": SCHEMA, "dataset": dataset}
    if truth:
        content["truth"] = {NAMES[slot]: value for slot, value in truth.items()}
    return content | {"models": {c.model: _model(c) for c in found}}


def _model(c: Comparison) -> dict[str, Any]:
    labels = [*(run.name for run in c.runs), "simulation", "likelihood"]
    return {
        "likelihood": _estimate(c.joint),
        "simulation": _estimate(c.simulated),
        "runs": {run.name: _run(c, run.name) for run in c.runs},
        "residuals": [_plain(asdict(r)) for r in c.residuals],
        "validation": {
            "parameters_from": labels,
            "runs": [run.name for run in c.runs],
            "free_run_rms": _plain(c.validation),
        },
    }


def _estimate(e: Estimate) -> dict[str, Any]:
    kind, noise = e.problem.runs[0].input_name, e.problem.noise
    content: dict[str, Any] = {
        "parameters": {
            NAMES[slot]: {
                "value": _plain(value),
                "sd": _plain(e.sd[slot]),
                "interval95": _plain(e.interval95(slot)),
                "unit": UNITS[kind][NAMES[slot]],
            }
            for slot, value in e.values.items()
        },
        "correlation": _plain(e.correlation),
        "noise": {
            "sd": {unit: _plain(np.sqrt(v)) for unit, v in zip(("range_m", "position_m", "surge_m_s"), noise.variance)},  # noqa: B905
            "disturbance_m_s2": _plain(noise.sigma),
            "memory_s": _plain(noise.correlation_time),
        },
        "log_likelihood": _plain(e.log_likelihood),
        "converged": e.converged,
        "warnings": [plain_names(warning) for warning in e.warnings],
    }
    if kind == "thrust_N":
        mass, sd = moving_mass(e)
        content["moving_mass_kg"] = {"value": _plain(mass), "sd": _plain(sd)}
    return content


def _run(c: Comparison, name: str) -> dict[str, Any]:
    content: dict[str, Any] = {"likelihood": _estimate(c.single[name])["parameters"]}
    for estimator, by_run in c.paper.items():
        found = by_run[name]
        content[estimator] = _paper(found) if isinstance(found, PaperEstimate) else {"skipped": found}
    if name in c.linear:
        line = c.linear[name]
        content["linear"] = _linear(line) if isinstance(line, Linear) else {"skipped": line}
    return content


def _paper(found: PaperEstimate) -> dict[str, Any]:
    p = found.parameters
    values = {"alpha": p.alpha_per_m, "beta": p.beta_m_per_rev2, "gamma": p.gamma_per_rev, "tau": p.tau_s}
    return {
        "parameters": _plain(values),
        "unstable": list(found.unstable),
        "residual_m_s": _plain(asdict(found.statistics)),
    }


def _linear(found: Linear) -> dict[str, Any]:
    return {**_plain(asdict(found.model)), "residual_m_s": _plain(asdict(found.statistics))}


def _plain(value: Any) -> Any:
    """Lists, numbers and None in place of arrays, numpy scalars and what is not finite."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
