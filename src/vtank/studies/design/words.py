"""Verdicts in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...plant import LAG, LOSS, slot
from ...present import NAMES, effect_name, number
from .advice import Remedy
from .study import Study
from .verdicts import CLEAR, SEEN, Verdict

STRONG = 0.9  # |correlation| from which two parameters are said to go together; a convention
NOTED = 0.005  # relative move of a parameter that is worth a word


def called(slot: str) -> str:
    """A parameter's symbol."""
    return NAMES.get(slot, slot)


def size(v: Verdict) -> str:
    """An effect with its typical size."""
    return f"{effect_name(v.effect.name)} of {v.size:.2g}{' ' * bool(v.unit)}{v.unit}"


def moved(v: Verdict) -> str:
    """What an effect that is left out does to the model's parameters: "alpha +3 %, tau -5 %"."""
    return ", ".join(f"{called(name)} {percent(by)}" for name, by in v.moves if abs(by) >= NOTED)


def percent(share: float) -> str:
    """A signed share in per cent, of two digits or more."""
    return f"{100.0 * share:+.0f} %" if abs(share) >= 0.1 else f"{100.0 * share:+.2g} %"


def sentences(study: Study, remedies: Sequence[Remedy]) -> list[str]:
    """Parameters first, then effects that are not identifiable, those hardly seen, pairs, and what is clear."""
    return [*_parameters(study), *_not_identifiable(study), *map(_remedy, remedies), *_rest(study)]


def _parameters(study: Study) -> Iterator[str]:
    parts = [f"{called(name)} to {100.0 * sd:.2g} %" for name, sd in zip(study.free, study.relative, strict=True)]
    minutes = study.information.minutes
    runs = f"These {len(study.flown)} runs of {minutes:g} min in all" if len(study.flown) > 1 else "This run"
    yield f"{runs} can tell {', '.join(parts)} (one deviation)."
    for name in (LOSS, LAG):
        value = study.flown[0].p[slot(name)]
        if value != 0.0 and name not in study.free:
            known = f"the truth has {called(name)} = {value:.3g}, which Model {study.model} leaves out"
            yield f"Mind that {known}: the bounds take it as known, and the estimators below do not know it."
    deviation, direction = study.weakest
    ups = [f"{called(n)} {'up' if d > 0.0 else 'down'}" for n, d in zip(study.free, direction, strict=True)
           if abs(d) > 0.2]  # fmt: skip
    yield f"Least known is {' with '.join(ups)}: {100.0 * deviation:.2g} % along that direction."
    for i, j in np.argwhere(np.triu(np.abs(study.correlation), 1) > STRONG):
        pair = f"{called(study.free[i])} and {called(study.free[j])}"
        together = f"{pair} go together (correlation {study.correlation[i, j]:+.3f})"
        yield f"{together}: one makes up for an error in the other."


def _not_identifiable(study: Study) -> Iterator[str]:
    for v in study.verdicts:
        if v.standing == "absorbed":
            yield f"{size(v)} is not identifiable: refitting takes it for {moved(v) or 'another start of each run'}."


def _remedy(r: Remedy) -> str:
    if r.pair is None:
        how = "is not seen" if r.before < SEEN else "is hardly seen" if r.before < CLEAR else "is seen, as the weakest"
        left = f"{_deviations(r.before)} of {number(r.verdict.signature, 3)} deviations of the noise are left"
        by = f"once refitting has taken it for {moved(r.verdict)}" if moved(r.verdict) else "after refitting"
        return f"{size(r.verdict)} {how}: {left} {by}; {_help(r)}."
    rival = effect_name(r.pair.b.name)
    if r.before < SEEN:
        return f"{size(r.verdict)} is indistinguishable from {rival} ({r.before:.1f} deviations); {_help(r)}."
    separable = "barely separable" if r.before < CLEAR else "separable"
    return f"{size(r.verdict)} and {rival} are {separable} ({_deviations(r.before)} deviations); {_help(r)}."


def _help(r: Remedy) -> str:
    if r.after < SEEN:
        return f"no run that fits the tank separates them (at best {r.after:.1f}: {r.experiment})"
    lead = "no run with the sonar alone helps, but with" if r.sensor else "with one run more,"
    gain = f"{_deviations(r.before)} -> {_deviations(r.after)}"
    return f"{lead} {r.experiment}: {gain} (with the best of these runs repeated: {_deviations(r.repeat)})"


def _deviations(value: float) -> str:
    return f"{value:.0f}" if value >= CLEAR else f"{value:.1f}"


def _rest(study: Study) -> Iterator[str]:
    separable = [v for v in study.verdicts if v.standing == "separable"]
    clear = [v for v in separable if min(v.left, *(left for _, left in v.rivals)) >= CLEAR]
    if clear:
        names = ", ".join(effect_name(v.effect.name) for v in clear)
        yield f"Clearly seen and apart from every other at their typical size: {names}."
    yield "Sonar multipath is seen as isolated outliers, ranges that are too long, whatever the plan."
    yield (
        "Tachometer spikes are seen where the readings are smooth otherwise, or follow from the ranges that a "
        "controller answered to."
    )
