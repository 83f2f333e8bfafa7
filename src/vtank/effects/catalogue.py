"""All effects of this folder, in the fixed order of the parameter vector."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from typing import get_args

from . import __path__ as folder
from .effect import Channel, Effect, Parameter


def _found() -> Iterator[Effect]:
    for module in iter_modules(folder):
        effect = getattr(import_module(f"{__package__}.{module.name}"), "EFFECT", None)
        if effect is not None:
            yield effect


CATALOGUE: tuple[Effect, ...] = tuple(
    sorted(_found(), key=lambda effect: (get_args(Channel).index(effect.channel), effect.order, effect.name))
)
BY_NAME: dict[str, Effect] = {effect.name: effect for effect in CATALOGUE}

# Every entry of the parameter vector that belongs to an effect, `effect.parameter`, in its order
PARAMETERS: dict[str, Parameter] = {
    slot: parameter for effect in CATALOGUE for slot, parameter in zip(effect.slots(), effect.parameters, strict=True)
}
