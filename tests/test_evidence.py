"""Laplace's evidence against importance sampling, inside the bounds and against them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import recordings
from scipy.stats import multivariate_t, norm

from vtank.diagnose.evidence import Fitted, evaluate
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.selection import prepare
from vtank.effects.catalogue import BY_NAME
from vtank.estimate.observed import observe
from vtank.estimate.problem import Noise
from vtank.experiment import simulate_surge
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario
from vtank.plant.parameters import vector
from vtank.plant.truth import load_truth

NOMINAL = load_truth("paper-ii").vector()
NOISE = Noise((4e-5, 4e-5, 4e-5), 0.0005, 1.0)
DRAWS = 3000


def weighed(name: str, values: dict[str, float], seed: int = 4) -> Fitted:
    """One effect fitted to two short runs with known noise."""
    names, settings = ("paper-ds2", "paper-ds3"), ("duration_s=60",)
    plans = [plan_run(load_scenario(n, settings), run=k, seed=seed) for k, n in enumerate(names)]
    plans = [replace(plan, p=vector(values, plan.p)) for plan in plans]
    setting = prepare([observe(result.run) for result in simulate_surge(plans)], NOMINAL).with_noise(NOISE)
    return evaluate(setting, Hypothesis((BY_NAME[name],)))


def sampled(fit: Fitted) -> tuple[float, float]:
    """Log evidence by importance sampling from Student's t about the optimum, gains held, and its own deviation."""
    prior, centre = fit.prior, fit.optimum.theta
    sd = np.sqrt(np.diag(fit.covariance()))
    shape = 1.3 * fit.covariance() / np.outer(sd, sd)
    proposal = multivariate_t(np.zeros(centre.size), 0.5 * (shape + shape.T), df=6, seed=11)
    drawn = proposal.rvs(DRAWS)
    theta = centre + sd * drawn
    inside = np.all((theta >= prior.low) & (theta <= prior.high), axis=1)
    mass = norm.cdf(prior.high, prior.mean, prior.sd) - norm.cdf(prior.low, prior.mean, prior.sd)
    logs = np.concatenate([np.log(2.0 * np.pi * f.variance) for f in fit.filtered]).sum()
    log_weight = np.full(DRAWS, -np.inf)
    for i in np.flatnonzero(inside):
        r = fit.problem.residuals(theta[i], fit.filtered)
        belief = norm.logpdf(theta[i], prior.mean, prior.sd).sum() - np.log(mass).sum()
        log_weight[i] = -0.5 * (r @ r + logs) + belief
    log_weight -= proposal.logpdf(drawn) - np.log(sd).sum()
    top = log_weight.max()
    weight = np.exp(log_weight - top)
    return top + np.log(weight.mean()), weight.std() / weight.mean() / np.sqrt(DRAWS)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("linear_drag", {"linear_drag.c": 0.1}),
        ("drag_asymmetry", {"drag_asymmetry.e": 0.1}),
        ("coulomb_friction", {"coulomb_friction.f": 0.004}),
    ],
)
def test_inside_the_bounds(name, values):
    fit = weighed(name, values)
    value, sd = sampled(fit)
    assert sd < 0.1
    assert fit.log_evidence == pytest.approx(value, abs=0.25 + 3.0 * sd)


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_where_the_effect_has_run_into_its_null(seed):
    fit = weighed("linear_drag", {}, seed)
    assert fit.values["linear_drag.c"] < 3.0 * np.sqrt(fit.covariance()[2, 2]) + 0.02
    value, sd = sampled(fit)
    assert sd < 0.15
    assert fit.log_evidence == pytest.approx(value, abs=0.4 + 3.0 * sd)


def test_the_prior_does_not_depend_on_where_the_fit_begins():
    """An effect that another fit had switched off must not be thought of as immense."""
    setting = prepare(recordings({"linear_drag.c": 0.1}), NOMINAL).with_noise(NOISE)
    hypothesis = Hypothesis((BY_NAME["linear_drag"], BY_NAME["wall_proximity"]))
    evidence = []
    for tiny in (1e-9, 0.1):
        starts = [{"linear_drag.c": 0.05, "wall_proximity.drag": tiny, "wall_proximity.mass": tiny}]
        evidence.append(evaluate(setting, hypothesis, starts).log_evidence)
    assert evidence[0] == pytest.approx(evidence[1], abs=2.0)  # a prior of 1e10 would cost 20
