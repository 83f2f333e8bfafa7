"""Four estimators on the same recordings: maximum likelihood, and on the paper's regression its Kalman filter, the
two-stage form of it and least squares.

The paper takes a run at a time; here its regression goes on from run to run, so that all four see the same data. Its
intervals are those of the covariance that each claims for its coefficients C, carried to the parameters to first order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...estimate import MODELS, Noise, Problem, beforehand, descend, first_guesses, fit, noise_level, observe, refit
from ...estimate.paper import (
    ESTIMATORS,
    Estimator,
    Model,
    PaperSettings,
    Regression,
    estimate,
    lump_all,
    regression,
    run_signals,
)
from ...plant import LAG, LUMPED, vector
from ...record import Run
from .flown import Array

LIKELIHOOD = "likelihood"
METHODS: tuple[str, ...] = (LIKELIHOOD, *ESTIMATORS)
TITLES = {
    LIKELIHOOD: "maximum likelihood",
    "kalman": "Kalman filter",
    "two_stage": "two-stage",
    "least_squares": "least squares",
}
NUDGE = 1e-6  # relative step of the first-order propagation


@dataclass(frozen=True, eq=False)
class Answer:
    """Values and claimed deviations of a model's parameters, shapes (P,); NaN where an estimator gave up."""

    value: Array
    sd: Array


def answers(runs: Sequence[Run], model: Model, effects: dict[str, float], noise: Noise) -> dict[str, Answer]:
    """By each of METHODS.

    effects: slots that are known to differ from their null; noise: a first guess; both for the likelihood alone.
    """
    found = {LIKELIHOOD: likelihood(runs, model, effects, noise)}
    rows = _rows(runs, model)
    nothing = Answer(*np.full((2, len(MODELS[model])), np.nan))
    return found | {name: _paper(rows, model, name) if rows else nothing for name in ESTIMATORS}


def likelihood(runs: Sequence[Run], model: Model, effects: dict[str, float], noise: Noise) -> Answer:
    """That of `vtank identify`; where there is a disturbance, its level is sought from the true one, for speed."""
    base = vector({LAG: 0.0 if model == "I" else 0.5, **effects})
    problem = Problem(tuple(observe(run) for run in runs), base, MODELS[model], noise=noise)
    guess = first_guesses(problem, 1)[0]
    if noise.quiet:
        found = fit(problem, [guess])
    else:
        theta = descend(problem, guess, beforehand(problem, guess), problem.filter(guess)).theta
        found = refit(problem.with_noise(noise_level(problem, theta)), theta)
    return Answer(np.array(list(found.values.values())), np.array(list(found.sd.values())))


def _rows(runs: Sequence[Run], model: Model) -> Regression | None:
    """The regression of all runs, one after the other; None where a run is too short for it."""
    settings = PaperSettings(compiled=True)
    try:
        seen = [run_signals(run, settings) for run in runs]
        parts = [regression(s.u_m_s, s.n_rev_s, s.step_s, model) for s in seen]
    except InputError:
        return None
    z, h = np.concatenate([r.z for r in parts]), np.vstack([r.h for r in parts])
    return Regression(model, parts[0].step_s, z, h)


def _paper(rows: Regression, model: Model, name: Estimator) -> Answer:
    evolution = estimate(rows, PaperSettings(estimator=name, compiled=True))
    chosen = [LUMPED.index(slot) for slot in MODELS[model]]  # of the order of `lump_all`
    c = evolution.final

    def lumped(c: Array) -> Array:
        return np.asarray(lump_all(c, rows.step_s, model)[..., chosen])

    steps = np.diag(NUDGE * np.maximum(np.abs(c), 1e-9))
    slopes = (lumped(c + steps) - lumped(c - steps)) / (2.0 * np.diag(steps)[:, None])
    variance = np.einsum("ip,ij,jp->p", slopes, evolution.covariance, slopes)
    return Answer(lumped(c), np.sqrt(np.maximum(variance, 0.0)))
