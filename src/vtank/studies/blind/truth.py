"""What is sealed about a case: its causes, how visible they are, and what an oracle makes of the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...effects import BY_NAME, CATALOGUE, Effect, sonar_multipath
from ...experiment import Plan, Result
from ...experiment import noise as streams
from ...experiment.flight import MULTIPATH
from ...plant import NAMES
from .case import Case, given, label, tied
from .cause import Cause
from .held_out import HeldOut, gaps
from .refit import Fit, Recording, own_parameters, parameters, refit
from .replay import Replay
from .rivals import best_pair
from .seal import TRUTH_SCHEMA
from .shares import shares
from .whitening import whitener

Array = NDArray[np.float64]


def truth_of(case: Case, results: Sequence[Result], separations: bool = True) -> tuple[dict[str, Any], list[HeldOut]]:
    """The truth of a case as a document, and its held-out runs."""
    count, nominal = case.experiment.given, case.nominal.vector()
    clean = [recording(case, result, noisy=False) for result in results[:count]]
    noisy = [recording(case, result, noisy=True) for result in results[:count]]
    left = refit(clean, case.truth.vector())
    document: dict[str, Any] = {
        "schema": TRUTH_SCHEMA,
        "kind": case.kind,
        "label": label(case),
        "causes": [_cause(case, cause) for cause in case.causes],
        "withheld": list(case.withheld),
        "slots": [_slots(result.plan) for result in results],
        "experiment": _experiment(case),
        "d": left.size,
        "d_each": [_without(case, clean, i).size for i in range(len(case.causes))],
        "d_parameters": refit(clean, nominal, free=()).size,
        "wanted": list(case.wanted),
        "hull_m": [_hull(result) for result in results[:count]],
    }
    if separations and label(case) == "unknown":
        document["pair"] = best_pair(case, clean, left)
    held = [HeldOut.of(case, result) for result in results[count:]]
    known = [_masked(case, r) for r in noisy]
    refitted = refit(known, case.truth.vector())
    document["budget"] = shares(case, results[:count], known, refitted)
    document["held_out"] = _held_out(case, known, refitted, held)
    return document, held


def _cause(case: Case, cause: Cause) -> dict[str, Any]:
    """A cause as plain data, with the formula and windows [run, from s, to s] of what no catalogue has.

    channels: in which it acts, and in which something would do the very same.
    """
    out: dict[str, Any] = {"name": cause.name, "size": cause.size}
    if cause.known:
        effect = BY_NAME[cause.name]
        same = {other.channel for other in CATALOGUE if tied(other.name) == tied(cause.name)}
        read = {"actuator"} if effect.place == "n_rev_s" else set[str]()
        return out | {"channel": effect.channel, "channels": sorted({effect.channel} | same | read)}
    if cause.law is None:
        return out | {"factors": [list(cause.factors(k).values())[0] for k in range(len(cause.varies))]}
    spans = cause.law.windows[: case.experiment.given]
    windows = [[k, *span] for k, some in enumerate(spans, 1) for span in some]
    law = cause.law
    out |= {"channel": law.channel, "channels": list(law.channels), "law": str(law), "acts": law.acts}
    return out | {"windows": windows}


def _hull(result: Result) -> float:
    """Root mean square of what pitching and swaying do to the range, about its mean [m]."""
    return float(np.std(result.true["range_m"] + result.true["position_m"]))


def recording(case: Case, result: Result, noisy: bool) -> Recording:
    """A run as flown; without noise, it is what the true hull makes of the propeller speed that was flown.

    Ranges that are missing on record are missing in both.
    """
    plan = case.plan(result.plan.run)
    replay = Replay(plan)
    n_read, range_m, n = replay.pushed(case.causes, result.true["n_rev_s"])
    x, u = replay.motion[:, : n.size].copy()
    noise = whitener(plan, x, u, n)
    there = np.isfinite(result.run.columns["range_m"])
    if noisy:
        n_read, range_m = result.run.columns["n_rev_s"], result.run.columns["range_m"]
    range_m = np.where(there, range_m, np.nan)
    return Recording(replay, n_read, range_m, noise)


def _without(case: Case, clean: Sequence[Recording], i: int) -> Fit:
    """What cause i leaves where all other effects may be refitted as well."""
    others = [BY_NAME[c.name] for j, c in enumerate(case.causes) if j != i and c.known]
    p = np.array([plan.p for plan in given(case)])
    null = case.truth.vector()
    own = [name.startswith(case.causes[i].name + ".") for name in NAMES]
    p[:, own] = null[own]
    if case.causes[i].varies:
        p = np.tile(null, (len(p), 1))
    return refit(clean, p, free=_free(case, others))


def _free(case: Case, effects: Sequence[Effect]) -> tuple[str, ...]:
    """What a refit frees: the nominal's own parameters, and those of some effects."""
    return tuple(dict.fromkeys((*own_parameters(case.truth.vector()), *parameters(effects))))


def _held_out(case: Case, known: Sequence[Recording], refitted: Fit, held: Sequence[HeldOut]) -> dict[str, list[float]]:
    """Root mean square gaps [m] on the held-out runs, free of noise: nominal, refit, oracle who knows the cause.

    The oracle has to find sizes of known effects; a law that acts everywhere it knows as it is.
    """
    out = {"nominal": gaps(held, case.nominal.vector(), ()), "refit": gaps(held, refitted.p[0], ())}
    if all(cause.known for cause in case.causes):
        effects = [BY_NAME[c.name] for c in case.causes if BY_NAME[c.name].standing != "absorbed"]
        oracle = refit(known, np.array([plan.p for plan in given(case)]), free=_free(case, effects))
        own = [name for name, p in parameters(effects).items() if p.per_run]
        out["oracle"] = gaps(held, oracle.p[0], own)
    elif all(cause.law is not None and not cause.law.windows for cause in case.causes):
        out["oracle"] = [0.0] * len(held)
    return out


def _masked(case: Case, noisy: Recording) -> Recording:
    """The recording without the readings that multipath made long, which the oracle knows."""
    if not any(cause.name == sonar_multipath.EFFECT.name for cause in case.causes):
        return noisy
    plan = noisy.replay.plan
    drawn = streams.uniform(plan.seed, plan.run, streams.MULTIPATH, plan.p[MULTIPATH], noisy.range_m.size)
    return replace(noisy, range_m=np.where(drawn < plan.p[MULTIPATH], np.nan, noisy.range_m))


def _slots(plan: Plan) -> dict[str, float]:
    """Entries of the parameter vector that are not zero, an infinite limit among them left out."""
    return {name: value for name, value in plan.parameters.items() if value != 0.0 and np.isfinite(value)}


def _experiment(case: Case) -> dict[str, Any]:
    e, s = case.experiment, case.experiment.scenarios[0]
    return {
        "vehicle": case.craft,
        "runs": e.given,
        "rate_hz": round(1.0 / s.period_s),
        "duration_s": s.duration_s,
        "family": e.family,
        "noise": e.noise.family,
        "noise_values": {k: v for k, v in vars(e.noise).items() if isinstance(v, float) and np.isfinite(v)},
        "turbulence": e.turbulence,
        "turbulence_m_s2": s.turbulence.acceleration_m_s2,
        "turbulence_s": s.turbulence.time_s,
        "sonar_noise_m": s.sonar.noise_m,
        "resolution_m": s.sonar.resolution_m,
        "dropout": s.sonar.dropout,
        "tachometer_rev_s": s.tachometer.noise_rev_s,
        "frequencies_rad_s": [list(scenario.excitation.frequencies_rad_s) for scenario in e.scenarios],
        "amplitudes": [list(scenario.excitation.amplitudes) for scenario in e.scenarios],
        "standoff_m": [scenario.standoff_m for scenario in e.scenarios],
    }
