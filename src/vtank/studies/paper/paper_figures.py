"""Figures 1 to 12 in the paper's form, with the truth drawn in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from ...estimate import free_run_beside, residual_coherence, residual_statistics
from ...estimate.paper import Array, Model, PaperEstimate, fit_linear
from ...plant import to_feet
from ...present.canvas import (
    BLUE,
    CRIMSON,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    PUBLISHED,
    PURPLE,
    SKY,
    TRUTH,
    drawn,
    legend_below,
    page,
)
from ...units import FOOT_M
from .campaign import Campaign
from .published import OF_MODEL, PARAMETERS, published

NAMES = {"a": "a [1/ft]", "b": "b [ft/rev²]", "gamma": "γ [1/rev]", "tau": "τ [s]"}
TABLE_OF_MODEL = {"I": 1, "II": 2, "III": 3}
COEFFICIENTS = ("C1 = Ta", "C2 = T/τ", "C3 = T²a/τ", "C4 = T²b/τ", "C5 = Tγ", "C6 = T²γ/τ")
COEFFICIENTS_I = ("C1 = Ta", "C2 = Tb")
FREQUENCIES_RAD_S = (0.5, 0.4, 0.7, 0.2)  # of the position command, data sets 1 to 4 (the paper's section IV)
CHANCE_COHERENCE = 0.35  # [-] exceeded once in 20 by independent records averaged over 8 segments: 1 - 0.05^(1/7)
CHOICES = (("", "printed q_ii"), ("_settling", "a Q that settles"))  # suffix of the method, what it is called
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)

Panel = tuple[str, list[tuple[Array, str, str]]]  # title; free run [m/s], label and colour of each curve
Shown = tuple[str, Model, str, str]  # method, model, label and colour
CROSSED: tuple[Shown, ...] = (
    ("kalman", "I", "Model I", ORANGE),
    ("kalman", "II", "Model II", BLUE),
    ("two_stage", "II", "Model II, two-stage", GREEN),
    ("kalman", "III", "Model III", PURPLE),
)
STAGES: tuple[Shown, ...] = (("kalman", "II", "one stage", BLUE), ("two_stage", "II", "two-stage", GREEN))
Panels = Callable[[Campaign, int], Iterable[Panel]]


def plan(campaign: Campaign) -> dict[str, tuple[str, Any]]:
    """Name of each figure's file -> caption and a function that draws it."""
    c = campaign
    drawings: dict[str, tuple[str, Any]] = {}

    def add(number: str, caption: str, draw: Any, *arguments: Any) -> None:
        full = f"Figure {number}. {caption}"
        drawings[f"figure-{number.replace('-', '').zfill(3 if number[-1].isalpha() else 2)}"] = (
            full,
            lambda: draw(f"{full}  Truth: {c.truth.name}", c, *arguments),
        )

    add("1-a", "Parameter evolution for Model I (Data set 1).", evolution, "kalman", "I")
    add("1-b", "Model comparison for Model I (Data set 1).", comparison, "kalman", "I")
    add("2-a", "Parameter evolution for Model II (Data set 1).", evolution, "kalman", "II")
    add("2-b", "Model comparison for Model II (Data set 1).", comparison, "kalman", "II")
    add("3", "Coherence and residuals for Model II (Data set 1).", coherence, "kalman", "II")
    add("4", "Parameter evolution for Model III (Data set 1).", evolution, "kalman", "III")
    add("5", "Model comparison for Model III (Data set 1).", comparison, "kalman", "III")
    add("6", "Coherence and residuals for Model III (Data set 1).", coherence, "kalman", "III")
    add("7-a", "Parameter evolution, Model II, two-stage, b/τ constant (Data set 1).", evolution, "two_stage", "II")
    add("7-b", "Model comparison, Model II, two-stage, b/τ constant (Data set 1).", comparison, "two_stage", "II")
    add("8", "Coherence and residuals, Model II, two-stage (Data set 1).", coherence, "two_stage", "II")
    for number, data_set in (("9", 1), ("10", 2), ("11", 3)):
        against = f"against data set {data_set + 1}"
        add(f"{number}-a", f"Models derived from data set 1 {against}.", responses, data_set, crossed)
        add(f"{number}-b", f"One stage and two-stage Model II (Data set {data_set + 1}).", responses, data_set, stages)
    add("12", "Linear model, LSE and two-stage Kalman filter (Data set 2).", responses, 1, linear)
    return drawings


@drawn
def evolution(title: str, c: Campaign, method: str, model: Model) -> Any:
    """Estimates after every step, and the diagonal of P beside them."""
    names = OF_MODEL[model]
    literal, settling = c.paper[method, model, 0], c.paper[f"{method}_settling", model, 0]
    figure = page(title, 10.5, 1.5 + 1.45 * len(names))
    left, right = figure.subfigures(1, 2, width_ratios=(1.65, 1.0))
    axes = left.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    time = literal.signals.time_s[-literal.rows.z.size :]
    table = published()[4 if method == "two_stage" else TABLE_OF_MODEL[model]]
    truth = dict(zip(PARAMETERS, to_feet(c.truth.lumped), strict=True))
    for ax, name in zip(axes, names, strict=True):
        one, other = _feet(literal)[:, PARAMETERS.index(name)], _feet(settling)[:, PARAMETERS.index(name)]
        ax.plot(time, one, color=ORANGE, lw=1.0, label=f"printed q_ii = {table.values['q_ii'][0]:g}")
        ax.plot(time, other, color=BLUE, lw=1.6, label="a Q that settles")
        ax.axhline(truth[name], **TRUTH)
        ax.axhline(table.values[name][0], **PUBLISHED)
        ax.set(ylabel=NAMES[name], ylim=_limits(one, other, truth[name], float(table.values[name][0])))
        _last_values(ax, ((one[-1], ORANGE), (other[-1], BLUE)))
    axes[0].set_title("Parameter estimates; at the right their last values, which the tables show")
    axes[-1].set_xlabel("time [s]")
    _variances(right, literal, settling, time, COEFFICIENTS_I if model == "I" else COEFFICIENTS)
    legend_below(figure, axes)
    return figure


def _last_values(ax: Any, values: Any) -> None:
    """The last value of each curve beside the panel, kept apart."""
    low, high = ax.get_ylim()
    heights = [min(max((value - low) / (high - low), 0.02), 0.98) for value, _ in values]
    if abs(heights[0] - heights[1]) < 0.14:
        middle, up = sum(heights) / 2.0, 1.0 if heights[0] >= heights[1] else -1.0
        heights = [middle + 0.07 * up, middle - 0.07 * up]
    for (value, colour), height in zip(values, heights, strict=True):
        ax.text(1.01, height, f"{value:.3g}", transform=ax.transAxes, color=colour, fontsize=8, va="center")


def _variances(figure: Any, literal: PaperEstimate, settling: PaperEstimate, time: Array, names: Any) -> None:
    """Diagonal of P over time, the two choices of Q in panels of their own."""
    upper, lower = figure.subplots(2, 1, sharex=True)
    for ax, estimate, (_, choice) in zip((upper, lower), (literal, settling), CHOICES, strict=True):
        for k, colour in zip(range(estimate.evolution.variance.shape[1]), COLOURS, strict=False):
            ax.semilogy(time, estimate.evolution.variance[:, k], color=colour, label=names[k])
        ax.set_title(f"Diagonal of P, {choice}")
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=7.5, handlelength=1.2)
    lower.set_xlabel("time [s]")


@drawn
def comparison(title: str, c: Campaign, method: str, model: Model) -> Any:
    """Measured speed, true speed and the model's free run from the propeller speed."""
    figure = page(title, 10.5, 5.2)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.4, 1.0))
    _measured(above, c, 0)
    for name, label, colour in _choices(method, model):
        _response(above, c, 0, c.paper[name, model, 0].simulated_m_s, label, colour)
    signals = c.signals(0)
    below.plot(signals.time_s, signals.n_rev_s, color=GREY, lw=1.0)
    below.set(xlabel="time [s]", ylabel="n [rev/s]", title="Propeller speed, filtered as in the paper")
    return figure


def _choices(method: str, model: Model) -> list[tuple[str, str, str]]:
    """(method, label, colour) with the printed Q and with one that settles."""
    return [(f"{method}{suffix}", f"Model {model}, {name}", colour)
            for (suffix, name), colour in zip(CHOICES, (ORANGE, BLUE), strict=True)]  # fmt: skip


@drawn
def coherence(title: str, c: Campaign, method: str, model: Model) -> Any:
    """Coherence between surge speed and residuals, and the residuals; beside them what the true model leaves."""
    figure = page(title, 10.5, 5.6)
    above, below = figure.subplots(2, 1)
    signals = c.signals(0)
    perfect = signals.u_m_s - c.true_u_m_s(0)
    frequency, value = residual_coherence(signals.u_m_s, perfect, signals.step_s)
    above.plot(frequency, value, **TRUTH | {"label": "the true model (error of the sonar filter alone)"})
    below.plot(signals.time_s, perfect / FOOT_M, **TRUTH)
    shown = [perfect]
    for name, label, colour in _choices(method, model):
        estimate = c.paper[name, model, 0]
        if not estimate.diverged:
            above.plot(*estimate.coherence, color=colour, marker="o", ms=3, label=label)
        below.plot(signals.time_s, estimate.residuals_m_s / FOOT_M, color=colour, lw=1.0)
        shown.append(estimate.residuals_m_s)
    above.axhline(CHANCE_COHERENCE, color=PALE, lw=1.0)
    above.text(6.2, CHANCE_COHERENCE, "chance, 1 in 20", color=GREY, fontsize=8, ha="right", va="bottom")
    above.axvline(FREQUENCIES_RAD_S[0], color=PALE, lw=1.0)
    above.set(ylim=(0, 1.02), xlim=(0, 2 * np.pi), xlabel="frequency [rad/s]", ylabel="C_ue [-]")
    above.set_title("Coherence between u and the residuals; the upright line is the commanded frequency")
    below.set(xlabel="time [s]", ylabel="e [ft/s]", title="Residuals e: measured speed less free run")
    bulk = max(float(np.quantile(np.abs(e[np.isfinite(e)]), 0.98)) for e in shown) / FOOT_M
    widest = 1.5 * float(np.abs(signals.u_m_s).max()) / FOOT_M
    below.set(ylim=_around(np.array([min(bulk, widest)]), 1.25), xlim=(0.0, signals.time_s[-1]))
    legend_below(figure, [above])
    return figure


@drawn
def responses(title: str, c: Campaign, data_set: int, panels: Panels) -> Any:
    """Measured and true speed, and free runs of models, panel below panel."""
    found = list(panels(c, data_set))
    figure = page(title, 10.5, 3.0 * len(found))
    for ax, (name, curves) in zip(figure.subplots(len(found), 1, sharex=True), found, strict=True):
        _measured(ax, c, data_set)
        for run, label, colour in curves:
            _response(ax, c, data_set, run, label, colour)
        ax.set_title(name)
    ax.set_xlabel("time [s]")
    return figure


def crossed(c: Campaign, data_set: int) -> Iterator[Panel]:
    """Models of data set 1 driven by the propeller speed of another."""
    return _by_choice(c, data_set, 0, "Identified on data set 1", CROSSED)


def stages(c: Campaign, data_set: int) -> Iterator[Panel]:
    """One and two stages of Model II, identified on the data set that is shown."""
    return _by_choice(c, data_set, data_set, f"Model II identified on data set {data_set + 1}", STAGES)


def _by_choice(c: Campaign, data_set: int, origin: int, title: str, shown: tuple[Shown, ...]) -> Iterator[Panel]:
    """Free runs on a data set of the models of another, with the printed Q and with one that settles."""
    seen = c.signals(data_set)
    for suffix, name in CHOICES:
        curves = []
        for method, model, label, colour in shown:
            parameters = c.paper[f"{method}{suffix}", model, origin].parameters
            curves.append((free_run_beside(seen.u_m_s, seen.n_rev_s, seen.step_s, parameters), label, colour))
        yield f"{title} with {name}", curves


def linear(c: Campaign, data_set: int) -> Iterator[Panel]:
    """The linear model (23), least squares and the two-stage estimator; maximum likelihood below."""
    signals = c.signals(data_set)
    straight = fit_linear(signals.u_m_s, signals.n_rev_s, signals.step_s)
    found = {name: c.paper[name, "II", data_set].simulated_m_s for name in ("least_squares", "two_stage")}
    yield (
        "As in the paper; LSE and Kalman filter are of Model II",
        [
            (straight.free_run(signals.n_rev_s, signals.u_m_s), "linear model (23)", PURPLE),
            (found["least_squares"], "LSE", ORANGE),
            (found["two_stage"], "two-stage KF, printed q_ii", GREEN),
        ],
    )
    yield (
        "Beside it, Model II as well",
        [
            (c.paper["two_stage_settling", "II", data_set].simulated_m_s, "two-stage KF, settling Q", BLUE),
            (c.likelihood["II", data_set].simulated_m_s, "maximum likelihood", CRIMSON),
        ],
    )


def _feet(estimate: PaperEstimate) -> Array:
    """a, b, gamma, tau after each step in the paper's units, shape (rows, 4)."""
    return estimate.parameter_evolution * np.array([FOOT_M, 1.0 / FOOT_M, 1.0, 1.0])


def _limits(one: Array, other: Array, truth: float, printed: float) -> tuple[float, float]:
    """Limits that show truth, print, settled and last estimates; of the swings as much as leaves those legible."""
    late, settled = one[one.size // 2 :], other[other.size // 3 :]
    core = [truth, one[-1], *np.quantile(settled[np.isfinite(settled)], (0.0, 1.0))]
    core += [printed] if np.isfinite(printed) else []
    low, high = min(core), max(core)
    span = max(high - low, 0.3 * abs(truth), 1e-3)
    swing = np.quantile(late[np.isfinite(late)], (0.1, 0.9))
    low, high = min(low, max(swing[0], low - span)), max(high, min(swing[1], high + span))
    return low - 0.15 * span, high + 0.15 * span


def _around(values: Array, factor: float) -> tuple[float, float]:
    top = factor * float(np.nanmax(np.abs(values)))
    return -top, top


def _measured(ax: Any, c: Campaign, data_set: int) -> None:
    signals = c.signals(data_set)
    ax.plot(signals.time_s, signals.u_m_s / FOOT_M, color=PALE, lw=3.5, label="measured\n(sonar filter)")
    ax.plot(signals.time_s, c.true_u_m_s(data_set) / FOOT_M, **TRUTH | {"label": "true speed"})
    ax.set(ylabel="u [ft/s]", ylim=_around(signals.u_m_s / FOOT_M, 1.5), xlim=(0.0, signals.time_s[-1]))


def _response(ax: Any, c: Campaign, data_set: int, run: Array, label: str, colour: str) -> None:
    """A free run; the legend tells what it leaves of the measured speed, or that it was given up."""
    signals = c.signals(data_set)
    deviation = residual_statistics(signals.u_m_s, run).deviation / FOOT_M
    found = f"s_e = {deviation:.3f} ft/s" if np.isfinite(deviation) else "diverges"
    ax.plot(signals.time_s, run / FOOT_M, color=colour, label=f"{label}\n{found}")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.4)
