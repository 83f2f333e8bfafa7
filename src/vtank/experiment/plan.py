"""A plan: everything that decides one run, down to the last bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..plant.parameters import NAMES, vector
from ..plant.truth import Truth, load_truth
from .clearance import check_command
from .scenario import Scenario


@dataclass(frozen=True)
class Plan:
    """One run to be simulated.

    Attributes:
        scenario: what is commanded, sensed and disturbed.
        truth: the preset that the surge parameters started from.
        p: parameter vector of the surge equation with the effects switched on, shape (SIZE,).
        seed, run: of the random streams; runs of one data set share the seed and differ in the run's number.
        name: of the run in the data set.
    """

    scenario: Scenario
    truth: Truth
    p: NDArray[np.float64]
    seed: int
    run: int
    name: str

    @property
    def n_limit_rev_s(self) -> float:
        """Largest commanded propeller speed either way [rev/s]."""
        limit = self.scenario.n_limit_rev_s
        return self.truth.n_limit_rev_s if limit is None else limit

    @property
    def thrust_m_per_rev2(self) -> float:
        """What the controller takes for beta [m/rev2]."""
        stated = self.scenario.control.thrust_m_per_rev2
        return self.truth.beta_m_per_rev2 if stated is None else stated

    @property
    def parameters(self) -> dict[str, float]:
        """The parameter vector by name."""
        return dict(zip(NAMES, self.p.tolist(), strict=True))


def plan_run(
    scenario: Scenario, run: int = 0, seed: int | None = None, truth: Truth | str | None = None, name: str = ""
) -> Plan:
    """The plan of a scenario: its truth preset (or another) with its effects, its seed (or another).

    InputError where the commanded motion would hit a wall.
    """
    check_command(scenario)
    preset = truth if isinstance(truth, Truth) else load_truth(truth or scenario.truth)
    p = vector({"standoff": scenario.standoff_m, **scenario.effects}, base=preset.vector())
    return Plan(scenario, preset, p, scenario.seed if seed is None else seed, run, name or scenario.name)
