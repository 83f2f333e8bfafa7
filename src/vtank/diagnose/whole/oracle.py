"""For whoever knows the truth: how far a cause stands out, the true effect fitted, and gaps on flights held back.

All at the noise that own parameters leave on the same flights without the cause, whose errors were drawn alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import InputError
from ...plant.vehicle import Vehicle
from ...record.run import Run
from ...rigid.filtered import Filtered, Noise
from ...rigid.fit import RUNAWAY, Fit
from ...rigid.layout import Layout
from ...rigid.noise import first_noise
from ...rigid.places import catalogue
from ...rigid.recordings import record
from ..given import telling
from .budget import free_errors
from .model import Model, blank, refit
from .own import own_unknowns
from .score import based, promises
from .selection import extended
from .settling import settled
from .sizes import sizes_of

TRIED = 3  # promising forms of the true effect that are fitted, such as one channel of an instrument or all; a choice


@dataclass(frozen=True)
class Known:
    """What fits find that know the truth.

    Attributes:
        d: signal-to-noise ratio of the cause after own parameters are refitted.
        d_parameters: of the change of own parameters, by the flights without the cause.
        refit, oracle: slots of own parameters alone and beside the true effect, by name; None where there is none.
        noise: that own parameters leave on the flights without the cause.
    """

    d: float
    d_parameters: float
    refit: dict[str, float]
    oracle: dict[str, float] | None
    noise: Noise


def known_fits(vehicle: Vehicle, runs: Sequence[Run], plain: Sequence[Run], is_true: Callable[[str], bool]) -> Known:
    """Fit the truth to runs. plain: the same flights without the cause. is_true: whether NAME@PLACE is the effect."""
    layout, seen, _ = record(telling(runs)[0], vehicle)
    plain_layout, still, _ = record(telling(plain)[0], vehicle)
    noise = first_noise(still)
    own = own_unknowns(plain_layout, still)
    at_rest, found = settled(blank(Fit(still, noise), plain_layout, (), own), noise.variance)
    nominal = refit(blank(at_rest.fit, plain_layout, (), ()), found, np.array([]))
    d_parameters = _deviations(nominal.cost - at_rest.cost)
    own = own_unknowns(layout, seen)
    model = blank(Fit(seen, at_rest.fit.noise), layout, (), own)
    try:
        model, found = _own(replace(model, theta=at_rest.theta))
        d = _deviations(model.cost - at_rest.cost)
        oracle = _oracle(model, found, layout, is_true, noise.variance)
    except InputError:  # the simulation diverges
        return Known(RUNAWAY, d_parameters, {}, None, at_rest.fit.noise)
    return Known(d, d_parameters, _moved(model), _moved(oracle) if oracle else None, at_rest.fit.noise)


def _deviations(cost: float) -> float:
    """Distance in deviations of what costs so much of the log-likelihood more."""
    return min(float(np.sqrt(max(2.0 * cost, 0.0))), RUNAWAY)


def _own(model: Model) -> tuple[Model, list[Filtered]]:
    """Own parameters refitted at a noise that is given, the gains made anew once."""
    for _ in range(2):
        found = model.fit.filter(model.vector())
        model = refit(model, found, model.theta)
    return model, model.fit.filter(model.vector())


def _oracle(
    model: Model, found: list[Filtered], layout: Layout, is_true: Callable[[str], bool], floor: np.ndarray
) -> Model | None:
    """The true effect at its place beside own parameters; None where the catalogue of recordings has none such."""
    known = catalogue(layout, model.fit.runs[0].moves, sizes_of(model, found))
    true = [placed for placed in known if is_true(placed.name)]
    base = based(model, found)
    fitted = [extended(model, base.J, found, layout, promise.placed, promise.begin)
              for promise in promises(model, base, layout, true)[:TRIED]]  # fmt: skip
    return settled(max(fitted, key=lambda m: m.log_evidence), floor)[0] if fitted else None


def _moved(model: Model) -> dict[str, float]:
    """Slots that differ from the vehicle file's, by name."""
    layout, p = model.fit.runs[0].layout, model.vector()
    return {layout.names[i]: float(p[i]) for i in np.flatnonzero(p != layout.null)}


def free_gap(vehicle: Vehicle, runs: Sequence[Run], noise: Noise, slots: Mapping[str, float]) -> float:
    """Root mean square over columns of the error of free simulation, in deviations of their noise, which is taken off.

    noise: of the filter, by which stretches begin. slots: that differ from the vehicle file's, by name; one of an
    instrument that these runs have not is passed over. RUNAWAY where the simulation diverges.
    """
    layout, seen, _ = record(runs, vehicle)
    own = replace(first_noise(seen), sigma=noise.sigma, memory_s=noise.memory_s)
    p = layout.vector({name: value for name, value in slots.items() if name in layout.slots})
    try:
        squares, counts = free_errors(Model(Fit(seen, own), (), (), np.array([]), p))
    except InputError:
        return RUNAWAY
    measured = counts.sum(axis=0) > 0
    mean = (squares.sum(axis=0) / np.maximum(counts.sum(axis=0), 1) / own.variance)[measured]
    return min(float(np.sqrt(max(float(np.mean(mean)) - 1.0, 0.0))), RUNAWAY)
