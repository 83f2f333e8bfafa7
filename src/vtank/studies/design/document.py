"""Everything found about a plan as a document for JSON."""

from __future__ import annotations

from typing import Any

from ...record import jsonable
from .advice import Remedy
from .bias import BiasMap
from .design import Design, minutes
from .estimators import METHODS
from .findings import Findings
from .trials import Trials
from .verdicts import Verdict

SCHEMA = "vtank-identifiability-1"


def document(found: Findings) -> dict[str, Any]:
    """Everything as it is written to JSON; a number that is not finite is null."""
    s = found.study
    parts: dict[str, Any] = {
        "estimators": found.trials and _trials(found.trials),
        "bias": found.bias and _bias(found.bias),
        "design": found.design and _design(found.design, found.checked),
    }
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "scenarios": [f.scenario.name for f in s.flown],
        "truth": s.truth.name,
        "model": s.model,
        "seed": s.seed,
        "minutes": s.information.minutes,
        "verdicts": found.sentences(),
        "parameters": {
            name: dict(zip(("truth", "bound", "relative"), values, strict=True))
            for name, *values in zip(s.free, s.true, s.bound, s.relative, strict=True)
        },
        "correlation": s.correlation,
        "condition": s.condition,
        "effects": {v.effect.name: _effect(v) for v in s.verdicts},
        "one_run_more": [_remedy(r) for r in found.remedies],
        "profiles": {
            p.name: {"deviations": p.deviations, "drop": p.drop, "interval95": p.interval95} for p in found.profiles
        },
    }
    written: dict[str, Any] = jsonable(content | {name: part for name, part in parts.items() if part})
    return written


def _effect(v: Verdict) -> dict[str, Any]:
    plain = {name: getattr(v, name) for name in ("standing", "size", "unit", "signature", "left", "kept")}
    return {**plain, "seen_from": v.needed, "rivals": dict(v.rivals), "moves": dict(v.moves)}


def _remedy(r: Remedy) -> dict[str, Any]:
    plain = {name: getattr(r, name) for name in ("before", "repeat", "after", "experiment")}
    rival = None if r.pair is None else r.pair.b.name
    return {"effect": r.verdict.effect.name, "rival": rival, **plain, "needs_speed_sensor": r.sensor}


def _trials(t: Trials) -> dict[str, Any]:
    keys = ("bias", "bias_sd", "spread_over_bound", "coverage95")
    columns = {m: (*t.bias(m), t.spread_over_bound(m), t.coverage(m)) for m in METHODS}
    rows = {m: {name: dict(zip(keys, row, strict=True)) for name, *row in zip(t.names, *columns[m], strict=True)}
            for m in METHODS}  # fmt: skip
    return {"seeds": t.seeds, **rows}


def _bias(b: BiasMap) -> dict[str, Any]:
    axes = {"noise_m": b.noise_m, "rad_s": b.rad_s, "parameters": b.names, "seeds": b.seeds}
    return {**axes, "amplitude_m": b.amplitude_m, "median_error": {m: b.error[m][:, :, 0] for m in METHODS}}


def _design(d: Design, checked: Trials | None) -> dict[str, Any]:
    bounds = {"relative_bounds": d.relative(d.items), "gain": d.gain, "gain_at_equal_time": d.gain_per_minute}
    return {
        "runs": [{"count": n, "run": item.words, "minutes": item.information.minutes} for n, item in d.counted()],
        "minutes_with_rest": minutes(d.items),
        "minutes_given": minutes(d.given),
        **{name: dict(zip(d.free, values, strict=True)) for name, values in bounds.items()},
        **({"estimators": _trials(checked)} if checked else {}),
    }
