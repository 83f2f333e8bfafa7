"""What is sealed about a case: its causes, how visible they are, and what an oracle makes of the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...effects import BY_NAME, sonar_multipath
from ...experiment import Plan, Result
from ...experiment import noise as streams
from ...experiment.flight import MULTIPATH
from ...plant import NAMES, load_truth
from .case import NOMINAL, Case, given, label
from .cause import RUNS
from .held_out import HeldOut, gaps
from .refit import NUISANCE, Fit, Recording, parameters, refit
from .replay import Replay
from .rivals import best_pair, rivals
from .seal import TRUTH_SCHEMA
from .whitening import whitener

Array = NDArray[np.float64]


def truth_of(case: Case, results: Sequence[Result], separations: bool = True) -> tuple[dict[str, Any], list[HeldOut]]:
    """The truth of a case as a document, and its held-out runs."""
    clean = [recording(case, result, noisy=False) for result in results[:RUNS]]
    noisy = [recording(case, result, noisy=True) for result in results[:RUNS]]
    left = refit(clean, case.truth.vector())
    document: dict[str, Any] = {
        "schema": TRUTH_SCHEMA,
        "kind": case.kind,
        "label": label(case),
        "causes": [{"name": c.name, "size": c.size} for c in case.causes],
        "withheld": list(case.withheld),
        "slots": [_slots(result.plan) for result in results],
        "experiment": _experiment(case),
        "d": left.size,
        "d_each": [_without(case, clean, i).size for i in range(len(case.causes))],
        "d_parameters": refit(clean, load_truth(NOMINAL).vector(), free=()).size,
        "wanted": list(case.wanted),
    }
    if separations and len(case.causes) == 1 and label(case) != "parameters":
        document["rivals"] = rivals(case, clean, left)
        if label(case) == "unknown":
            document["pair"] = best_pair(case, clean, left)
    held = [HeldOut.of(case, result) for result in results[RUNS:]]
    document["held_out"] = _held_out(case, noisy, held)
    return document, held


def recording(case: Case, result: Result, noisy: bool) -> Recording:
    """A run as flown; without noise, it is the response of the true hull to the propeller speed that was flown."""
    plan = result.plan
    replay = Replay(plan)
    n_read, range_m, n = replay.pushed(case.causes, result.true["n_rev_s"])
    noise = whitener(plan, case.experiment.sonar_memory_s, replay.motion[1, : n.size].copy(), n)
    if noisy:
        n_read, range_m = result.run.columns["n_rev_s"], result.run.columns["range_m"]
    return Recording(replay, n_read, range_m, noise)


def _without(case: Case, clean: Sequence[Recording], i: int) -> Fit:
    """What cause i leaves where all other effects may be refitted as well."""
    others = [BY_NAME[c.name] for j, c in enumerate(case.causes) if j != i and not c.outside]
    p = np.array([plan.p for plan in given(case)])
    null = case.truth.vector()
    own = [name.startswith(case.causes[i].name + ".") for name in NAMES]
    p[:, own] = null[own]
    return refit(clean, p, free=(*NUISANCE, *parameters(others)))


def _held_out(case: Case, noisy: Sequence[Recording], held: Sequence[HeldOut]) -> dict[str, list[float]]:
    """Root mean square gaps [m] on the held-out runs, free of noise: nominal, refit, oracle who knows the effects."""
    nominal = load_truth(NOMINAL).vector()
    known = [_masked(case, r) for r in noisy]
    refitted = refit(known, case.truth.vector())
    out = {"nominal": gaps(held, nominal, ()), "refit": gaps(held, refitted.p[0], ())}
    if not any(cause.outside for cause in case.causes):
        effects = [BY_NAME[c.name] for c in case.causes if BY_NAME[c.name].standing != "absorbed"]
        oracle = refit(known, np.array([plan.p for plan in given(case)]), free=(*NUISANCE, *parameters(effects)))
        own = [name for name, p in parameters(effects).items() if p.per_run]
        out["oracle"] = gaps(held, oracle.p[0], own)
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
        "family": e.family,
        "unseen": e.family != "position_sine",
        "turbulence": e.turbulence,
        "turbulence_m_s2": s.turbulence.acceleration_m_s2,
        "turbulence_s": s.turbulence.time_s,
        "sonar_noise_m": s.sonar.noise_m,
        "sonar_memory_s": e.sonar_memory_s,
        "resolution_m": s.sonar.resolution_m,
        "dropout": s.sonar.dropout,
        "tachometer_rev_s": s.tachometer.noise_rev_s,
        "frequencies_rad_s": [list(scenario.excitation.frequencies_rad_s) for scenario in e.scenarios],
        "amplitudes": [list(scenario.excitation.amplitudes) for scenario in e.scenarios],
        "standoff_m": [scenario.standoff_m for scenario in e.scenarios],
    }
