"""What could explain the gap: nothing, the nominal's own parameters, one effect, or two together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ..effects.catalogue import BY_NAME, CATALOGUE, PARAMETERS
from ..effects.effect import Effect, Need, Parameter
from ..estimate.observed import RANGE, Observed
from ..plant.parameters import LAG, LINEAR_DRAG, LOSS, slot, switched_on
from ..plant.surge import LINEAR_INPUT

TOP_REV_S = 15.0  # [rev/s] largest propeller speed that bounds in rev/s are meant for, the paper's


@dataclass(frozen=True)
class Hypothesis:
    """A set of effects on top of the nominal's own, refitted parameters.

    Attributes:
        effects: the effects switched on; empty for the nominal and for the refit.
        refit: False only for the nominal as it is.
        varying: own parameters that every run has for itself, by slot, with their mean and spread over the runs.
    """

    effects: tuple[Effect, ...] = ()
    refit: bool = True
    varying: tuple[tuple[str, float, float], ...] = ()

    @property
    def name(self) -> str:
        """`none`, `parameters`, `varying`, the effect's name, or several names joined by `+`."""
        if self.varying:
            return "varying"
        if not self.effects:
            return "parameters" if self.refit else "none"
        return "+".join(effect.name for effect in self.effects)

    def parameters(self) -> list[tuple[str, Parameter]]:
        """Slots and parameters of its effects."""
        return [(name, PARAMETERS[name]) for effect in self.effects for name in effect.slots()]

    @property
    def outliers(self) -> set[str]:
        """Sensors whose readings its effects make outliers of, which no smooth effect imitates."""
        return {effect.place for effect in self.effects if effect.outliers}


def about_their_mean(by_run: Mapping[str, np.ndarray]) -> tuple[tuple[str, float, float], ...]:
    """Own parameters that vary, as `Hypothesis` has them; by_run: their values in every run, by slot, shape (R,)."""
    return tuple((name, float(np.mean(values)), float(np.std(values))) for name, values in by_run.items())


def nuisance(nominal: np.ndarray) -> tuple[str, ...]:
    """The nominal's own parameters, which every refit frees: drag, gain; linear drag, loss, lag where it has them.

    A measured force has an offset besides (that of its transducer or amplifier). Where it is not known whether thrust
    goes with the input or with its square, which a linear share between 0 and 1 says, that share is free as well.
    """
    share = nominal[LINEAR_INPUT]
    own = ["alpha", "beta", *(["force_offset"] if share == 1.0 else ["linear_input"] if share > 0.0 else [])]
    own += [name for name in (LINEAR_DRAG, LOSS, LAG) if nominal[slot(name)] != 0.0]
    return tuple(own)


def candidates(nominal: np.ndarray, runs: Sequence[Observed], names: Sequence[str] | None = None) -> list[Effect]:
    """Effects of the catalogue that could matter here and can be seen at all.

    Left out are effects that are among the nominal's own parameters, those absorbed by these, the second of two that
    are the same, and those that need something that was not recorded. What else the nominal has may be of another size.
    """
    there: dict[Need, bool] = {
        "sonar": any(np.any(run.kind == RANGE) for run in runs),
        "position": all(run.has_position for run in runs),
        "propeller": runs[0].input_name != "thrust_N",
    }
    seen = {e.name for e in CATALOGUE if e.standing != "absorbed" and all(there[need] for need in e.needs)}
    able = seen - {effect.name for effect in switched_on(nominal) if {*nuisance(nominal)} & {*effect.slots()}}
    chosen = CATALOGUE if names is None else [BY_NAME[name] for name in names]
    return [effect for effect in chosen if effect.name in able and effect.same_as not in seen]


def largest_input(runs: Sequence[Observed]) -> float:
    """Of all runs [unit of the input]."""
    return max(float(np.max(np.abs(run.input))) for run in runs)


def stretch(parameter: Parameter, runs: Sequence[Observed]) -> float:
    """Factor on numbers in rev/s where the input is something else: its largest value stands for TOP_REV_S."""
    if parameter.unit != "rev/s" or runs[0].input_name == "n_rev_s":
        return 1.0
    return largest_input(runs) / TOP_REV_S or 1.0  # no input: as they are


def typical(parameter: Parameter, runs: Sequence[Observed]) -> float:
    """A moderate value of a parameter that says how large its effect is: some share of the catalogue's scale."""
    scale = parameter.scale
    if parameter.unit == "rev/s":
        scale *= (float(np.sqrt(np.mean(np.concatenate([run.input for run in runs]) ** 2))) or 1.0) / 8.0
    if parameter.bounds[0] < 0.0 < parameter.bounds[1]:
        return 0.3 * scale
    return -0.5 * scale if parameter.bounds[1] <= 0.0 else 0.5 * scale


def starting_values(effect: Effect, runs: Sequence[Observed]) -> list[dict[str, float]]:
    """First guesses of an effect's parameters, away from the null, where many have no gradient."""
    values = [_starts(parameter, runs) for parameter in effect.parameters]
    return [dict(zip(effect.slots(), grid, strict=True)) for grid in product(*values)]


def _starts(parameter: Parameter, runs: Sequence[Observed]) -> tuple[float, ...]:
    if parameter.limit:
        return tuple(share * (largest_input(runs) or 1.0) for share in parameter.starts)
    return parameter.starts or ((parameter.null if parameter.shape else typical(parameter, runs)),)
