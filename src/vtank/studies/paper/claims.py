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
    best = max(cases, key=lambda case: share[case])
    whole = max(seeds for _, seeds in share.values())
    at_once = f"the best of these does it in {percent(whole)} of the seeds" if whole else "none of these does it"
    return Finding(
        "The published drag is an artefact of the estimator",
        PARTLY if any(share[LOW_DRAG, m][0] > 0.0 for m in ("kalman", "least_squares")) else FAILS,
        f"It can be: see above. But the drag is not all that is published. Share of runs with a, b and tau all "
        f"within a factor of {WITHIN:g} of Table 2: "
        f"{'; '.join(f'{t} by {NAMES[m]} {percent(share[t, m][0])}' for t, m in cases)}; best is {best[0]} by "
        f"{NAMES[best[1]]}. In all four data sets at once {at_once}. Amplitude, length, noise, T, filter and "
        f"controller of the real test are unknown, and drag by wall, tether and reversing flow is not simulated.",
    )


def printed_q(r: Results) -> Finding:
    """Did the authors run the literal Q?"""
    b = {truth: r.study.of(truth, "method", "kalman", "kalman")[..., 1] for truth in r.study.truths}
    steady = {truth: float(np.mean([positive_within(row, WITHIN) for row in values])) for truth, values in b.items()}
    negative = float(np.mean([np.mean(values < 0.0) for values in b.values()]))
    printed = published()[2].values["b"]
    grown = {method: min(growth(c, method) for c in r.campaigns.values()) for method in PAIR}
    return Finding(
        "The authors ran q_ii = 1 in the units of equations (11) and (12)",
        FAILS if max(steady.values()) < SELDOM else PARTLY,
        f"The four published b lie within a factor of {printed.max() / printed.min():.1f} of each other. With that Q "
        f"the simulated four lie within a factor of {WITHIN:g} in "
        f"{', '.join(f'{percent(share)} ({truth})' for truth, share in steady.items())} of the seeds, and "
        f"{percent(negative)} of all b are negative. In its favour: the element of P for the lag grows in Model III, "
        f"as the paper reports of Figure 4, by a factor of {grown['kalman']:.1f} or more over the last three "
        f"quarters of the record; with a Q that settles it changes by {grown['kalman_settling']:.1f}.",
    )


def growth(campaign: Campaign, method: str) -> float:
    """Final variance of C2 = T/tau over that after a quarter of data set 1, Model III."""
    variance = campaign.paper[method, "III", 0].evolution.variance[:, 1]
    return float(variance[-1] / variance[variance.size // 4])


def filter_on_n(r: Results) -> Finding:
    """The paper: filtering n too leaves a minimal effect."""
    truths = r.study.truths

    def error(truth: str, on: str) -> float:
        return abs(median(r.study, truth, "filter on n", on, "least_squares", "a") - truths[truth][0])

    def moved(truth: str) -> float:
        filtered, exact = (median(r.study, truth, "part", c, "least_squares", "a") for c in ("filter u,n", "exact"))
        return filtered - exact

    helps = [truth for truth in truths if error(truth, "yes") < error(truth, "no")]
    parts = (f"{truth} {error(truth, 'yes'):.2f} with and {error(truth, 'no'):.2f} without" for truth in truths)
    return Finding(
        "Filtering n as well keeps the filter's effect on the parameters minimal",
        FAILS if len(helps) < len(truths) else PARTLY,
        f"Error of the median a by least squares [1/ft]: {', '.join(parts)}. It helps for "
        f"{' and '.join(helps) or 'none'}. Without noise, the filter on both moves a by "
        f"{', '.join(f'{moved(t):+.2f} ({t})' for t in truths)}: n passes through the filter's position channel, "
        f"whose dynamics are not those of the velocity channel that gives u.",
    )


def stages(r: Results) -> Finding:
    """The paper: a relevant improvement by two stages."""
    one, two = (r.practice.own(method, "II") for method in ("kalman", "two_stage"))
    calm, calmer = (r.practice.own(method, "II") for method in ("kalman_settling", "two_stage_settling"))
    better = float(np.mean(two < one))
    lost_one, lost_two = (percent(float(np.mean(np.isinf(values)))) for values in (one, two))
    return Finding(
        "Two-stage estimation is a relevant improvement",
        PARTLY if better > 0.5 else FAILS,
        f"With the printed q_ii its free run has the smaller deviation in {percent(better)} of runs (medians "
        f"{numbers([np.median(two)])} against {numbers([np.median(one)])} ft/s); it diverges in {lost_two} of runs, "
        f"that of one stage in {lost_one}. With a Q that settles the two are alike: {np.median(calmer):.3f} and "
        f"{np.median(calm):.3f} ft/s.",
    )


def third_model(r: Results) -> Finding:
    """The paper: Model III is best."""
    found = {method: [float(np.median(r.practice.crossed(method, m))) for m in MODELS] for method in PAIR}
    best = {method: MODELS[int(np.argmin(values))] for method, values in found.items()}
    return Finding(
        "Model III gives the best results",
        VERDICTS[sum(model == "III" for model in best.values())],
        f"Median deviation on the data sets that a model was not identified on, Models I, II, III [ft/s]: printed "
        f"q_ii {numbers(found['kalman'])}, best Model {best['kalman']}; a Q that settles "
        f"{numbers(found['kalman_settling'])}, best Model {best['kalman_settling']}. More coefficients are more ways "
        f"in for filter and noise; maximum likelihood does find Model III's thrust loss on the same records (above).",
    )


def generality(r: Results) -> Finding:
    """The paper: data set 1 gives the most general models."""
    wins = {}
    for method in PAIR:
        elsewhere = np.median(r.practice.crossed(method, "III"), axis=2)
        wins[method] = np.bincount(np.argmin(elsewhere, axis=1), minlength=SETS) / elsewhere.shape[0]
    return Finding(
        "Data set 1 gives the most general models",
        VERDICTS[sum(int(np.argmax(shares)) == 0 for shares in wins.values())],
        f"Share of campaigns in which Model III from data set 1, 2, 3, 4 does best on the others: printed q_ii "
        f"{', '.join(map(percent, wins['kalman']))}; a Q that settles "
        f"{', '.join(map(percent, wins['kalman_settling']))}.",
    )


def same_as_lse(r: Results) -> Finding:
    """The paper: least squares similar, the Kalman filter more accurate."""
    one, two, lse = (r.practice.own(method, "II") for method in ("kalman", "two_stage", "least_squares"))
    wins = [float(np.mean(values < lse)) for values in (one, two)]
    return Finding(
        "Least squares gives similar results, and the Kalman filter the more accurate ones",
        FAILS if max(wins) < 0.5 else PARTLY,
        f"Median deviation of Model II's free run [ft/s], printed q_ii: Kalman filter, two stages, least squares "
        f"{numbers([np.median(values) for values in (one, two, lse)])}. The Kalman filter beats least squares in "
        f"{percent(wins[0])} of runs, with two stages in {percent(wins[1])}.",
    )


def coherence(r: Results) -> Finding:
    """The paper: coherent residuals show an inadequate model."""
    means = {}
    for name, campaign in r.campaigns.items():
        signals = campaign.signals(0)
        left = signals.u_m_s - campaign.true_u_m_s(0)
        means[name] = float(np.mean(residual_coherence(signals.u_m_s, left, signals.step_s)[1]))
    return Finding(
        "Coherence between u and the residuals shows that a model is inadequate",
        FAILS if min(means.values()) > 0.5 else PARTLY,
        f"Even the true speed, taken from the measured one of data set 1, leaves residuals whose coherence with u, "
        f"averaged over frequency, is {', '.join(f'{mean:.2f} ({name})' for name, mean in means.items())}: u holds "
        f"the very noise that the residuals are made of.",
    )


def confidence(r: Results) -> Finding:
    """The paper: b has the least covariance, so it is the best identified."""
    literal, normalised = np.mean(list(r.practice.smallest.values()), axis=0).tolist()
    errors = {}
    for i, quantity in ((0, "a"), (1, "b"), (3, "tau")):
        estimates = (r.study.of(t, "method", "least_squares", "least_squares")[..., i] / r.study.truths[t][i]
                     for t in r.study.truths)  # fmt: skip
        errors[quantity] = float(np.median(np.abs(np.concatenate(list(estimates)) - 1.0)))
    best = min(errors, key=lambda quantity: errors[quantity])
    return Finding(
        "The smallest element of P shows that b is the best identified parameter",
        PARTLY if best == "b" else FAILS,
        f"Its coefficient C4 has the smallest variance in {percent(literal)} of runs in the printed units, and in "
        f"{percent(normalised)} once every column of h is brought to one size: its column n|n| is hundreds of times "
        f"larger than the others. Median relative error by least squares: "
        f"{', '.join(f'{quantity} {percent(x)}' for quantity, x in errors.items())}; the best one is {best}.",
    )


def open_water(r: Results) -> Finding:
    """The paper: Model III of data set 1 agrees with observations in open water."""
    table = published()[3].values
    n = FULL_SCALE_RPM * RPM_REV_S
    speed = steady_speed(float(table["a"][0]), float(table["b"][0]), float(table["gamma"][0]), n)
    physical = steady_speed(*r.study.truths[LOW_DRAG][:3], n)
    return Finding(
        "Table 3, data set 1, agrees with the vehicle's performance in open water",
        FAILS if speed < 0.5 * CRUISE_FT_S else HOLDS,
        f"At {FULL_SCALE_RPM:g} rpm it gives a steady {speed:.2f} ft/s, where Brutzman's model of the vehicle has "
        f"{CRUISE_FT_S:.1f} and the physical truth {physical:.2f} ft/s.",
    )
