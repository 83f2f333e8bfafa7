"""A fit and the noise of its recordings, each at the other's, until both stay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...rigid.filtered import STILL, Filtered, Noise, give_back
from ...rigid.fit import Fit, begun, phased, walled
from ...rigid.noise import SURELY
from ...rigid.noise_search import MEMORIES_S, settle
from .model import Model, at_noise, refit
from .own import Unknown
from .trust import retrusted
from .unfinished import digest, step

Array = NDArray[np.float64]
STEADY = 0.1  # of a run, over which a disturbance that lasts may stand for a steady force; a choice
PATHS = ((0.0,), (1.0,), (2.0,))  # of inputs, from which they are fitted too: held, straight, along a curve
FINS = ((1.0, -1.0), (1.0, 1.0), (0.0, 0.0))  # suction and lean, from which they are fitted too
FEW = 6  # steps of a fit to another form, at most: all else is nearly right; a choice
GUST_M_S, GUST_S = 0.004, 3.0  # [m/s], [s] of gusts from which the search of moving water starts; guesses
FAR_BEHIND = 300.0  # log evidence that no further turn of a fit and its noise makes up for; a choice
SETTLING = 4  # times, at most, that all of a recording is asked for its noise; a choice


def settled(
    model: Model, floor: Array, least: Array | float = 0.0, *, alone: bool = False, rival: float = -np.inf
) -> tuple[Model, list[Filtered]]:
    """The fit and its noise, each at the other's, until the noise stays; all else as of `rigid.noise_search`.

    rival: log evidence of another; what lies far behind it after its first turn takes no other.
    """
    p = model.vector()
    model = replace(model, fit=replace(model.fit, runs=tuple(run.ordered(p) for run in model.fit.runs)))
    for n in range(1 + SETTLING):
        before = model.fit.noise
        model = _once(model, floor, least, alone=alone, near=n > 0)
        if model.log_evidence < rival - FAR_BEHIND or (n and model.fit.noise.like(before)):
            break
    give_back()
    return model, model.fit.filter(model.vector())


def _once(model: Model, floor: Array, least: Array | float, *, alone: bool, near: bool) -> Model:
    """The walls and the noise at the fit, and the fit at these; the filters of all runs go with the call."""
    give_back()
    p, fit = model.vector(), model.fit
    if any(run.wall for run in fit.runs):
        fit = walled(fit, fit.filter(p))
    fit = phased(fit, p)
    noise, found = _noise(fit, p, floor, least, near=near, alone=alone)
    return refit(replace(model, fit=replace(fit, noise=noise)), found, model.theta)


def _noise(
    fit: Fit, p: Array, floor: Array, least: Array | float = 0.0, *,
    near: bool, alone: bool = False, longest_s: float = MEMORIES_S[1],
) -> tuple[Noise, list[Filtered]]:  # fmt: skip
    """As `rigid.noise_search.settle`."""
    parts = tuple(vars(fit.noise))
    search = partial(settle, fit, p, floor, least, near=near, alone=alone, longest_s=longest_s)

    def told() -> str:
        seen = ("start", "spread", "wall", "phase_s", "value")
        runs = [part for run in fit.runs for part in
                (*(getattr(run, name) for name in seen), run.steps.which, *(run.pushed or ()))]  # fmt: skip
        now = [getattr(fit.noise, part) for part in parts]
        return digest(["noise", p, floor, np.asarray(least), near, alone, longest_s, *now, *runs])

    def plain(settled: tuple[Noise, list[Filtered]]) -> list[Any]:
        return [np.asarray(getattr(settled[0], part)).tolist() for part in parts]

    def again(filed: list[Any]) -> tuple[Noise, list[Filtered]]:
        values: list[Any] = [np.array(value) if isinstance(value, list) else value for value in filed]
        noise = Noise(**dict(zip(parts, values, strict=True)))
        return noise, replace(fit, noise=noise).filter(p)

    return step(told, search, plain, again)


def sought(fit: Fit, p: Array, floor: Array, least: Array | float) -> Noise:
    """The likeliest noise near the fit's, beside parameters that stay; else as of `rigid.noise_search.settle`."""
    return _noise(fit, p, floor, least, near=True)[0]


def rightly_begun(model: Model, found: list[Filtered], floor: Array) -> tuple[Model, list[Filtered]]:
    """The settled model, or what it settles to where some run is likelier to have begun otherwise."""
    other = begun(model.fit, model.vector())
    if all(now is then for now, then in zip(other.runs, model.fit.runs, strict=True)):
        return model, found
    return settled(replace(model, fit=other), floor, alone=True)


def reformed(model: Model, found: list[Filtered], floor: Array) -> tuple[Model, list[Filtered]]:
    """The settled model, or what it settles to from another of the forms that things may have, if that is likelier.

    Between a wing, a plate, and a force square to the hull, or of the other sign along it, or inputs that are held and
    such as turn smoothly, the slope leads astray.
    """
    at = {u.name: i for i, u in enumerate(model.unknowns)}
    paths = [((name,), PATHS) for name in at if name.startswith("path@")]
    for names, forms in [(("suction@fins", "leans@fins"), FINS), *paths]:
        if not at.keys() >= set(names):
            continue
        best = model
        for form in forms:
            theta = model.theta.copy()
            for name, value in zip(names, form, strict=True):
                theta[at[name]] = value - float(model.unknowns[at[name]].base.mean())
            there = refit(model, found, theta, steps=FEW, least=best.log_evidence)
            best = max(best, there, key=lambda fitted: fitted.log_evidence)
        if best is not model:
            model, found = settled(best, floor, alone=True)
    return model, found


def flowing(model: Model, found: list[Filtered], floor: Array) -> tuple[Model, list[Filtered]]:
    """The settled model, or what it settles to where the water that moves it is surely likelier than forces of its own.

    A gust pushes as hard as the drag has it: hardly at rest, and in all axes that its flow meets. Taken for a force as
    large at all times, slow errors of instruments seem to make up for it.
    """
    noise = model.fit.noise
    if noise.flows or noise.quiet or not all(run.moves[:3].all() for run in model.fit.runs):
        return model, found
    sigma, memory_s = noise.sigma.copy(), noise.memory_s.copy()
    sigma[:3], memory_s[:3] = GUST_M_S, GUST_S
    gusts = replace(noise.even, sigma=sigma, memory_s=memory_s, flows=True)
    try:
        wet = replace(model, fit=replace(model.fit, noise=gusts))
        other, there = settled(wet, floor, alone=True, rival=model.log_evidence)
    except InputError:
        return model, found
    moves = other.fit.noise.sigma[:3].max() > STILL
    return (other, there) if moves and other.log_evidence > model.log_evidence + SURELY else (model, found)


def forgetful(model: Model, floor: Array) -> list[tuple[Model, list[Filtered]]]:
    """Refits at noises that forget soon, and their innovations, for each part of the likeliest that is nearly steady.

    A disturbance may stand for a steady force that a model lacks, slow errors for an instrument's bias; nothing where
    neither lasts.
    """
    noise, steady_s = model.fit.noise, STEADY * max(float(np.ptp(run.time_s)) for run in model.fit.runs)
    found, steady, drifting = [], noise.memory_s > steady_s, noise.slow_s > steady_s
    if steady[noise.sigma > STILL].any():
        fit = replace(model.fit, noise=replace(noise, memory_s=np.where(steady, 0.5 * steady_s, noise.memory_s)))
        soon, there = _noise(fit, model.vector(), floor, near=True, longest_s=steady_s)
        found.append((refit(replace(model, fit=replace(fit, noise=soon)), there, model.theta), there))
    if drifting[noise.slow > 0.0].any():
        found.append(at_noise(model, replace(noise, slow=np.where(drifting, 0.0, noise.slow))))
    return found


def trusting(model: Model, found: list[Filtered], own: Sequence[Unknown]) -> tuple[Model, list[Filtered]]:
    """The model with priors of own parameters as wide as it makes likely."""
    model = retrusted(model, found, own)
    return model, model.fit.filter(model.vector())
