"""Figures of the joint judgement: what the four published sets say about T, and about the drag."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...present.canvas import BLUE, GREEN, GREY, INK, ORANGE, PUBLISHED, VERMILION, drawn, legend_below, page, shades
from .evidence import Results
from .joint import MULTIPLES, READINGS, STEPS_S, step_prior
from .published import brutzman_a_per_ft, published
from .study import QUANTITIES, quantiles

READ = dict(zip(READINGS, ("a Q that settles", "q_ii = 1 as printed"), strict=True))


@drawn
def sample_time(r: Results) -> Any:
    """What the four sets say about T: the printed lag and residual beside simulated ones, and the share of each T."""
    figure = page("What the four published sets say about the sample time T", 12.5, 4.6)
    lag, rest, share = figure.subplots(1, 3)
    printed, x = published()[2].values, np.array(STEPS_S)
    for ax, quantity, row in ((lag, "tau", "tau"), (rest, "s_e", "deviation")):
        for drag, colour in ((0, GREEN), (len(MULTIPLES) - 2, BLUE)):
            values = r.joint.estimates[READINGS[0]][drag, ..., QUANTITIES.index(quantity)].reshape(x.size, -1)
            low, middle, high = np.array([quantiles(of) for of in values]).T
            label = f"least squares, {MULTIPLES[drag]:g} times Brutzman's drag:\nmedian and 10-90 % over worlds"
            ax.fill_between(x, low, np.nan_to_num(high, nan=np.nanmax(high)), color=colour, alpha=0.18, lw=0)
            ax.plot(x, middle, "o-", ms=3, color=colour, label=label)
        for value in printed[row]:
            ax.axhline(value, **PUBLISHED)
    lag.plot(x, 2.0 * x / 3.0, color=INK, lw=1.2, ls=(0, (5, 2)), label="noise alone: 2T/3")
    lag.set(title="lag", ylabel="tau [s]", ylim=(0.0, 1.4))
    rest.set(title="residual of the free run", ylabel="s_e [ft/s]", ylim=(0.0, 0.5))
    for reading, colour in zip(READINGS, (INK, ORANGE), strict=True):
        share.plot(x, r.joint.over(reading, "step"), "o-", ms=3, color=colour, label=READ[reading])
    share.plot(x, step_prior(), color=GREY, lw=1.0, ls=(0, (1, 1.5)), label="before: log-uniform")
    share.set(title="share of each T, given the four sets", ylim=(0.0, None))
    for ax in (lag, rest, share):
        ax.set(xlabel="T [s]")
    legend_below(figure, [lag, share], 3)
    return figure


@drawn
def true_drag(r: Results) -> Any:
    """Likelihood of the true drag: T unknown, at each T, and both together."""
    figure = page("Which true drag the four published sets stand for, judged together", 12.5, 4.6)
    both, at_step, printed = figure.subplots(1, 3)
    places = range(len(MULTIPLES))
    for ax, reading in ((both, READINGS[0]), (printed, READINGS[1])):
        image = ax.imshow(r.joint.map(reading).T, origin="lower", aspect="auto", cmap="Blues", vmin=0.0)
        ax.set(title=f"share of drag and T: {READ[reading]}", ylabel="T [s]")
        ax.set_yticks(range(len(STEPS_S)), [f"{step:g}" for step in STEPS_S])
        ax.grid(visible=False)
        figure.colorbar(image, ax=ax)
    of_step = r.joint.likelihoods[READINGS[0]].sum(axis=(0, 3))
    shown = [k for k, step in enumerate(STEPS_S) if step in (0.3, 0.5, 0.7, 0.8, 0.9, 1.2)]
    for k, colour in zip(shown, shades(len(shown)), strict=True):
        at_step.plot(places, of_step[:, k] / of_step[:, k].max(), color=colour, lw=1.0, label=f"T = {STEPS_S[k]:g} s")
    whole = of_step.sum(axis=1)
    at_step.plot(places, whole / whole.max(), "o-", color=INK, lw=2.2, label="T unknown")
    at_step.set(title="likelihood over the largest: a Q that settles", ylim=(0.0, 1.05))
    taken = np.log2(published()[2].values["a"] / brutzman_a_per_ft())
    for ax in (both, at_step, printed):
        ax.axvspan(taken.min(), taken.max(), color=VERMILION, alpha=0.13, lw=0, label="published, at its word")
        ax.set_xticks(places, [f"{multiple:g}" for multiple in MULTIPLES])
        ax.set(xlabel="true drag / Brutzman's", xlim=(-0.5, len(MULTIPLES) - 0.5))
    legend_below(figure, [at_step], 8)
    return figure


JOINT_PICTURES: dict[str, tuple[str, Callable[..., bytes]]] = {  # file name without suffix -> caption, drawing
    "study-sample-time": ("Printed lag and residual beside simulated ones, and what they make of T.", sample_time),
    "study-drag": ("True drag and T that the four published sets stand for, judged together.", true_drag),
}
