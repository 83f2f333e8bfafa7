"""Findings on claims: the tempting ones that the simulations do not bear out, and the paper's own."""

from __future__ import annotations

import numpy as np

from ...estimate import residual_coherence
from ...estimate.paper import MODELS
from ...units import RPM_REV_S
from .campaign import Campaign
from .evidence import (
    FAILS,
    HIGH_DRAG,
    HOLDS,
    LOW_DRAG,
    NAMES,
    PARTLY,
    WITHIN,
    Finding,
    Results,
    median,
    numbers,
    percent,
    positive_within,
    reproduced,
    steady_speed,
    told,
)
from .published import SETS, published

FULL_SCALE_RPM, CRUISE_FT_S = 700.0, 2.0  # both propellers, steady: "speed_per_rpm = 2/700" in Brutzman's SUBmodel.h
VERDICTS = (FAILS, PARTLY, HOLDS)  # by how many of two cases bear the claim out
SELDOM = 0.25  # share of seeds up to which something counts as not what happens; a convention
PAIR = ("kalman", "kalman_settling")  # the printed Q and one that settles


def artefact(r: Results) -> Finding:
    """Is the published drag an artefact?"""
    printed = {quantity: published()[2].values[quantity] for quantity in ("a", "b", "tau")}
    cases = [(truth, method) for truth in (LOW_DRAG, HIGH_DRAG) for method in ("kalman", "least_squares")]
    share = {(t, m): reproduced(r.study.of(t, "method", m, m), printed) for t, m in cases}
    best, whole = max(cases, key=lambda case: share[case]), max(seeds for _, seeds in share.values())
    return told(
        "artefact",
        PARTLY if any(share[LOW_DRAG, m][0] > 0.0 for m in ("kalman", "least_squares")) else FAILS,
        shares="; ".join(f"{t} by {NAMES[m]} {percent(share[t, m][0])}" for t, m in cases),
        best=f"{best[0]} by {NAMES[best[1]]}",
        at_once=f"the best of these does it in {percent(whole)} of the seeds" if whole else "none of these does it",
    )


def printed_q(r: Results) -> Finding:
    """Did the authors run the literal Q?"""
    b = {truth: r.study.of(truth, "method", "kalman", "kalman")[..., 1] for truth in r.study.truths}
    steady = {truth: float(np.mean([positive_within(row, WITHIN) for row in values])) for truth, values in b.items()}
    printed = published()[2].values["b"]
    return told(
        "printed_q",
        FAILS if max(steady.values()) < SELDOM else PARTLY,
        apart=printed.max() / printed.min(),
        steady=", ".join(f"{percent(share)} ({truth})" for truth, share in steady.items()),
        negative=percent(float(np.mean([np.mean(values < 0.0) for values in b.values()]))),
        grown=min(growth(c, "kalman") for c in r.campaigns.values()),
        settled=min(growth(c, "kalman_settling") for c in r.campaigns.values()),
    )


def growth(campaign: Campaign, method: str) -> float:
    """Final variance of C2 = T/tau over that after a quarter of data set 1, Model III."""
    variance = campaign.paper[method, "III", 0].evolution.variance[:, 1]
    return float(variance[-1] / variance[variance.size // 4])


def filter_on_n(r: Results) -> Finding:
    """The paper: filtering n too leaves a minimal effect."""
    truths = r.study.truths

    def a(truth: str, factor: str, label: str) -> float:
        return median(r.study, truth, factor, label, "least_squares", "a")

    error = {t: [abs(a(t, "filter on n", on) - truths[t][0]) for on in ("yes", "no")] for t in truths}
    moved = {t: a(t, "part", "filter u,n") - a(t, "part", "exact") for t in truths}
    helps = [truth for truth, (yes, no) in error.items() if yes < no]
    return told(
        "filter_on_n",
        FAILS if len(helps) < len(truths) else PARTLY,
        errors=", ".join(
            f"{t} {with_it:.2f} with and {without:.2f} without" for t, (with_it, without) in error.items()
        ),
        helps=" and ".join(helps) or "none",
        moved=", ".join(f"{by:+.2f} ({t})" for t, by in moved.items()),
    )


def stages(r: Results) -> Finding:
    """The paper: a relevant improvement by two stages."""
    one, two = (r.practice.own(method, "II") for method in ("kalman", "two_stage"))
    calm, calmer = (r.practice.own(method, "II") for method in ("kalman_settling", "two_stage_settling"))
    better = float(np.mean(two < one))
    return told(
        "stages",
        PARTLY if better > 0.5 else FAILS,
        better=percent(better),
        one=numbers([np.median(one)]),
        two=numbers([np.median(two)]),
        lost_one=percent(float(np.mean(np.isinf(one)))),
        lost_two=percent(float(np.mean(np.isinf(two)))),
        calm=np.median(calm),
        calmer=np.median(calmer),
    )


def third_model(r: Results) -> Finding:
    """The paper: Model III is best."""
    found = {method: [float(np.median(r.practice.crossed(method, m))) for m in MODELS] for method in PAIR}
    best = {method: MODELS[int(np.argmin(values))] for method, values in found.items()}
    return told(
        "third_model",
        VERDICTS[sum(model == "III" for model in best.values())],
        printed=numbers(found["kalman"]),
        best=best["kalman"],
        settling=numbers(found["kalman_settling"]),
        best_settling=best["kalman_settling"],
    )


def generality(r: Results) -> Finding:
    """The paper: data set 1 gives the most general models."""
    wins = {}
    for method in PAIR:
        elsewhere = np.median(r.practice.crossed(method, "III"), axis=2)
        wins[method] = np.bincount(np.argmin(elsewhere, axis=1), minlength=SETS) / elsewhere.shape[0]
    verdict = VERDICTS[sum(int(np.argmax(shares)) == 0 for shares in wins.values())]
    printed, settling = (", ".join(map(percent, wins[method])) for method in PAIR)
    return told("generality", verdict, printed=printed, settling=settling)


def same_as_lse(r: Results) -> Finding:
    """The paper: least squares similar, the Kalman filter more accurate."""
    one, two, lse = (r.practice.own(method, "II") for method in ("kalman", "two_stage", "least_squares"))
    wins = [float(np.mean(values < lse)) for values in (one, two)]
    medians = numbers([np.median(values) for values in (one, two, lse)])
    verdict = FAILS if max(wins) < 0.5 else PARTLY
    return told("same_as_lse", verdict, medians=medians, one=percent(wins[0]), two=percent(wins[1]))


def coherence(r: Results) -> Finding:
    """The paper: coherent residuals show an inadequate model."""
    means = {}
    for name, campaign in r.campaigns.items():
        signals = campaign.signals(0)
        left = signals.u_m_s - campaign.true_u_m_s(0)
        means[name] = float(np.mean(residual_coherence(signals.u_m_s, left, signals.step_s)[1]))
    verdict = FAILS if min(means.values()) > 0.5 else PARTLY
    return told("coherence", verdict, means=", ".join(f"{mean:.2f} ({name})" for name, mean in means.items()))


def confidence(r: Results) -> Finding:
    """The paper: b has the least covariance, so it is the best identified."""
    literal, normalised = np.mean(list(r.practice.smallest.values()), axis=0).tolist()
    errors = {}
    for i, quantity in ((0, "a"), (1, "b"), (3, "tau")):
        estimates = [r.study.of(t, "method", "least_squares", "least_squares")[..., i] / r.study.truths[t][i]
                     for t in r.study.truths]  # fmt: skip
        errors[quantity] = float(np.median(np.abs(np.concatenate(estimates) - 1.0)))
    best = min(errors, key=lambda quantity: errors[quantity])
    return told(
        "confidence",
        PARTLY if best == "b" else FAILS,
        literal=percent(literal),
        normalised=percent(normalised),
        errors=", ".join(f"{quantity} {percent(x)}" for quantity, x in errors.items()),
        best=best,
    )


def open_water(r: Results) -> Finding:
    """The paper: Model III of data set 1 agrees with observations in open water."""
    table, n = published()[3].values, FULL_SCALE_RPM * RPM_REV_S
    speed = steady_speed(float(table["a"][0]), float(table["b"][0]), float(table["gamma"][0]), n)
    physical = steady_speed(*r.study.truths[LOW_DRAG][:3], n)
    verdict = FAILS if speed < 0.5 * CRUISE_FT_S else HOLDS
    return told("open_water", verdict, rpm=FULL_SCALE_RPM, speed=speed, cruise=CRUISE_FT_S, physical=physical)


TESTED = (artefact, printed_q, filter_on_n, stages, third_model, generality)
CLAIMS = (*TESTED, same_as_lse, coherence, confidence, open_water)  # as the page has them
