"""Monte Carlo: the plan simulated on many seeds, every estimator on the same recordings, against the known truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...estimate import MODELS, NORMAL95
from ...estimate.paper import Model
from ...experiment import Scenario, plan_run, simulate_surge
from ...plant import LUMPED, Truth, null_vector, slot
from ...plant import NAMES as SLOTS
from .estimators import METHODS, Answer, answers
from .flown import Array, noise_of

CENTRAL = (15.87, 84.13)  # per cent: one deviation to either side of a normal variable's median


@dataclass(frozen=True, eq=False)
class Trials:
    """Estimates on N seeds.

    Attributes:
        names: of the P parameters.
        true, bound: their values and Cramer-Rao deviations, shape (P,); NaN where no bound is known.
        found, claimed: by method, estimates and claimed deviations, shape (N, P); NaN where there was none.
    """

    names: tuple[str, ...]
    true: Array
    bound: Array
    found: dict[str, Array]
    claimed: dict[str, Array]

    @property
    def seeds(self) -> int:
        """N."""
        return next(iter(self.found.values())).shape[0]

    def bias(self, method: str) -> tuple[Array, Array]:
        """Median error over the truth's size and its own deviation, shapes (P,).

        The median, since single answers of the paper's estimators lie anywhere when C2 = T / tau comes near zero.
        """
        error = (self.found[method] - self.true) / np.abs(self.true)
        return np.nanmedian(error, axis=0), 1.2533 * self.spread(method) / np.abs(self.true) / np.sqrt(self.seeds)

    def spread(self, method: str) -> Array:
        """Half the width of the central 68 % of the estimates, a standard deviation where they are normal (P,)."""
        low, high = np.nanpercentile(self.found[method], CENTRAL, axis=0)
        return np.asarray(0.5 * (high - low))

    def spread_over_bound(self, method: str) -> Array:
        """Shape (P,); its own relative deviation is about 0.9 / sqrt(N)."""
        return self.spread(method) / self.bound

    def coverage(self, method: str) -> Array:
        """Share of the claimed 95 % intervals that hold the truth, shape (P,); an estimate that failed does not."""
        error = np.abs(self.found[method] - self.true)
        return np.asarray(np.mean(error < NORMAL95 * self.claimed[method], axis=0))


def known_effects(p: Array) -> dict[str, float]:
    """Slots of effects that are switched on, other than the model's own parameters and the stand-off."""
    own = {*LUMPED, "standoff"}
    return {name: float(p[slot(name)]) for name, null in zip(SLOTS, null_vector(), strict=True)
            if name not in own and p[slot(name)] != null}  # fmt: skip


def one_seed(scenarios: Sequence[Scenario], truth: Truth, model: Model, seed: int, number: int) -> dict[str, Answer]:
    """All estimators on the plan's recordings with random streams `number`."""
    plans = [plan_run(s, len(scenarios) * number + i, seed, truth) for i, s in enumerate(scenarios)]
    runs = [result.run for result in simulate_surge(plans)]
    noise = noise_of(scenarios[0], plans[0].p, runs[0].columns["n_rev_s"])
    return answers(runs, model, known_effects(plans[0].p), noise)


def trials(
    scenarios: Sequence[Scenario],
    truth: Truth,
    model: Model,
    bound: Array | float,
    seeds: int,
    seed: int = 1,
    over: Callable[..., Iterable[Any]] = map,
    advance: Callable[[str], None] = lambda note: None,
) -> Trials:
    """Simulate and estimate on each seed; `over` may be the map of a pool; `advance` is called after each seed."""
    p, names = plan_run(scenarios[0], 0, seed, truth).p, MODELS[model]
    found: list[dict[str, Answer]] = []
    for answer in over(partial(one_seed, scenarios, truth, model, seed), range(seeds)):
        found.append(answer)
        advance(f"seed {len(found)}")
    values, deviations = (
        {m: np.array([getattr(answer[m], name) for answer in found]) for m in METHODS} for name in ("value", "sd")
    )
    true = np.array([p[slot(name)] for name in names])
    return Trials(names, true, np.broadcast_to(bound, true.shape), values, deviations)
