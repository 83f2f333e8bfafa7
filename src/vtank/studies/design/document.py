"""Everything found about a plan as a document for JSON."""

from __future__ import annotations

from typing import Any

import numpy as np

from .advice import Remedy
from .bias import BiasMap
from .design import Design, minutes
from .estimators import METHODS
from .findings import Findings
from .trials import Trials
from .verdicts import Verdict

SCHEMA = "vtank-identifiability-1"


def document(found: Findings) -> dict[str, Any]:
    """Everything as it is written to JSON."""
    s = found.study
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "scenarios": [f.scenario.name for f in s.flown],
        "truth": s.truth.name,
        "model": s.model,
        "seed": s.seed,
        "minutes": s.information.minutes,
        "verdicts": found.sentences(),
        "parameters": {
            name: {"truth": float(true), "bound": float(bound), "relative": float(relative)}
            for name, true, bound, relative in zip(s.free, s.true, s.bound, s.relative, strict=True)
        },
        "correlation": s.correlation.tolist(),
        "condition": s.condition,
        "effects": {v.effect.name: _effect(v) for v in s.verdicts},
        "one_run_more": [_remedy(r) for r in found.remedies],
        "profiles": {
            p.name: {"deviations": p.deviations.tolist(), "drop": p.drop.tolist(),
                     "interval95": [_plain(x) for x in p.interval95]}
            for p in found.profiles
        },
    }  # fmt: skip
    if found.trials:
        content["estimators"] = _trials(found.trials)
    if found.bias:
        content["bias"] = _bias(found.bias)
    if found.design:
        content["design"] = _design(found.design) | ({"estimators": _trials(found.checked)} if found.checked else {})
    return content


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _effect(v: Verdict) -> dict[str, Any]:
    return {
        "standing": v.standing,
        "size": v.size,
        "unit": v.unit,
        "signature": v.signature,
        "left": v.left,
        "kept": v.kept,
        "seen_from": _plain(v.needed),
        "rivals": dict(v.rivals),
        "moves": dict(v.moves),
    }


def _remedy(r: Remedy) -> dict[str, Any]:
    rival = None if r.pair is None else r.pair.b.name
    return {
        "effect": r.verdict.effect.name,
        "rival": rival,
        "before": r.before,
        "repeat": r.repeat,
        "after": r.after,
        "experiment": r.experiment,
        "needs_speed_sensor": r.sensor,
    }


def _trials(t: Trials) -> dict[str, Any]:
    rows = {}
    for method in METHODS:
        bias, doubt = t.bias(method)
        columns = (bias, doubt, t.spread_over_bound(method), t.coverage(method))
        keys = ("bias", "bias_sd", "spread_over_bound", "coverage95")
        rows[method] = {
            name: {key: _plain(column[i]) for key, column in zip(keys, columns, strict=True)}
            for i, name in enumerate(t.names)
        }
    return {"seeds": t.seeds, **rows}


def _bias(b: BiasMap) -> dict[str, Any]:
    error = {method: [[[_plain(x) for x in w] for w in s] for s in b.error[method]] for method in METHODS}
    axes = {"noise_m": b.noise_m.tolist(), "rad_s": b.rad_s.tolist(), "parameters": list(b.names), "seeds": b.seeds}
    return {**axes, "amplitude_m": b.amplitude_m.tolist(), "median_error": error}


def _design(d: Design) -> dict[str, Any]:
    return {
        "runs": [
            {"count": count, "run": item.words, "minutes": item.information.minutes} for count, item in d.counted()
        ],
        "minutes_with_rest": minutes(d.items),
        "minutes_given": minutes(d.given),
        "relative_bounds": dict(zip(d.free, d.relative(d.items).tolist(), strict=True)),
        "gain": dict(zip(d.free, d.gain.tolist(), strict=True)),
        "gain_at_equal_time": dict(zip(d.free, d.gain_per_minute.tolist(), strict=True)),
    }
