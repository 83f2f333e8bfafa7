"""The catalogue of effects as text, as a table in Markdown and as plain data."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..effects.catalogue import CATALOGUE
from ..effects.effect import Effect, Parameter
from ..plant.vehicle import AXES

if TYPE_CHECKING:
    from ..tank.places.effect import Number, PlacedEffect

ANY = 1e6  # a bound of an effect at a place that holds nothing back
KIND_TEXT = {"axis": f"an axis: {', '.join(AXES)}", "vehicle": "vehicle"}
TEXTS = {"channel": "the one that is meant; all where it is not given", "other": "the thruster that is exchanged with"}

STANDINGS = {
    "separable": "",
    "absorbed": "hides in refitted parameters: cannot be seen with one sonar",
    "tied": "tied: the same thing to one sonar",
}


def catalogue_table(effects: Sequence[Effect] | None = None) -> str:
    """A table of effects as Markdown, as in scenarios/README.md; default: the whole catalogue."""
    lines = ["| effect | channel | law | parameters | confused with |", "|---|---|---|---|---|"]
    for effect in CATALOGUE if effects is None else effects:
        parameters = ", ".join(f"`{q.key}`" for q in effect.parameters)
        rivals = ", ".join(f"`{name}`" for name in effect.confused_with)
        if effect.standing != "separable":
            rivals = f"{effect.standing}{': ' if rivals else ''}{rivals}"
        law = effect.law.replace("|", "\\|")
        lines.append(f"| `{effect.name}` | {effect.channel} | {law} | {parameters} | {rivals} |")
    return "\n".join(lines) + "\n"


def described(effect: Effect) -> str:
    """An effect as a paragraph of lines."""
    rows = [("channel", effect.channel), ("law", effect.law)]
    rows += [(q.key, parameter_text(q)) for q in effect.parameters]
    rows.append(("source", effect.source))
    if effect.confused_with:
        rows.append(("confused with", ", ".join(effect.confused_with)))
    if STANDINGS[effect.standing]:
        rows.append(("standing", STANDINGS[effect.standing]))
    return _paragraph(effect.name, effect.sentence, rows)


def described_at(effect: PlacedEffect) -> str:
    """An effect at places of a whole vehicle as a paragraph of lines."""
    axes = effect.kind == "axis" and len(effect.places) < len(AXES)
    where = " ".join(effect.places) if axes else KIND_TEXT.get(effect.kind, f"a {effect.kind}, by its name")
    rows = [("place", where), ("law", effect.law)]
    rows += [_told(number) for number in effect.numbers]
    if effect.text:
        rows.append((effect.text, TEXTS[effect.text]))
    rows.append(("in a scenario", f'effects."{effect.name}@PLACE"'))
    return _paragraph(effect.name, "", rows)


def _told(number: Number) -> tuple[str, str]:
    """The key of a number, and what is said of it; of several keys, by the unit of the place, the name alone."""
    low, high = (f"{end:g}" if abs(end) < ANY else "any" for end in (number.low, number.high))
    span = "" if low == high == "any" else f", {low} to {high}"
    text = f"{number.meaning}{span}{'' if number.default is None else f', {number.default:g} where it is not given'}"
    keys = [number.name + ending for ending in number.endings]
    return (keys[0], text) if len(keys) == 1 else (number.name, f"{text}; by its unit {' or '.join(keys)}")


def _paragraph(name: str, sentence: str, rows: Sequence[tuple[str, str]]) -> str:
    """A name, a sentence, and beneath it terms with what is said of each."""
    lines = [name, *textwrap.wrap(sentence, 100, initial_indent="  ", subsequent_indent="  ")]
    width = max(len(term) for term, _ in rows) + 2
    for term, text in rows:
        indent = "  " + " " * width
        lines += textwrap.wrap(text, 100, initial_indent="  " + term.ljust(width), subsequent_indent=indent)
    return "\n".join(lines)


def parameter_text(parameter: Parameter) -> str:
    """Meaning, unit, bounds and null value of a parameter."""
    low, high = parameter.bounds
    span = f"{low:g} to {high:g}" if math.isfinite(high) else f"at least {low:g}"
    text = f"{parameter.meaning} [{parameter.unit}], {span}"
    if parameter.shape:
        return f"{text}{', one for each run' if parameter.per_run else ''}"
    null = f"at {parameter.null:g}" if math.isfinite(parameter.null) else "where it is never reached"
    return f"{text}, no effect {null}"


def as_data(effect: Effect) -> dict[str, Any]:
    """An effect as plain data; in JSON an infinite bound, or a null value that is never reached, is null."""
    parameters = [_fields(q, "name key unit meaning null bounds per_run shape") for q in effect.parameters]
    told = _fields(effect, "name channel sentence law parameters source confused_with standing")
    return told | {"parameters": parameters}


def _fields(of: Effect | Parameter, names: str) -> dict[str, Any]:
    return {name: getattr(of, name) for name in names.split()}
