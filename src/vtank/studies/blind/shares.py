"""The true gap budget of a case, defined as the diagnosis does: parts left out, each foretold from its first seconds.

The models are the truth's own: the nominal, the hull's parameters as the scorer refits them, and the truth with its
cause. What they differ by and what the water and the sensors did have nothing to do with one another in the long run,
so that a model's share is what it takes off the mean square of its distance to the truth, and the rest is the truth's
own error: the sensor's, and a disturbance, to which a cause counts that would not come again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...diagnose.holdout import Model, Overlaid, Prediction, Target
from ...diagnose.selection import prepare
from ...diagnose.shrink import parts_of
from ...estimate import Noise, Observed, observe
from ...experiment import Result
from ...experiment.noise import TURBULENCE
from .case import Case
from .fly import recorded
from .laws import DAY
from .refit import Fit, Recording
from .replay import Replay

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Told:
    """What only the truth knows of a run.

    Attributes:
        input: propeller speed without what laws in the tachometer do to it, at the input's stamps, shape (I,) [rev/s].
        push: what laws on board add there, shape (I,) [m/s2].
        error: by which laws in the sonar falsify the readings, shape (M,) [m].
        noise: error of the readings beside, shape (M,) [m].
    """

    input: Array
    push: Array
    error: Array
    noise: Array


def shares(case: Case, results: Sequence[Result], known: Sequence[Recording], refitted: Fit) -> dict[str, float]:
    """Shares of parameters, cause, disturbance and noise in the mean-square error of the nominal, which add to one."""
    runs = [observe(result.run) for result in results]
    setting = prepare(runs, case.nominal.vector()).with_noise(_noise(known))
    parts = parts_of(setting, blocks=case.kind == "varying")
    told = [_told(case, *pair) for pair in zip(results, runs, strict=True)]
    sums = np.zeros(4)  # of nominal and refit less the truth, of the truth's error, and of the sensors'
    for k, run in enumerate(parts.setting.runs):
        i, (fed, here) = parts.parent[k], parts.inside(k)
        target, own = Target(run, parts.setting.weight[k], setting.noise), told[i]
        true = Prediction(Model(case.plan(i).p), replace(target, run=replace(run, input=own.input[fed])))
        errors = Overlaid(true, own.push[fed], own.error[here]).errors()
        off = [Prediction(Model(p), target).errors() - errors for p in (case.nominal.vector(), refitted.p[i])]
        sums += [float(np.sum(e**2)) for e in (*off, errors, own.noise[here][target.scored])]
    sums[3] = min(sums[3], sums[2])  # a window to enter by learns a slow error of the sonar, which is then none of it
    nominal, left, true_error, noise = sums / (sums[0] + sums[2])
    left *= bool(case.causes)  # else what the refit is off by is an error of its own
    again = left * _comes_again(case)
    return {
        "parameters": nominal - left,
        "cause": again,
        "disturbance": true_error - noise + left - again,
        "noise": noise,
    }


def _noise(known: Sequence[Recording]) -> Noise:
    """The noise that the runs truly have, as the predictor takes it."""
    noise = known[0].whitener
    white = float(np.mean([np.mean(one.whitener.variance) for one in known]))
    (sigma, _, colour), (memory, _, time_s) = noise.deviation, noise.memory
    return Noise((white,) * 3, sigma, max(memory, 0.5 * noise.period_s), colour, time_s)  # white is held over a tick


def _comes_again(case: Case) -> bool:
    """Whether the cause would do the same in another run: it has no windows, and does not go by the time of day."""
    laws = [cause.law for cause in case.causes if cause.law is not None]
    return not any(law.windows or any(factor.signal == DAY for factor in law.factors) for law in laws)


def _told(case: Case, result: Result, run: Observed) -> Told:
    """What the truth knows of one run, and what it would have read without any law in its sensors."""
    plan = case.plan(result.plan.run)
    replay, n, range_m = Replay(plan), result.true["n_rev_s"], result.run.columns["range_m"]
    _, _, true = replay.pushed(case.causes, n)
    x, u = replay.motion[:, : n.size]
    errors = dict(
        zip(("tachometer", "range"), recorded(plan, case.causes, (x, u, true), (0.0 * n, 0.0 * n)), strict=True)
    )
    off = {"tachometer": result.run.columns["n_rev_s"] - n, "range": range_m - result.true["range_m"]}
    for law in (cause.law for cause in case.causes if cause.law is not None and cause.law.stalls):
        still = law.gate(plan.run, plan.scenario.period_s * np.arange(n.size)) > 0.0
        errors[law.acts] = np.where(still, off[law.acts], errors[law.acts])
    fed, read = (np.searchsorted(result.run.time_s, t).clip(max=n.size - 1) for t in (run.input_time_s, run.time_s))
    push, error = replay.flight.noise[0, TURBULENCE, : n.size][fed], errors["range"][read]
    return Told(run.input - errors["tachometer"][fed], push, error, off["range"][read] - error)
