"""Findings on what the paper's estimator does to the drag, and on what the records hold."""

from __future__ import annotations

from collections.abc import Iterator

from ...plant import to_feet
from ...units import FOOT_M
from .campaign import Campaign
from .evidence import (
    FAILS,
    HIGH_DRAG,
    HOLDS,
    LOW_DRAG,
    PARTLY,
    WITHIN,
    Finding,
    Results,
    apart,
    band,
    median,
    percent,
    pure_noise,
    span,
    told,
    within,
)
from .published import PARAMETERS, SETS, brutzman_a_per_ft, published
from .records import CASES
from .study import QUANTITIES, quantiles

ALIKE = 0.1  # distance of a probability from one half up to which two vehicles count as not told apart; a convention
TAU = QUANTITIES.index("tau")


def size(r: Results) -> Finding:
    """Does a low-drag vehicle come out with the published drag?"""
    printed = published()[2].values["a"]
    a = {truth: r.study.of(truth, "method", "kalman", "kalman")[..., 0] for truth in r.study.truths}
    share = {truth: within(values, printed) for truth, values in a.items()}
    parts = "; ".join(
        f"{truth} (true a {r.study.truths[truth][0]:.3f}) {band(quantiles(values), 2)}, within a factor of "
        f"{WITHIN:g} of the print in {percent(share[truth])} of runs"
        for truth, values in a.items()
    )
    verdict = HOLDS if share[LOW_DRAG] >= 0.8 * share[HIGH_DRAG] else FAILS
    blown = quantiles(a[LOW_DRAG])[1] / brutzman_a_per_ft()
    return told("size", verdict, parts=parts, printed=span(printed, 2), blown=blown)


def blind(r: Results) -> Finding:
    """Does the estimate tell vehicles apart?"""
    kalman, stages, lse = (apart(r.study, method) for method in ("kalman", "two_stage", "least_squares"))
    return told(
        "blind",
        HOLDS if abs(kalman - 0.5) <= ALIKE else FAILS,
        lowest=r.calibration.multiples[0],
        highest=r.calibration.multiples[-1],
        curve=span(r.calibration.bands[LOW_DRAG, "kalman"][:, 0, 1], 2),
        more=r.study.truths[HIGH_DRAG][0] / r.study.truths[LOW_DRAG][0],
        kalman=kalman,
        stages=stages,
        lse=lse,
    )


def noise_free(r: Results) -> Finding:
    """What is left of the printed estimator without noise?"""
    low, high = (median(r.study, truth, "noise", "none", "kalman", "a") for truth in (LOW_DRAG, HIGH_DRAG))
    true_low, true_high = (r.study.truths[truth][0] for truth in (LOW_DRAG, HIGH_DRAG))
    verdict = HOLDS if abs(high) < 0.3 * abs(true_high) else FAILS
    values = {"found_low": low, "found_high": high, "true_low": true_low, "true_high": true_high}
    return told("noise_free", verdict, **values)


def origin(r: Results) -> Finding:
    """Filter alone, noise alone, both."""
    truth = r.study.truths[LOW_DRAG][0]
    times = {case: median(r.study, LOW_DRAG, "part", case, "least_squares", "a") / truth for case in CASES}
    alone, on_both, noise = times["exact"], times["filter u,n"], times["noise"]
    return told(
        "origin",
        (FAILS, PARTLY, HOLDS)[sum(size > WITHIN for size in (on_both, noise))],
        alone=alone,
        on_u=times["filter u"],
        on_both=on_both,
        noise=noise,
        both=times["recorded"],
        singly=on_both + noise - 2.0 * alone,
        together=times["recorded"] - alone,
    )


def step(r: Results) -> Finding:
    """The regression step."""
    short, long = (
        {truth: median(r.study, truth, "T", f"{t:g} s", "least_squares", "tau") for truth in r.study.truths}
        for t in (0.1, 0.5)
    )
    parts = (f"{tau:.3f} s for a true {r.study.truths[t][TAU]:.3g} s ({t})" for t, tau in short.items())
    verdict = HOLDS if all(abs(tau - 0.1) < 0.05 for tau in short.values()) else FAILS
    return told("step", verdict, short=", ".join(parts), long=", ".join(f"{tau:.2f} s" for tau in long.values()))


def noise_as_drag(r: Results) -> Finding:
    """What the regression makes of noise alone."""
    step_s = 0.5
    taus = [median(r.study, truth, "T", f"{step_s:g} s", "least_squares", "tau") for truth in r.study.truths]
    name = LOW_DRAG if LOW_DRAG in r.campaigns else next(iter(r.campaigns))
    left = r.campaigns[name].truth_statistics(0).deviation / FOOT_M
    a, tau = pure_noise(left, step_s)
    return told(
        "noise_as_drag",
        HOLDS if all(abs(value / tau - 1.0) < 0.2 for value in taus) else PARTLY,
        left=left,
        name=name,
        a=a,
        tau=tau,
        step_s=step_s,
        found=", ".join(f"{value:.2f}" for value in taus),
        true=", ".join(f"{values[TAU]:.3g}" for values in r.study.truths.values()),
    )


def settling(r: Results) -> Finding:
    """What a Q that settles does."""
    calm, lse = (
        {t: r.study.of(t, "method", method, method)[..., 0] for t in r.study.truths}
        for method in ("kalman_settling", "least_squares")
    )
    medians = {t: (quantiles(calm[t])[1], quantiles(lse[t])[1]) for t in r.study.truths}
    by_set = [quantiles(lse[LOW_DRAG][:, data_set])[1] for data_set in range(SETS)]
    truth, printed = r.study.truths[LOW_DRAG][0], published()[2].values["a"]
    reached = sum(a / p >= 0.5 for a, p in zip(by_set, printed, strict=True))
    same = all(abs(one - other) < 0.15 * max(abs(other), 0.1) for one, other in medians.values())
    return told(
        "settling",
        HOLDS if same and reached < SETS else PARTLY,
        medians=", ".join(f"{t} {one:.2f} and {other:.2f}" for t, (one, other) in medians.items()),
        times=medians[LOW_DRAG][1] / truth,
        by_set=", ".join(f"{a / truth:.0f}" for a in by_set),
        reached=reached or "none",
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


CENTRAL = (size, blind, noise_free, noise_as_drag, origin, step, settling, likelihood)  # as the page has them
