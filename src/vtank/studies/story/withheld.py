"""What is withheld from the diagnosis: a vehicle with an effect and own parameters that its simulator lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import vtank as vt

from ...effects import Effect, Parameter
from ...plant import switched_on

OWN = 0.1  # [-] deviation of the logarithm of the vehicle's own parameters from the simulator's; a choice
SIZES, SHAPES = (2.0, 4.0), (0.7, 1.4)  # times what is typical: plainly seen, and near it; choices
INSIDE = 0.9  # of the bounds that are admissible, where a size is held; a choice


def candidates(nominal: vt.Truth) -> list[Effect]:
    """Effects that a sonar can tell apart and that the simulator does not know yet."""
    known = switched_on(nominal.vector())
    return [effect for effect in vt.effects() if effect.standing == "separable" and effect not in known]


def draw(seed: int, nominal: vt.Truth) -> tuple[Effect, vt.Truth]:
    """An effect of the candidates, each as likely, and the vehicle that has it."""
    random = np.random.default_rng(seed)
    effect = candidates(nominal)[random.integers(len(candidates(nominal)))]
    drag, thrust, lag = np.exp(OWN * random.normal(size=3)).tolist()
    values = [_value(parameter, random) for parameter in effect.parameters]
    return effect, replace(
        nominal,
        name="withheld",
        source=f"drawn from seed {seed}",
        alpha_per_m=drag * nominal.alpha_per_m,
        beta_m_per_rev2=thrust * nominal.beta_m_per_rev2,
        tau_s=lag * nominal.tau_s,
        effects=dict(zip(effect.slots(), values, strict=True)),
    )


def _value(parameter: Parameter, random: np.random.Generator) -> float:
    low, high = parameter.bounds
    times = random.uniform(*(SHAPES if parameter.shape or parameter.limit else SIZES))
    sign = random.choice([-1.0, 1.0]) if low < 0.0 < high else 1.0 if high > 0.0 else -1.0
    return float(np.clip(sign * times * parameter.scale, INSIDE * low, INSIDE * high))


def toml(effect: Effect, truth: vt.Truth) -> str:
    """The vehicle as a truth preset."""
    lines = [
        "# What the diagnosis was not told: the vehicle's own parameters, and the effect that its simulator lacks.",
        f'name = "{truth.name}"',
        f'source = "{truth.source}"',
        f"n_limit_rev_s = {truth.n_limit_rev_s}",
        "",
        "[lumped]",
        *(f"{key} = {value:.9g}" for key, value in vars(truth.lumped).items()),
        "",
        f"[effects.{effect.name}]",
        *(f"{p.key} = {v:.9g}" for p, v in zip(effect.parameters, truth.effects.values(), strict=True)),
    ]
    return "\n".join(lines) + "\n"
