"""All effects of this folder, in the fixed order of the parameter vector."""

from __future__ import annotations

from typing import get_args

from ..errors import InputError
from . import __path__ as folder
from .effect import Channel, Effect, Parameter
from .loaded import effects_in

_found: dict[str, Effect] = dict(effects_in(str(__package__), folder))  # file -> what it holds
for _file, _effect in _found.items():
    if _effect.channel not in get_args(Channel):
        raise InputError(f"{_file}: channel: expected one of {', '.join(get_args(Channel))}; found '{_effect.channel}'")
    if not _effect.does:
        raise InputError(
            f"{_file}: '{_effect.name}' does nothing: expected a law as its force, reads, instant, acts or true_input, "
            "or its term in plant/surge.py and in_equation=True"
        )
CATALOGUE: tuple[Effect, ...] = tuple(
    sorted(_found.values(), key=lambda effect: (get_args(Channel).index(effect.channel), effect.order, effect.name))
)
BY_NAME: dict[str, Effect] = {effect.name: effect for effect in CATALOGUE}

# Every entry of the parameter vector that belongs to an effect, `effect.parameter`, in its order
PARAMETERS: dict[str, Parameter] = {
    slot: parameter for effect in CATALOGUE for slot, parameter in zip(effect.slots(), effect.parameters, strict=True)
}
