"""Tables of a study: bounds, effects, estimators."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...estimate import Noise
from ...present import FEET, NAMES, UNITS, Table, number
from .design import Design, Item, minutes
from .estimators import LIKELIHOOD, METHODS, TITLES
from .study import Study
from .trials import Trials
from .verdicts import Verdict


def bounds_sheet(study: Study) -> Table:
    """Cramer-Rao bounds of the parameters, SI, feet and per cent, with their correlations."""
    names = [NAMES[slot] for slot in study.free]
    header = ("parameter", "truth", "bound", "unit", "truth", "bound", "unit", "bound %", *names)
    rows = []
    for i, name in enumerate(names):
        factor, unit = FEET[name]
        value, bound = float(study.true[i]), float(study.bound[i])
        si = number(value, 5), number(bound, 2), UNITS["n_rev_s"][name]
        feet = number(value * factor, 5), number(bound * factor, 2), unit
        correlation = (f"{c:+.3f}" for c in study.correlation[i])
        rows.append((name, *si, *feet, f"{100.0 * study.relative[i]:.3g}", *correlation))
    noise = study.flown[0].noise
    note = (
        f"Condition of the scaled information: {study.condition:.3g}. Initial speed, place and thrust of every run are "
        f"unknown. Noise of a range, rounding included: {1e3 * np.sqrt(noise.variance[0]):.2g} mm"
        f"{_disturbance(noise)}. Right: correlations."
    )
    title = f"Cramer-Rao bounds of Model {study.model}, truth {study.truth.name}, {study.information.minutes:g} min"
    return Table(header, tuple(rows), (note,), name="bounds", title=title)


def _disturbance(noise: Noise) -> str:
    if noise.sigma == 0.0:
        return "; the propeller speed is taken as recorded, without error"
    text = f"; turbulence and noise of the tachometer as a disturbance of {noise.sigma:.2g} m/s2 that lasts"
    return f"{text} {noise.correlation_time:.2g} s, by the innovations of a Kalman filter (first run)"


def effects_sheet(study: Study) -> Table:
    """Every effect of the catalogue: typical size, what is seen of it, and its nearest rival."""
    header = ("effect", "standing", "nearest rival", "apart", "typical", "seen from", "unit", "raw", "left", "kept %")
    rows = tuple(_effect_row(v) for v in study.verdicts)
    notes = (
        "raw, left: deviations of the noise that the typical size brings before and after the refit of the model and "
        "of the initial states; kept: their ratio; seen from: size that leaves 3; apart: deviations that the nearest "
        "rival leaves, refitted as well. Below 3: absorbed (not identifiable), too small, or tied (indistinguishable).",
    )
    title = "Effects of the catalogue at their typical size"
    return Table(header, rows, notes, left=3, name="effects", title=title)


def _effect_row(v: Verdict) -> tuple[str, ...]:
    rival, apart = v.rivals[0] if v.rivals and v.standing != "absorbed" else ("-", float("nan"))
    seen = (f"{v.size:.2g}", number(v.needed, 2), v.unit)
    sizes = (number(v.signature, 3), f"{v.left:.3g}" if v.left > 1e-3 else "0", f"{100.0 * v.kept:.3g}")
    apart_text = "-" if np.isnan(apart) else f"{apart:.3g}" if apart > 1e-3 else "0"
    return (v.effect.name, v.standing, rival, apart_text, *seen, *sizes)


def trials_sheet(t: Trials) -> Table:
    """Bias, spread over bound and coverage of all estimators, side by side."""
    header = ("parameter", "estimator", "bias %", "+-", "spread/bound", "+-", "coverage %", "claimed/bound")
    rows = []
    for i, slot in enumerate(t.names):
        for method in METHODS:
            bias, doubt = (100.0 * values[i] for values in t.bias(method))
            ratio = t.spread_over_bound(method)[i]
            claimed = float(np.nanmedian(t.claimed[method][:, i]) / t.bound[i])
            row = (f"{bias:+.3g}", f"{doubt:.2g}", f"{ratio:.3g}", f"{0.9 * ratio / np.sqrt(t.seeds):.2g}")
            cells = (*row, f"{100.0 * t.coverage(method)[i]:.0f}", f"{claimed:.3g}")
            rows.append((NAMES[slot] if method == LIKELIHOOD else "", TITLES[method], *cells))
    doubt = 196.0 * np.sqrt(0.0475 / t.seeds)
    notes = (
        "bias: median error; spread: half the central 68 %; both with their own deviation. Coverage of the claimed "
        f"95 % intervals, +- {doubt:.2g} where it is 95. The Kalman filter and its two-stage form claim the covariance "
        "of their own coefficients, which stands for the printed Q and R and not for the data; least squares takes its "
        "equation errors for white, which a filtered and twice differenced sonar is not.",
    )
    title = f"Four estimators on the same recordings, {t.seeds} seeds"
    return Table(header, tuple(rows), notes, left=2, name="estimators", title=title)


def design_sheet(study: Study, d: Design) -> Table:
    """The designed plan, its bounds and those of the given one in the same time."""
    names = [NAMES[slot] for slot in d.free]
    header = ("runs", "what", "min each", *(f"{name} bound %" for name in names))
    rows = [(f"{count}", item.words, f"{item.information.minutes:g}", *_percent(d, [item] * count))
            for count, item in d.counted()]  # fmt: skip
    rows.append((f"{len(d.items)}", "designed plan, with rest", f"{minutes(d.items):g}", *_percent(d, d.items)))
    rows.append((f"{len(d.given)}", "given plan, with rest", f"{minutes(d.given):g}", *_percent(d, d.given)))
    rows.append(("", "given over designed, at equal time", "", *(f"{g:.2f}" for g in d.gain_per_minute)))
    limit = study.truth.n_limit_rev_s
    note = (
        "Least sum of squared relative bounds among sinusoids, pairs of them, multisines, sweeps, squares, pushes and "
        f"open-loop sinusoids that keep 0.1 m from the walls and the propellers below {limit:g} rev/s 99 % of the time "
        "on the surge model, and clear of the walls in the tank. Best for this truth and model: another truth, another "
        "plan; look at the effects it separates as well."
    )
    return Table(header, tuple(rows), (note,), left=2, name="design", title="A better plan in the same time")


def _percent(d: Design, items: Sequence[Item]) -> tuple[str, ...]:
    return tuple(f"{100.0 * value:.3g}" for value in d.relative(items))
