"""What could explain the gap: nothing, the nominal's own parameters, one effect, or two together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..effects.catalogue import BY_NAME, CATALOGUE
from ..effects.effect import Effect, Parameter
from ..estimate.observed import RANGE, Observed
from ..plant.parameters import slot
from ..plant.surge import LINEAR_INPUT

NUISANCE_SPREAD = 0.5  # prior deviation of the nominal's own parameters over their size; a guess, wide on purpose
FOREIGN_SPREAD = 10.0  # the same where the nominal is but the recordings' own refit: next to no prior
OFFSET = "tachometer_bias.b"  # of the input, a force where that was measured
PROPELLERS = (
    "thrust_deadband",
    "thrust_asymmetry",
    "thrust_loss",
    "thrust_saturation",
    "supply_sag",
    "tachometer_spikes",
    "tachometer_bias",
)
TOP_REV_S = 15.0  # [rev/s] largest propeller speed that bounds in rev/s are meant for, the paper's


@dataclass(frozen=True)
class Hypothesis:
    """A set of effects on top of the nominal's own, refitted parameters.

    Attributes:
        effects: the effects switched on; empty for the nominal and for the refit.
        refit: False only for the nominal as it is.
    """

    effects: tuple[Effect, ...] = ()
    refit: bool = True

    @property
    def name(self) -> str:
        """`none`, `parameters`, the effect's name, or two names joined by `+`."""
        if not self.effects:
            return "parameters" if self.refit else "none"
        return "+".join(effect.name for effect in self.effects)

    def parameters(self) -> list[tuple[str, Parameter]]:
        """Slots and parameters of its effects."""
        return [(f"{e.name}.{q.name}", q) for e in self.effects for q in e.parameters]


def nuisance(nominal: np.ndarray) -> tuple[str, ...]:
    """The nominal's own parameters, which every refit frees: drag, thrust gain, and lag and loss where it has them.

    A measured force has an offset besides (that of its transducer or amplifier).
    """
    own = ["alpha", "beta", *([OFFSET] if nominal[LINEAR_INPUT] else [])]
    own += [name for name in ("thrust_loss.gamma", "thrust_lag.tau") if nominal[slot(name)] != 0.0]
    return tuple(own)


def candidates(nominal: np.ndarray, runs: Sequence[Observed], names: Sequence[str] | None = None) -> list[Effect]:
    """Effects of the catalogue that could matter here and can be seen at all.

    Left out are effects the nominal already has, those absorbed by refitted parameters, the second of two tied
    ones, sonar effects where there is no sonar, and those of propellers where the thrust itself was measured.
    """
    found = []
    for effect in CATALOGUE if names is None else [BY_NAME[name] for name in names]:
        has = any(nominal[slot(s)] != q.null for s, q in Hypothesis((effect,)).parameters() if not q.shape)
        blind = effect.name.startswith(("sonar_", "clock_")) and not any(np.any(r.kind == RANGE) for r in runs)
        still = effect.name in ("wall_proximity",) and not any(np.any(r.kind == RANGE) for r in runs)
        placeless = effect.name == "tether" and not all(r.has_position for r in runs)
        second = effect.name == "command_delay" and any(np.any(r.kind == RANGE) for r in runs)
        pushed = runs[0].input_name == "thrust_N" and effect.name in PROPELLERS
        if not (has or effect.standing == "absorbed" or blind or still or placeless or second or pushed):
            found.append(effect)
    return found


def stretch(parameter: Parameter, runs: Sequence[Observed]) -> float:
    """Factor on numbers in rev/s where the input is something else: its largest value stands for TOP_REV_S."""
    if parameter.unit != "rev/s" or runs[0].input_name == "n_rev_s":
        return 1.0
    return max(float(np.max(np.abs(run.input))) for run in runs) / TOP_REV_S or 1.0  # no input: as they are


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
    top = max(float(np.max(np.abs(run.input))) for run in runs) or 1.0
    grids: list[dict[str, float]] = [{}]
    for parameter in effect.parameters:
        if parameter.per_run:
            values = [0.0]
        elif effect.name == "thrust_saturation":
            values = [0.9 * top, 0.7 * top, 0.5 * top]
        elif effect.name == "wake_memory" and parameter.shape:
            values = [2.0, 12.0]
        elif effect.name == "command_delay":  # a step answers to no delay but its own
            values = [0.05, 0.3, 0.8]
        elif parameter.shape:
            values = [parameter.null]
        else:
            values = [typical(parameter, runs)]
        grids = [{**grid, f"{effect.name}.{parameter.name}": value} for grid in grids for value in values]
    return grids
