"""All that a plan of experiments says about itself before it is carried out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np

from ...errors import InputError
from ...estimate import MODELS
from ...estimate.paper import Model
from ...experiment import Scenario
from ...plant import Truth, slot
from .flown import Array, Flown, check, fly
from .information import Information, information
from .sensitivity import Quantity, quantities, sensitivity
from .verdicts import Verdict, verdicts

PAPER = ("paper-ds1", "paper-ds2", "paper-ds3", "paper-ds4")


@dataclass(frozen=True, eq=False)
class Study:
    """A plan, flown once, and its information.

    Attributes:
        model: whose parameters are identified.
        seed: of all noise.
        flown: the experiments.
        quantities: parameters and effects that are looked at.
        single: information of each run.
        information: of all runs together.
        verdicts: on every effect of the catalogue.
    """

    model: Model
    seed: int
    flown: tuple[Flown, ...]
    quantities: tuple[Quantity, ...]
    single: tuple[Information, ...]
    information: Information
    verdicts: tuple[Verdict, ...]

    @property
    def free(self) -> tuple[str, ...]:
        """Parameters of the model."""
        return MODELS[self.model]

    @property
    def truth(self) -> Truth:
        """The preset behind the plan."""
        return self.flown[0].truth

    @property
    def true(self) -> Array:
        """True values of the model's parameters, shape (P,)."""
        return self.flown[0].p[[slot(name) for name in self.free]]

    @property
    def covariance(self) -> Array:
        """Cramer-Rao bound over the squared sizes of the parameters, shape (P, P)."""
        return self.information.covariance(self.free)

    @property
    def relative(self) -> Array:
        """Cramer-Rao deviations over the parameters' sizes, shape (P,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def bound(self) -> Array:
        """Cramer-Rao deviations in the parameters' own units, shape (P,)."""
        return self.relative * self.information.sizes(self.free)

    @property
    def correlation(self) -> Array:
        """Shape (P, P)."""
        return self.covariance / np.outer(self.relative, self.relative)

    @property
    def condition(self) -> float:
        """Of the information scaled to unit diagonal: 1 where the parameters do not disturb one another."""
        at = self.information.index(self.free)
        matrix = self.information.matrix[np.ix_(at, at)]
        scale = np.sqrt(np.diag(matrix))
        return float(np.linalg.cond(matrix / np.outer(scale, scale)))

    @property
    def weakest(self) -> tuple[float, Array]:
        """Deviation along the least known direction of relative change, and the direction, shape (P,)."""
        values, vectors = np.linalg.eigh(self.covariance)
        return float(np.sqrt(values[-1])), vectors[:, -1] * np.sign(vectors[np.argmax(np.abs(vectors[:, -1])), -1])

    def of(self, flown: Flown) -> Information:
        """Information of another experiment about the same quantities."""
        return information(self.quantities, sensitivity(flown, self.quantities), flown.minutes)


def natural_model(truth: Truth) -> Model:
    """The smallest of Models I, II and III that holds the truth."""
    if truth.gamma_per_rev != 0.0:
        return "III"
    return "II" if truth.tau_s > 0.0 else "I"


def study(scenarios: Sequence[Scenario], truth: Truth, model: Model, seed: int = 1) -> Study:
    """Fly the plan once on the surge model and weigh it.

    InputError where a run is none of surge, still water and a noisy sonar, or the truth lacks what the model has or is
    so far off that the runs tell nothing of it.
    """
    for scenario in scenarios:
        check(scenario)
    missing = [name for name in MODELS[model] if truth.vector()[slot(name)] == 0.0]
    if missing:
        raise InputError(
            f"model {model} has {' and '.join(missing)}, which the truth {truth.name} has not: nothing to bound; "
            f"expected --model {natural_model(truth)}, or another --truth"
        )
    flown = tuple(fly(scenarios, truth, seed))
    top = max(f.top_rev_s for f in flown)
    wanted = quantities(flown[0].p, top, MODELS[model])
    single = [information(wanted, sensitivity(f, wanted), f.minutes) for f in flown]
    total = reduce(add, single)
    told = np.diag(total.matrix)[total.index(MODELS[model])]
    if untold := [name for name, size in zip(MODELS[model], told, strict=True) if not 0.0 < size < np.inf]:
        raise InputError(
            f"at the truth {truth.name} the plan tells nothing of {' and '.join(untold)}, which do not change what is "
            "recorded: nothing to bound; expected another --truth, or another plan"
        )
    found = tuple(verdicts(total, flown, MODELS[model]))
    return Study(model, seed, flown, wanted, tuple(single), total, found)
