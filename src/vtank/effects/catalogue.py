"""All effects of this folder, in the fixed order of the parameter vector."""

from __future__ import annotations

from typing import get_args

from ..errors import InputError
from . import __path__ as folder
from .effect import Channel, Effect, Parameter, line_of
from .loaded import effects_in


def checked(file: str, effect: Effect) -> Effect:
    """The effect of a file; InputError for one whose channel is not known, that does nothing, or whose force is off."""
    if effect.channel not in get_args(Channel):
        raise InputError(f"{file}: channel: expected one of {', '.join(get_args(Channel))}; found '{effect.channel}'")
    if not effect.does:
        raise InputError(
            f"{file}: '{effect.name}' does nothing: expected a law as its force, reads, instant, acts or true_input, "
            "or its term in plant/surge.py and in_equation=True"
        )
    try:
        effect.asked()
    except ValueError as error:
        raise InputError(f"{file}:{line_of(effect.force)}: {error}") from error
    return effect


_found = [checked(file, effect) for file, effect in effects_in(str(__package__), folder)]
CATALOGUE: tuple[Effect, ...] = tuple(
    sorted(_found, key=lambda effect: (get_args(Channel).index(effect.channel), effect.order, effect.name))
)
BY_NAME: dict[str, Effect] = {effect.name: effect for effect in CATALOGUE}

# Every entry of the parameter vector that belongs to an effect, `effect.parameter`, in its order
PARAMETERS: dict[str, Parameter] = {
    slot: parameter for effect in CATALOGUE for slot, parameter in zip(effect.slots(), effect.parameters, strict=True)
}
