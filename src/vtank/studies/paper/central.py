"""Findings on what the paper's estimator does to the drag at each T, and on what the records hold."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...plant import to_feet
from ...units import FOOT_M
from .campaign import Campaign
from .evidence import (
    HIGH_DRAG,
    HOLDS,
    LOW_DRAG,
    PARTLY,
    Finding,
    Results,
    apart,
    numbers,
    percents,
    pure_noise,
    span,
    told,
    within,
)
from .published import PARAMETERS, brutzman_a_per_ft, published
from .records import CASES
from .study import QUANTITIES, STEPS_S

ALIKE = 0.1  # distance of a probability from one half, or share of a value, that counts as none; a convention
TAU = QUANTITIES.index("tau")


def size(r: Results) -> Finding:
    """Does a low-drag vehicle come out with the published drag?"""
    printed = published()[2].values["a"]
    shares = {
        truth: within(r.study.of(truth, "method", "kalman", "kalman")[..., 0], printed) for truth in r.study.truths
    }
    a = r.study.medians(LOW_DRAG, "method", "kalman", "kalman", "a")
    return told(
        "size",
        shares[LOW_DRAG] >= 0.5,
        shares="; ".join(f"{truth} {percents(share)}" for truth, share in shares.items()),
        printed=span(printed, 2),
        medians=numbers(a),
        blown=numbers(a / brutzman_a_per_ft(), 0),
    )


def blind(r: Results) -> Finding:
    """Does the estimate tell vehicles apart?"""
    kalman, stages, lse = (apart(r.study, method) for method in ("kalman", "two_stage", "least_squares"))
    more = r.study.truths[HIGH_DRAG][0] / r.study.truths[LOW_DRAG][0]
    shown = {"kalman": numbers(kalman), "stages": numbers(stages), "lse": numbers(lse)}
    return told("blind", np.abs(kalman - 0.5) <= ALIKE, more=more, **shown)


def noise_free(r: Results) -> Finding:
    """What is left of the printed estimator without noise?"""
    low, high = (r.study.medians(truth, "noise", "none", "kalman", "a") for truth in (LOW_DRAG, HIGH_DRAG))
    true_low, true_high = (r.study.truths[truth][0] for truth in (LOW_DRAG, HIGH_DRAG))
    found = {"found_low": numbers(low, 3), "found_high": numbers(high, 3)}
    return told("noise_free", np.abs(high) < 0.3 * abs(true_high), true_low=true_low, true_high=true_high, **found)


def origin(r: Results) -> Finding:
    """Filter alone, noise alone, both."""
    truth = r.study.truths[LOW_DRAG][0]
    times = {case: r.study.medians(LOW_DRAG, "part", case, "least_squares", "a") / truth for case in CASES}
    return told(
        "origin",
        np.all([np.abs(times[case] - times["exact"]) > 1.0 for case in ("filter u,n", "noise")], axis=0),
        alone=numbers(times["exact"], 1),
        on_u=numbers(times["filter u"], 1),
        on_both=numbers(times["filter u,n"], 1),
        noise=numbers(times["noise"], 1),
        both=numbers(times["recorded"], 1),
    )


def noise_as_drag(r: Results) -> Finding:
    """What the regression makes of noise alone."""
    over = {
        truth: r.study.medians(truth, "method", "least_squares", "least_squares", "tau") / STEPS_S
        for truth in r.study.truths
    }
    name = LOW_DRAG if LOW_DRAG in r.campaigns else next(iter(r.campaigns))
    left = r.campaigns[name].truth_statistics(0).deviation / FOOT_M
    a, limit = np.array([pure_noise(left, step_s) for step_s in STEPS_S]).T
    lag = "; ".join(f"{truth} (true tau {r.study.truths[truth][TAU]:.3g} s) {numbers(x)}" for truth, x in over.items())
    near = np.all([np.abs(x / (limit / STEPS_S) - 1.0) < 0.2 for x in over.values()], axis=0)
    return told("noise_as_drag", near, left=left, name=name, a=numbers(a, 1), lag=lag)


def settling(r: Results) -> Finding:
    """What a Q that settles does."""
    calm, lse, printed = (
        {truth: r.study.medians(truth, "method", method, method, "a") for truth in r.study.truths}
        for method in ("kalman_settling", "least_squares", "kalman")
    )
    same = [np.abs(calm[t] - lse[t]) < 0.15 * np.maximum(np.abs(lse[t]), 0.1) for t in r.study.truths]
    return told(
        "settling",
        np.all(same, axis=0) & (np.abs(lse[LOW_DRAG]) < np.abs(printed[LOW_DRAG])),
        medians="; ".join(f"{t} {numbers(calm[t])} and {numbers(lse[t])}" for t in r.study.truths),
        times=numbers(lse[LOW_DRAG] / r.study.truths[LOW_DRAG][0], 0),
    )


def likelihood(r: Results) -> Finding:
    """What the same records hold."""
    found = {name: list(_likely(campaign)) for name, campaign in r.campaigns.items()}
    farthest = max(abs(value - true) / sd for entries in found.values() for _, value, sd, true in entries)
    lines = (
        f"{name}: {', '.join(f'{n} = {v:.4g} ± {sd:.2g} (truth {t:.4g})' for n, v, sd, t in entries)}"
        for name, entries in found.items()
    )
    return told("likelihood", HOLDS if farthest < 3.5 else PARTLY, lines="; ".join(lines), farthest=farthest)


def _likely(campaign: Campaign) -> Iterator[tuple[str, float, float, float]]:
    """Name, estimate, standard deviation and truth of each parameter of the model that the truth is of, in feet."""
    estimate = campaign.joint["II" if campaign.truth.gamma_per_rev == 0.0 else "III"]
    columns = (to_feet(lumped) for lumped in (estimate.parameters, estimate.sd, campaign.truth.lumped))
    return ((name, value, sd, true) for name, value, sd, true in zip(PARAMETERS, *columns, strict=True) if sd > 0.0)


CENTRAL = (size, blind, noise_free, noise_as_drag, origin, settling, likelihood)  # as the page has them
