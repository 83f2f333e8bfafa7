"""All effects of this folder, in the fixed order of the parameter vector."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import get_args

from . import __path__ as folder
from .effect import Channel, Effect, Parameter

_modules = (import_module(f"{__package__}.{module.name}") for module in iter_modules(folder))
CATALOGUE: tuple[Effect, ...] = tuple(
    sorted(
        (module.EFFECT for module in _modules if hasattr(module, "EFFECT")),
        key=lambda effect: (get_args(Channel).index(effect.channel), effect.order, effect.name),
    )
)
for _effect in CATALOGUE:
    if not _effect.does:
        raise ValueError(
            f"effect '{_effect.name}' does nothing: expected a law as its force, reads, instant, acts or true_input, "
            "or its term in plant/surge.py and in_equation=True"
        )
BY_NAME: dict[str, Effect] = {effect.name: effect for effect in CATALOGUE}

# Every entry of the parameter vector that belongs to an effect, `effect.parameter`, in its order
PARAMETERS: dict[str, Parameter] = {
    slot: parameter for effect in CATALOGUE for slot, parameter in zip(effect.slots(), effect.parameters, strict=True)
}
