"""Findings on the paper's own claims."""

from __future__ import annotations

import numpy as np

from ...estimate import residual_coherence
from ...estimate.paper import MODELS, Array
from ...units import RPM_REV_S
from .central import ALIKE
from .evidence import FAILS, HOLDS, LOW_DRAG, PARTLY, Finding, Results, numbers, percents, steady_speed, told
from .published import SETS, published

FULL_SCALE_RPM, CRUISE_FT_S = 700.0, 2.0  # both propellers, steady: "speed_per_rpm = 2/700" in Brutzman's SUBmodel.h
PAIR = ("kalman", "kalman_settling")  # the printed Q and one that settles


def filter_on_n(r: Results) -> Finding:
    """The paper: filtering n too leaves a minimal effect."""
    truths = r.study.truths

    def a(truth: str, factor: str, label: str) -> Array:
        return r.study.medians(truth, factor, label, "least_squares", "a")

    error = {t: [np.abs(a(t, "filter on n", on) - truths[t][0]) for on in ("yes", "no")] for t in truths}
    moved = {t: a(t, "part", "filter u,n") - a(t, "part", "exact") for t in truths}
    return told(
        "filter_on_n",
        np.all([np.abs(by) <= ALIKE * abs(truths[t][0]) for t, by in moved.items()], axis=0),
        errors="; ".join(f"{t} {numbers(on)} with and {numbers(off)} without" for t, (on, off) in error.items()),
        moved="; ".join(f"{t} {numbers(by)}" for t, by in moved.items()),
    )


def stages(r: Results) -> Finding:
    """The paper: a relevant improvement by two stages."""
    better, medians = [], []
    for ways in (("kalman", "two_stage"), ("kalman_settling", "two_stage_settling")):
        one, two = (r.practice.own(method, "II") for method in ways)
        better.append(np.mean(two < one, axis=1))
        medians += [numbers(np.median(of, axis=1)) for of in (two, one)]
    return told(
        "stages",
        np.minimum(*better) > 0.5,
        better=percents(better[0]),
        calmer=percents(better[1]),
        medians=f"{medians[0]} against {medians[1]}",
        calm=f"{medians[2]} against {medians[3]}",
    )


def third_model(r: Results) -> Finding:
    """The paper: Model III is best."""
    found = {m: np.array([np.median(r.practice.crossed(m, model), axis=(1, 2, 3)) for model in MODELS]) for m in PAIR}
    best = {method: np.argmin(values, axis=0) for method, values in found.items()}
    return told(
        "third_model",
        np.all([index == MODELS.index("III") for index in best.values()], axis=0),
        printed=", ".join(MODELS[i] for i in best["kalman"]),
        settling=", ".join(MODELS[i] for i in best["kalman_settling"]),
    )


def generality(r: Results) -> Finding:
    """The paper: data set 1 gives the most general models."""
    wins = {}
    for method in PAIR:
        best = np.argmin(np.median(r.practice.crossed(method, "III"), axis=3), axis=2)
        wins[method] = np.stack([np.mean(best == data_set, axis=1) for data_set in range(SETS)])
    first = np.all([np.argmax(shares, axis=0) == 0 for shares in wins.values()], axis=0)
    printed, settling = (percents(wins[method][0]) for method in PAIR)
    return told("generality", first, printed=printed, settling=settling)


def same_as_lse(r: Results) -> Finding:
    """The paper: least squares similar, the Kalman filter more accurate."""
    one, two, lse = (r.practice.own(method, "II") for method in ("kalman", "two_stage", "least_squares"))
    wins = [np.mean(values < lse, axis=1) for values in (one, two)]
    medians = [numbers(np.median(values, axis=1)) for values in (one, lse)]
    return told("same_as_lse", np.maximum(*wins) > 0.5, one=percents(wins[0]), two=percents(wins[1]),
                kalman=medians[0], lse=medians[1])  # fmt: skip


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
    literal, normalised = np.mean(list(r.practice.smallest.values()), axis=0)
    errors = {}
    for i, quantity in ((0, "a"), (1, "b"), (3, "tau")):
        ratio = [r.study.of(t, "method", "least_squares", "least_squares")[..., i] / values[i]
                 for t, values in r.study.truths.items()]  # fmt: skip
        errors[quantity] = np.median(np.abs(np.concatenate(ratio, axis=1) - 1.0), axis=(1, 2))
    return told(
        "confidence",
        (normalised > 0.5) & (errors["b"] <= np.minimum(errors["a"], errors["tau"])),
        literal=percents(literal),
        normalised=percents(normalised),
        errors="; ".join(f"{quantity} {percents(x)}" for quantity, x in errors.items()),
    )


def open_water(r: Results) -> Finding:
    """The paper: Model III of data set 1 agrees with observations in open water."""
    table, n = published()[3].values, FULL_SCALE_RPM * RPM_REV_S
    speed = steady_speed(float(table["a"][0]), float(table["b"][0]), float(table["gamma"][0]), n)
    physical = steady_speed(*r.study.truths[LOW_DRAG][:3], n)
    verdict = FAILS if speed < 0.5 * CRUISE_FT_S else HOLDS
    return told("open_water", verdict, rpm=FULL_SCALE_RPM, speed=speed, cruise=CRUISE_FT_S, physical=physical)


CLAIMS = (filter_on_n, stages, third_model, generality, same_as_lse, coherence, confidence, open_water)
