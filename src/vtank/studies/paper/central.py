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
    blown = quantiles(a[LOW_DRAG])[1] / brutzman_a_per_ft()
    return Finding(
        "A vehicle with Brutzman's drag comes out of the paper's estimator with a drag of the published size",
        HOLDS if share[LOW_DRAG] >= 0.8 * share[HIGH_DRAG] else FAILS,
        f"Estimates of a [1/ft] with the printed q_ii = 1, median and 10-90 % over seeds and data sets: {parts}. The "
        f"print has {span(printed, 2)}; the low-drag vehicle is given {blown:.0f} times its true drag.",
    )


def blind(r: Results) -> Finding:
    """Does the estimate tell vehicles apart?"""
    kalman, stages, lse = (apart(r.study, method) for method in ("kalman", "two_stage", "least_squares"))
    curve = r.calibration.bands[LOW_DRAG, "kalman"][:, 0, 1]
    lowest, highest = r.calibration.multiples[0], r.calibration.multiples[-1]
    more = r.study.truths[HIGH_DRAG][0] / r.study.truths[LOW_DRAG][0]
    return Finding(
        "As printed, the estimator hardly measures the drag at all",
        HOLDS if abs(kalman - 0.5) <= ALIKE else FAILS,
        f"From {lowest:g} to {highest:g} times Brutzman's drag the median estimate of data set 1 stays at "
        f"{span(curve, 2)} /ft. Given one run of each vehicle, {HIGH_DRAG} ({more:.0f} times the drag of {LOW_DRAG}) "
        f"shows the larger drag with probability {kalman:.2f}, where a coin has 0.50; by the two-stage estimator "
        f"{stages:.2f}, by least squares on the same records {lse:.2f}.",
    )


def noise_free(r: Results) -> Finding:
    """What is left of the printed estimator without noise?"""
    low, high = (median(r.study, truth, "noise", "none", "kalman", "a") for truth in (LOW_DRAG, HIGH_DRAG))
    true_low, true_high = (r.study.truths[truth][0] for truth in (LOW_DRAG, HIGH_DRAG))
    return Finding(
        "With the printed q_ii and R the estimated drag comes from the noise",
        HOLDS if abs(high) < 0.3 * abs(true_high) else FAILS,
        f"Without any noise the median a is {high:+.3f} /ft for {HIGH_DRAG} (truth {true_high:.3f}) and {low:+.3f} "
        f"for {LOW_DRAG} (truth {true_low:.3f}): the products of speeds in h are so small against R = 0.01 that the "
        f"estimate hardly leaves its start at zero within the record. Noise in u, which enters both sides of the "
        f"regression, drives it away.",
    )


def origin(r: Results) -> Finding:
    """Filter alone, noise alone, both."""
    truth = r.study.truths[LOW_DRAG][0]
    times = {case: median(r.study, LOW_DRAG, "part", case, "least_squares", "a") / truth for case in CASES}
    alone, both = times["exact"], times["recorded"]
    large = sum(times[case] > WITHIN for case in ("filter u,n", "noise"))
    return Finding(
        "The sonar filter alone, without noise, and noise in u alone, without the filter, each bias the drag",
        (FAILS, PARTLY, HOLDS)[large],
        f"Least squares on {LOW_DRAG}, median of a over its true value: time step alone {alone:.1f}, sonar filter on "
        f"u {times['filter u']:.1f}, sonar filter on u and n {times['filter u,n']:.1f}, noise in u alone "
        f"{times['noise']:.1f}, all together {both:.1f}. Filter and noise, taken singly, add "
        f"{times['filter u,n'] + times['noise'] - 2.0 * alone:.1f} to the time step's share; together they add "
        f"{both - alone:.1f}. By data set they differ (table and figure).",
    )


def step(r: Results) -> Finding:
    """The regression step."""
    short, long = (
        {truth: median(r.study, truth, "T", f"{t:g} s", "least_squares", "tau") for truth in r.study.truths}
        for t in (0.1, 0.5)
    )
    parts = ", ".join(f"{tau:.3f} s for a true {r.study.truths[t][TAU]:.3g} s ({t})" for t, tau in short.items())
    return Finding(
        "At a step of 0.1 s the lag collapses to about the step",
        HOLDS if all(abs(tau - 0.1) < 0.05 for tau in short.values()) else FAILS,
        f"Median tau by least squares at T = 0.1 s: {parts}. At T = 0.5 s: "
        f"{', '.join(f'{tau:.2f} s' for tau in long.values())}, in the same order.",
    )


def noise_as_drag(r: Results) -> Finding:
    """What the regression makes of noise alone."""
    step_s = 0.5
    taus = [median(r.study, truth, "T", f"{step_s:g} s", "least_squares", "tau") for truth in r.study.truths]
    name = LOW_DRAG if LOW_DRAG in r.campaigns else next(iter(r.campaigns))
    left = r.campaigns[name].truth_statistics(0).deviation / FOOT_M
    a, tau = pure_noise(left, step_s)
    return Finding(
        "The regression reads noise as drag, and as a lag of two thirds of the step",
        HOLDS if all(abs(value / tau - 1.0) < 0.2 for value in taus) else PARTLY,
        f"White noise of deviation s in u and no motion at all would give a = -sqrt(2/pi)/(3 s T) and tau = 2T/3. The "
        f"sonar filter's own error of {left:.3f} ft/s ({name}, data set 1) would, were it white, make {a:.1f} /ft and "
        f"{tau:.2f} s at T = {step_s:g} s; the motion dilutes the first and not the second: least squares gives tau = "
        f"{', '.join(f'{value:.2f}' for value in taus)} s for true lags of "
        f"{', '.join(f'{values[TAU]:.3g}' for values in r.study.truths.values())} s.",
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
    return Finding(
        "A Q that settles turns the estimator into least squares, whose artefact is smaller",
        HOLDS if same and reached < SETS else PARTLY,
        f"Medians of a [1/ft] with a normalised q_ii = 1e-6, and by least squares: "
        f"{', '.join(f'{t} {one:.2f} and {other:.2f}' for t, (one, other) in medians.items())}. For {LOW_DRAG} that "
        f"is still {medians[LOW_DRAG][1] / truth:.0f} times the truth, by data set "
        f"{', '.join(f'{a / truth:.0f}' for a in by_set)} times; it reaches half the published drag in "
        f"{reached or 'none'} of the {SETS} data sets.",
    )


def likelihood(r: Results) -> Finding:
    """What the same records hold."""
    found = {name: list(_likely(campaign)) for name, campaign in r.campaigns.items()}
    farthest = max(abs(value - true) / sd for entries in found.values() for _, value, sd, true in entries)
    lines = (
        f"{name}: {', '.join(f'{n} = {v:.4g} ± {sd:.2g} (truth {t:.4g})' for n, v, sd, t in entries)}"
        for name, entries in found.items()
    )
    return Finding(
        "The same records hold the true values",
        HOLDS if farthest < 3.5 else PARTLY,
        f"Maximum likelihood, which predicts the range instead of differentiating it, on the four runs of the tank "
        f"together: {'; '.join(lines)}. The farthest is {farthest:.1f} standard deviations off.",
    )


def _likely(campaign: Campaign) -> Iterator[tuple[str, float, float, float]]:
    """Name, estimate, standard deviation and truth of each parameter of the model that the truth is of, in feet."""
    estimate = campaign.joint["II" if campaign.truth.gamma_per_rev == 0.0 else "III"]
    values = zip(
        PARAMETERS, to_feet(estimate.parameters), estimate.sd_feet, to_feet(campaign.truth.lumped), strict=True
    )
    return ((name, value, sd, true) for name, value, sd, true in values if sd > 0.0)
