"""Which experiment should come next: the largest expected drop of uncertainty per minute.

While several hypotheses are possible, uncertainty is the entropy of their probabilities: for each rival of the winner,
the post-refit separation that a new run would bring is worked out with the rival's parameters held by the recordings so
far, and turned into the expected drop of entropy between the two. Once one hypothesis is certain, it is the entropy of
its parameters: half the log-determinant of their information. Repeating the best of the runs as it was flown is the
null option.

Box, Hill, Technometrics 9 (1967); Buzzi-Ferraris, Forzatti, Chem. Eng. Sci. 39 (1984), separation with refitted
parameters; Lindley, Ann. Math. Stat. 27 (1956), expected information.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import block_diag
from scipy.special import entr, expit

from ..estimate.observed import SPEED
from ..estimate.problem import Problem
from ..plant.parameters import slot
from .evidence import Fitted, Setting, prior_of
from .experiments import SPEED_SD, Experiment, library, recorded, shortened
from .holdout import DIVERGED, model_of
from .score import projected_out
from .selection import Selection
from .ties import noise_free
from .verdict import Verdict

RIVALS = 4  # rivals that are looked at
POSSIBLE = 0.01  # probability from which a hypothesis is a rival
UNCERTAIN = 0.05  # probability of all rivals together from which they, and not the parameters, decide
STEPS = 2  # linearisations of a rival about its best account of a new run
PHASES = 8  # phases of a new run's own wave that a rival may choose from
SHORTENED, SHORTER_MIN = 4, (0.5, 1.0)  # of the best experiments, the lengths that are tried as well [min]
ALTERNATIVES = 3  # runners-up that are reported
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(21)  # for the mean over a normal variable


@dataclass(frozen=True)
class Worth:
    """What an experiment brings: drop of entropy [nats], and the separation from each rival, before and after."""

    experiment: Experiment
    drop: float
    separations: dict[str, tuple[float, float]]

    @property
    def per_minute(self) -> float:
        """Drop of entropy per minute [nats/min]."""
        return self.drop / self.experiment.minutes

    @property
    def least_separation(self) -> float:
        """From the nearest rival, by all runs; decides where entropy has nothing left to lose."""
        return min((after for _, after in self.separations.values()), default=0.0)


def next_experiment(selection: Selection, verdict: Verdict, chances: dict[str, float]) -> dict[str, Any]:
    """The experiment that is advised, its worth per minute against that of a repeat, and the runners-up."""
    setting, winner = selection.setting, verdict.fit if verdict.fit.hypothesis.refit else selection.refit
    rivals = _rivals(selection, verdict, winner, chances)
    repeats = [_repeat(setting, winner, k) for k in range(len(setting.runs))]
    new = library(model_of(winner).p, setting.runs)
    odds = [chances[fit.hypothesis.name] for fit in (winner, *rivals)]
    before = [_before(setting, winner, rival) for rival in rivals]
    doubts = list(zip(rivals, np.divide(odds[1:], np.add(odds[0], odds[1:])), before, strict=True))
    with ThreadPoolExecutor(2) as pool:
        weigh = partial(_worth, setting, winner, doubts)
        worths = list(pool.map(weigh, [*repeats, *new]))
        best, repeat = _ranked(worths)[:SHORTENED], max(worths[: len(repeats)], key=lambda w: w.per_minute)
        short = [shortened(w.experiment, m) for w in best for m in SHORTER_MIN if m < w.experiment.minutes]
        ranked = _ranked([*worths, *pool.map(weigh, short)])
    return {
        **_told(ranked[0], repeat),
        "question": "which hypothesis" if doubts else "how large",
        "separations": {name: list(pair) for name, pair in ranked[0].separations.items()},
        "alternatives": [_told(worth, repeat) for worth in ranked[1 : 1 + ALTERNATIVES]],
    }


def _ranked(worths: Sequence[Worth]) -> list[Worth]:
    """The best per minute first, of each experiment the best length only."""
    found: dict[str, Worth] = {}
    for worth in sorted(worths, key=lambda w: (-round(w.per_minute, 3), -w.least_separation)):
        found.setdefault(worth.experiment.words, worth)
    return list(found.values())


def _told(worth: Worth, repeat: Worth) -> dict[str, Any]:
    return {
        "experiment": worth.experiment.told,
        "scenario": worth.experiment.scenario,
        "minutes": worth.experiment.minutes,
        "per_minute": float(worth.per_minute),
        "against_repeat": float(worth.per_minute / max(repeat.per_minute, 1e-12)),
    }


def _rivals(selection: Selection, verdict: Verdict, winner: Fitted, chances: dict[str, float]) -> list[Fitted]:
    """The most probable others, where they are probable enough, tied effects first."""
    others = [f for f in (selection.refit, *selection.named) if f is not winner and not _outliers(f, winner)]
    tied = [f for f in others if f.hypothesis.name in verdict.rivals]
    possible = [f for f in others if f not in tied and chances[f.hypothesis.name] > POSSIBLE]
    found = sorted([*tied, *possible], key=lambda f: (f not in tied, -chances[f.hypothesis.name]))[:RIVALS]
    total = sum(chances[f.hypothesis.name] for f in found)
    return found if total > UNCERTAIN * chances[winner.hypothesis.name] else []


def _outliers(rival: Fitted, winner: Fitted) -> bool:
    """Whether two hypotheses differ by lone readings only, or more: no experiment here is planned for those."""
    different = set(rival.hypothesis.effects) ^ set(winner.hypothesis.effects)
    return any(effect.outliers for effect in different)


def _repeat(setting: Setting, winner: Fitted, k: int) -> Experiment:
    """Run k once more."""
    run = setting.runs[k]
    minutes = float(run.time_s[-1] - run.time_s[0]) / 60.0
    return Experiment(f"run {run.name} once more", {}, minutes, recorded(run, winner.vector(), run.standoff))


def _worth(
    setting: Setting, winner: Fitted, doubts: Sequence[tuple[Fitted, float, float]], experiment: Experiment
) -> Worth:
    """Expected drop of entropy by an experiment; of one in which the winner runs away, none."""
    if not np.all(np.abs(experiment.run.value) < DIVERGED):
        return Worth(experiment, 0.0, {})
    if not doubts:
        return Worth(experiment, _parameter_gain(setting, winner, experiment), {})
    drop, separations = 0.0, {}
    for rival, chance, before in doubts:
        more = _separation(setting, winner, rival, experiment)
        drop += entropy_drop(chance, more)
        separations[rival.hypothesis.name] = before, float(np.hypot(before, more))
    return Worth(experiment, drop, separations)


def entropy_drop(chance: float, separation: float) -> float:
    """Expected drop of the entropy [nats] of a two-way choice, one way having this probability.

    The log-odds of the truth grow by a normal variable of mean separation^2/2 and deviation `separation`.
    """
    odds = np.log(chance / (1.0 - chance)) if 0.0 < chance < 1.0 else np.inf
    if not np.isfinite(odds):
        return 0.0
    left = 0.0
    for sign, weight in ((1.0, chance), (-1.0, 1.0 - chance)):
        after = odds + sign * 0.5 * separation**2 + separation * NODES
        left += weight * float(WEIGHTS @ _entropy(after)) / np.sqrt(2.0 * np.pi)
    return float(_entropy(np.array([odds]))[0]) - left


def _entropy(log_odds: np.ndarray) -> np.ndarray:
    return np.asarray(entr(expit(log_odds)) + entr(expit(-log_odds)))


# --- linear algebra of one more run --------------------------------------------------------------------------------
def _separation(setting: Setting, winner: Fitted, rival: Fitted, experiment: Experiment) -> float:
    """Distance, in deviations, between the winner's new run and the rival's best account of it and all runs so far."""
    known = _known(rival)
    problem, theta, own = _alone(setting, rival, experiment)
    best = np.inf
    for values in _own_values(problem, winner):
        theta[len(known) : len(known) + len(problem.per_run)] = values
        best = min(best, _least_squares(problem, theta, block_diag(known, np.diag(own))))
    return float(np.sqrt(max(best, 0.0)))


def _least_squares(problem: Problem, theta: np.ndarray, known: np.ndarray) -> float:
    """Least sum of squares of a run's residuals and of what leaving theta costs, by STEPS linearisations."""
    moved, filtered, least = np.zeros_like(theta), problem.filter(theta), np.inf
    for _ in range(STEPS):
        r, J = problem.linearise(theta + moved, filtered)
        A, b = J.T @ J + known, J.T @ r + known @ moved
        cost, step = float(r @ r + moved @ known @ moved), -np.linalg.solve(A, b)
        if cost > least:
            break
        least, moved = min(least, cost), moved + step
    return min(least, cost + float(b @ step))


def _own_values(problem: Problem, winner: Fitted) -> list[list[float]]:
    """Values of a new run's own parameters (a wave's phase) from which a rival may start: the winner's, or a grid."""
    if set(problem.per_run) <= set(winner.problem.per_run):
        p = winner.vector()
        return [[float(p[slot(name)]) for name in problem.per_run]]
    return [[phase] * len(problem.per_run) for phase in np.arange(PHASES) * 2.0 * np.pi / PHASES]


def _parameter_gain(setting: Setting, winner: Fitted, experiment: Experiment) -> float:
    """Half the growth of the log-determinant of the information about the shared parameters [nats]."""
    known = _known(winner)
    problem, theta, own = _alone(setting, winner, experiment)
    J = problem.jacobian(theta, problem.filter(theta))
    both, count = J.T @ J + block_diag(known, np.diag(own)), len(known)
    more, rest, before = (float(np.linalg.slogdet(part)[1]) for part in (both, both[count:, count:], known))
    return 0.5 * (more - rest - before)


def _before(setting: Setting, winner: Fitted, rival: Fitted) -> float:
    """Separation of winner and rival by the recordings so far."""
    problem = replace(rival.problem, runs=noise_free(setting, winner).runs)
    theta = rival.optimum.theta
    r, J = problem.linearise(theta, problem.filter(theta))
    return float(np.sqrt(max(r @ projected_out(r, J, rival.optimum.information), 0.0)))


def _known(fit: Fitted) -> np.ndarray:
    """Information about the shared parameters from the recordings so far, all else integrated out."""
    count = len(fit.problem.free)
    return np.linalg.inv(fit.covariance()[:count, :count])


def _alone(setting: Setting, fit: Fitted, experiment: Experiment) -> tuple[Problem, np.ndarray, np.ndarray]:
    """The new run as a problem of the fit's hypothesis, its unknowns, and the information about its own ones."""
    noise = setting.noise
    if not any(SPEED in run.first for run in setting.runs):
        variance = list(noise.variance)
        variance[SPEED] = SPEED_SD**2
        noise = replace(noise, variance=tuple(variance))
    problem = Problem((experiment.run,), fit.vector(), fit.problem.free, fit.problem.per_run, noise)
    alone = replace(setting, runs=problem.runs, noise=noise, weight=(np.ones(experiment.run.time_s.size),), flags=())
    theta = problem.initial()
    prior = prior_of(alone, fit.hypothesis, problem, theta)
    return problem, theta, prior.sd[problem.own_slice(0)] ** -2
