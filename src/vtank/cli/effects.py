"""`vtank effects`: the catalogue of effects that a simulator may leave out."""

from __future__ import annotations

import argparse
import json
import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..effects.effect import Effect, Parameter

STANDINGS = {
    "separable": "",
    "absorbed": "hides in refitted parameters: cannot be seen with one sonar",
    "tied": "tied: the same thing to one sonar",
}


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `effects [NAME...]`."""
    text = "list the effects a simulator may leave out: law, parameters, source, and what they are confused with"
    parser = subparsers.add_parser("effects", help=text, description=text)
    parser.add_argument("names", nargs="*", metavar="NAME", help="effects to show (default: all)")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print as JSON")
    form.add_argument("--markdown", action="store_true", help="print the table of the README")


def run(args: argparse.Namespace) -> int:
    """Print the effects asked for."""
    from ..effects.catalogue import BY_NAME, CATALOGUE
    from ..errors import InputError

    for name in args.names:
        if name not in BY_NAME:
            raise InputError(f"no effect '{name}'; there are: {', '.join(BY_NAME)}")
    effects = [BY_NAME[name] for name in args.names] or list(CATALOGUE)
    if args.json:
        print(json.dumps([as_data(effect) for effect in effects], indent=2, ensure_ascii=False, allow_nan=False))
    elif args.markdown:
        print(catalogue_table(effects), end="")
    else:
        print("\n\n".join(described(effect) for effect in effects))
    return 0


def catalogue_table(effects: Sequence[Effect] | None = None) -> str:
    """The README's table of effects as Markdown; default: the whole catalogue."""
    from ..effects.catalogue import CATALOGUE

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
    lines = [effect.name, *textwrap.wrap(effect.sentence, 100, initial_indent="  ", subsequent_indent="  ")]
    width = max(len(name) for name, _ in rows) + 2
    for name, text in rows:
        indent = "  " + " " * width
        lines += textwrap.wrap(text, 100, initial_indent="  " + name.ljust(width), subsequent_indent=indent)
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
    """An effect as plain data; a null value that is no number, a limit never reached, is null."""
    parameters = [
        {
            "name": q.name,
            "key": q.key,
            "unit": q.unit,
            "meaning": q.meaning,
            "null": finite(q.null),
            "bounds": [finite(bound) for bound in q.bounds],
            "per_run": q.per_run,
            "shape": q.shape,
        }
        for q in effect.parameters
    ]
    return {
        "name": effect.name,
        "channel": effect.channel,
        "sentence": effect.sentence,
        "law": effect.law,
        "parameters": parameters,
        "source": effect.source,
        "confused_with": list(effect.confused_with),
        "standing": effect.standing,
    }


def finite(value: float) -> float | None:
    """A number, or None for infinity."""
    return value if math.isfinite(value) else None
