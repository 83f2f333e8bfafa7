"""The fit of a plant to a simulator's runs: unknowns by least squares, then with forces of the flow beside them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...rigid.fit import Fit
from ...rigid.layout import Layout
from ...rigid.noise import KEPT, cut, first_noise
from ...rigid.recorded import Recorded, relaid
from .curves import Bend, bends, bent
from .flow_fit import flowing
from .model import Model, at_noise, blank, refit
from .settling import settled
from .simulator import Usual, shared, unknowns, usual

Array = NDArray[np.float64]
ENOUGH = 30_000  # measurements that a plant is fitted to; a choice, for the memory it takes
TURNS, GAINED = 6, 1.0  # of flow and noise, each at the other's, at most; log-likelihood each must gain; choices
QUIET = 0.2  # of the disturbance that is found, with which the flow is sought first; a choice


@dataclass(frozen=True, eq=False)
class Begun:
    """A plant before its flow is sought: the model, what the vehicle did, and the corrections of thrusters' curves."""

    model: Model
    did: Usual
    free: list[Bend]


def begun(layout: Layout, seen: tuple[Recorded, ...], variance: Array) -> Begun:
    """The first fit of a plant to a simulator's runs.

    variance: of each column's errors below which nothing has to be met, (C,).
    """
    layout, seen = relaid(layout, cut(seen, ENOUGH), fitted=shared(layout))
    noise = first_noise(seen)
    did, noise = usual(layout, seen, replace(noise, variance=np.maximum(noise.variance, variance)))
    free = bends(layout, seen)
    layout, seen = bent(*relaid(layout, seen, flow=did.flow), free)
    model = blank(Fit(seen, noise), layout, (), unknowns(layout, seen, did, free))
    return Begun(refit(model, model.fit.filter(model.vector()), model.theta), did, free)


def fitted(first: Begun) -> Model:
    """The plant with the flow beside it, and what it misses, for as long as turns make it likelier.

    A disturbance that stands for what the plant misses hides it: a filter follows, and innovations hardly tell of a
    force that it has found already. Turns therefore seek the flow at a part of the disturbance, and where that leads
    nowhere at all of it.
    """
    model = turned(first.model, first, 1.0)
    shares: tuple[float, ...] = (QUIET, 1.0)
    for _ in range(1, TURNS):
        trials = ((turned(model, first, share), share) for share in shares)
        other = next(((m, share) for m, share in trials if m.log_evidence > model.log_evidence + GAINED), None)
        if other is None:
            break
        model, led = other
        shares = (led, *(share for share in shares if share != led))
    return model


def turned(model: Model, first: Begun, share: float) -> Model:
    """The model after steps towards its flow at a share of its disturbance, and the noise that is left."""
    variance, alone = first.model.fit.noise.variance, model is not first.model
    if share < 1.0:
        model, _ = at_noise(model, replace(model.fit.noise, sigma=share * model.fit.noise.sigma))
    return settled(flowing(model, first.did), variance, KEPT * variance, alone=alone)[0]
