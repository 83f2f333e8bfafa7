"""What was identified, as tables of text and sentences: for the terminal, Markdown and CSV alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..channels import channels
from ..estimate.comparison import Comparison, Linear
from ..estimate.maximum_likelihood import Estimate
from ..estimate.paper.estimate import PaperEstimate
from ..estimate.residuals import ResidualStatistics
from ..plant.parameters import LUMPED
from ..units import FOOT_M
from .blocks import Table
from .numbers import number

NAMES = {slot: slot.split(".")[-1] for slot in LUMPED}
UNITS = {  # of each parameter by the input that drives the runs
    "n_rev_s": {"alpha": "1/m", "beta": "m/rev2", "gamma": "1/rev", "tau": "s"},
    "command": {"alpha": "1/m", "beta": "m/s2", "gamma": "1/s", "tau": "s"},
    "thrust_N": {"alpha": "1/m", "beta": "1/kg", "gamma": "-", "tau": "s"},
}
FEET = {"alpha": (FOOT_M, "1/ft"), "beta": (1.0 / FOOT_M, "ft/rev2"), "gamma": (1.0, "1/rev"), "tau": (1.0, "s")}
ESTIMATORS = {"kalman": "Kalman", "two_stage": "two-stage", "least_squares": "least squares"}


def sheets(c: Comparison, truth: Mapping[str, float] | None = None) -> list[Table]:
    """All tables of one model; truth: parameters by name, SI."""
    found = [parameters(c, truth), residuals(c)]
    if len(c.runs) > 1:
        found += [validation(c)]
    if c.paper:
        found += [methods(c, truth), linear(c)]
    return found


def parameters(c: Comparison, truth: Mapping[str, float] | None = None) -> Table:
    """The likelihood's answer from all runs together: SI, feet where the input is a propeller speed, and the truth."""
    kind = c.runs[0].input_name
    feet, simulated = kind == "n_rev_s", c.simulated is not c.joint
    header = ["parameter", "value", "sd", "95 % interval", "unit"]
    header += ["value", "sd", "unit"] if feet else []
    header += ["by simulation"] if simulated else []
    header += ["truth", "error/sd"] if truth else []
    rows = []
    for slot, value in c.joint.values.items():
        name, sd = NAMES[slot], c.joint.sd[slot]
        low, high = c.joint.interval95(slot)
        row = [name, number(value, 5), number(sd, 2), f"{number(low, 5)} to {number(high, 5)}", UNITS[kind][name]]
        if feet:
            factor, unit = FEET[name]
            row += [number(value * factor, 5), number(sd * factor, 2), unit]
        row += [number(c.simulated.values[slot], 5)] if simulated else []
        if truth:
            row += [number(truth.get(slot, 0.0), 5), f"{(value - truth.get(slot, 0.0)) / sd:+.1f}"]
        rows.append(tuple(row))
    title = f"Model {c.model}: maximum likelihood, {len(c.runs)} run{'s' * (len(c.runs) > 1)} together"
    name = f"model_{c.model}_parameters"
    return Table(tuple(header), tuple(rows), tuple(sentences(c)), name=name, title=title)


def sentences(c: Comparison) -> Iterator[str]:
    """Mass, noise, correlation and warnings in words."""
    estimate, noise = c.joint, c.joint.problem.noise
    if c.runs[0].input_name == "thrust_N":
        mass, sd = moving_mass(estimate)
        known = f"{mass:.1f} +- {sd:.1f} kg" if np.isfinite(mass) else "not determined, since no thrust was found"
        yield f"Moving mass 1/beta: {known}."
    heard = sorted({kind for run in c.runs for kind in run.first})
    rows = [(np.sqrt(noise.variance[kind]), channels(c.runs[0].plant)[kind]) for kind in heard]
    levels = ", ".join(f"{sd:.2g} {row.unit} on {row.words or row.name}" for sd, row in rows)
    yield f"Measurement noise: {levels}."
    if np.isfinite(noise.freedom):
        yield f"Its tails are heavy: Student's t of {noise.freedom:.2g} degrees of freedom, of that scale."
    if noise.colour_sigma > 0.0:
        yield (
            f"Beside it the range errs by {noise.colour_sigma:.2g} m for about {noise.colour_time:.2g} s at a time "
            f"(coloured noise of the sonar)."
        )
    if noise.sigma > 0.0:
        yield (
            f"Something else moves the hull: a disturbance of {noise.sigma:.2g} m/s2 that lasts about "
            f"{noise.correlation_time:.2g} s (turbulence, noise of the input, or what the model lacks)."
        )
    yield f"Correlation: {correlation(estimate)}."
    for warning in estimate.warnings:
        yield f"Warning: {plain_names(warning)}."


def correlation(estimate: Estimate) -> str:
    """Correlation of each pair of parameters."""
    names, matrix = [NAMES[slot] for slot in estimate.values], estimate.correlation
    pairs = [(i, j) for i in range(len(names)) for j in range(i + 1, len(names))]
    return ", ".join(f"{names[i]}-{names[j]} {matrix[i, j]:+.2f}" for i, j in pairs)


def plain_names(sentence: str) -> str:
    """Symbols in place of slots of the parameter vector."""
    for slot, name in NAMES.items():
        sentence = sentence.replace(slot, name)
    return sentence


def moving_mass(estimate: Estimate) -> tuple[float, float]:
    """Mass [kg] and its deviation where the input is a thrust; NaN where that moves nothing."""
    beta, sd = estimate.values["beta"], estimate.sd["beta"]
    return (1.0 / beta, sd / beta**2) if beta**2 > 0.0 else (np.nan, np.nan)


def residuals(c: Comparison) -> Table:
    """What the joint estimate leaves, run by run."""
    header = ("run", "channel", "samples", "innovation", "free run", "mean", "deviation", "mean |e|", "white, p",
              "coherence", "at rad/s")  # fmt: skip
    rows = []
    for r in c.residuals:
        free = r.free_run
        numbers = (r.innovation_rms, free.rms, free.mean, free.deviation, free.mean_absolute, r.whiteness_p)
        peak = (number(r.coherence, 2), number(r.coherence_rad_s, 3))
        rows.append((r.run, r.channel, str(r.samples), *(number(value, 3) for value in numbers), *peak))
    notes = (
        "Rms of the innovations (measured less predicted from all before) and of the free run (measured less simulated "
        "from the input alone) [m or m/s], and the free run's mean, deviation and mean absolute value.",
        "White, p: chance of such correlation in white innovations. Coherence: the highest between speed and "
        "free-run residual at a frequency that carries motion.",
    )
    title = f"Model {c.model}: residuals"
    return Table(header, tuple(rows), notes, left=2, name=f"model_{c.model}_residuals", title=title)


def validation(c: Comparison) -> Table:
    """Parameters of one run on the others; the paper shows its first row in Figures 9 to 11."""
    rows = []
    labels = [*(run.name for run in c.runs), "all, by simulation", "all, likelihood"]
    for label, row in zip(labels, c.validation, strict=True):
        rows.append((label, *(number(value, 3) for value in row)))
    if c.simulated is c.joint:
        del rows[-2]
    note = "Free-run rms [m or m/s] with the parameters from the runs named on the left; only the start is fitted."
    title = f"Model {c.model}: validation across runs"
    header = ("parameters from", *(run.name for run in c.runs))
    return Table(header, tuple(rows), (note,), name=f"model_{c.model}_validation", title=title)


def methods(c: Comparison, truth: Mapping[str, float] | None = None) -> Table:
    """Every method on every run alone, in the paper's feet where the input is a propeller speed."""
    feet = c.runs[0].input_name == "n_rev_s"
    length, kind = (FOOT_M, "ft") if feet else (1.0, "m")
    names = [NAMES[slot] for slot in c.joint.values]
    units = {name: unit for name, (_, unit) in FEET.items()} if feet else UNITS[c.runs[0].input_name]
    header = ("run", "method", *(f"{name} [{units[name]}]" for name in names))
    header += tuple(f"{what} [{kind}/s]" for what in ("mean e", "s_e", "|e|"))
    rows, notes = [], []
    if truth:
        rows.append(("", "truth", *_scaled([truth.get(slot, 0.0) for slot in c.joint.values], names, feet), "", "", ""))
    for run in c.runs:
        estimate = c.single[run.name]
        statistics = c.on_speed.get(run.name)
        cells = _scaled(list(estimate.values.values()), names, feet)
        rows.append((run.name, "likelihood", *cells, *_statistics(statistics, length)))
        for estimator, by_run in c.paper.items():
            found = by_run[run.name]
            if isinstance(found, PaperEstimate):
                cells = _scaled([by_name(found)[name] for name in names], names, feet, found.unstable)
                rows.append((run.name, ESTIMATORS[estimator], *cells, *_statistics(found.statistics, length)))
            elif found not in notes:
                notes.append(found)
    notes.append(
        f"e: speed from the sonar filter (or as measured) less free run [{kind}/s]. "
        "*: the model would be unstable, as in the paper's tables."
    )
    title = f"Model {c.model}: each run by each method"
    return Table(header, tuple(rows), tuple(notes), left=2, name=f"model_{c.model}_methods", title=title)


def by_name(found: PaperEstimate) -> dict[str, float]:
    """Parameters of the paper's estimate by symbol, SI."""
    p = found.parameters
    return {"alpha": p.alpha_per_m, "beta": p.beta_m_per_rev2, "gamma": p.gamma_per_rev, "tau": p.tau_s}


def _scaled(values: Sequence[float], names: Sequence[str], feet: bool, unstable: Sequence[str] = ()) -> list[str]:
    marks = ["*" if name in unstable or (name == "alpha" and "a" in unstable) else "" for name in names]
    factors = [FEET[name][0] if feet else 1.0 for name in names]
    return [number(value * factor) + mark for value, factor, mark in zip(values, factors, marks, strict=True)]


def _statistics(statistics: ResidualStatistics | None, length: float) -> list[str]:
    if statistics is None:
        return ["-", "-", "-"]
    return [number(v / length, 3) for v in (statistics.mean, statistics.deviation, statistics.mean_absolute)]


def linear(c: Comparison) -> Table:
    """The linear comparison model (23) of every run."""
    rows, notes = [], ["u(k+1) = a1 u(k) + a2 u(k-1) + b1 n(k) + b2 n(k-1), at the step T; e as above [m/s]."]
    for name, found in c.linear.items():
        if isinstance(found, Linear):
            m, s = found.model, found.statistics
            poles = ", ".join(f"{pole:.3f}" for pole in m.poles)
            numbers = (m.a1, m.a2, m.b1_m_per_rev, m.b2_m_per_rev)
            rows.append(
                (name, number(m.step_s, 3), *map(number, numbers), poles, number(s.mean, 3), number(s.deviation, 3))
            )
        elif found not in notes:
            notes.append(found)
    header = ("run", "T [s]", "a1", "a2", "b1", "b2", "poles", "mean e", "s_e")
    return Table(header, tuple(rows), tuple(notes), name="linear_model", title="Linear model (23)")
