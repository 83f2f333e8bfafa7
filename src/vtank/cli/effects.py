"""`vtank effects`: the catalogue of effects that a simulator may leave out."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..effects import Effect


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `effects [NAME...]`."""
    text = "list the effects a simulator may leave out: law, parameters, source, and what they are confused with"
    parser = subparsers.add_parser("effects", help=text, description=text)
    parser.add_argument("names", nargs="*", metavar="NAME", help="effects to show (default: all)")
    parser.add_argument(
        "--draft", type=Path, metavar="LAW.toml",
        help="write NAME.py, the file of a new effect NAME to finish by hand, from the law in a diagnosed model",
    )  # fmt: skip
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print as JSON")
    form.add_argument("--places", action="store_true", help="print the effects at places of whole vehicles")
    form.add_argument("--markdown", action="store_true", help="print the table of scenarios/README.md")


def run(args: argparse.Namespace) -> int:
    """Print the effects asked for."""
    from ..effects.catalogue import CATALOGUE
    from ..present.catalogue import as_data, catalogue_table
    from ..record import json_text

    if args.places:
        from ..tank.places.catalogue import table

        print(table(), end="")
    elif args.draft:
        return _draft(args.names, args.draft)
    elif args.json:
        print(json_text([as_data(effect) for effect in _of_surge(args.names) or CATALOGUE]), end="")
    elif args.markdown:
        print(catalogue_table(_of_surge(args.names) or CATALOGUE), end="")
    else:
        print("\n\n".join(_described(args.names or [effect.name for effect in CATALOGUE])))
        if not args.names:
            print("\nWhole vehicles have effects of their own, at places: vtank effects --places lists them.")
    return 0


def _of_surge(names: list[str]) -> list[Effect]:
    """The effects of surge experiments by these names; InputError for any other."""
    from ..effects.catalogue import BY_NAME
    from ..errors import InputError
    from ..record import meant

    for name in names:
        if name not in BY_NAME:
            raise InputError(f"no effect '{name}' of surge{meant(name, BY_NAME)}")
    return [BY_NAME[name] for name in names]


def _described(names: list[str]) -> list[str]:
    """Each effect as text, of surge experiments or, where these have none such, at places of whole vehicles."""
    from ..effects.catalogue import BY_NAME
    from ..errors import InputError
    from ..present.catalogue import described, described_at
    from ..record import meant
    from ..tank.places.catalogue import CATALOGUE as PLACED

    placed = {effect.name: effect for effect in PLACED}
    for name in names:
        if name not in BY_NAME and name not in placed:
            raise InputError(f"no effect '{name}'{meant(name, dict.fromkeys([*BY_NAME, *placed]))}")
    return [described(BY_NAME[name]) if name in BY_NAME else described_at(placed[name]) for name in names]


def _draft(names: list[str], path: Path) -> int:
    """Write the file of an effect from the law of a model."""
    from ..diagnose.laws.words import sentence
    from ..effects.catalogue import BY_NAME
    from ..errors import InputError
    from ..plant.formula import read_formula
    from ..present.draft import draft
    from ..record import write_text
    from ..record.table import open_table

    formula = read_formula(open_table(path))
    if formula is None:
        raise InputError(f"{path}: law: missing; expected a model saved with a law that was accepted")
    if len(names) != 1 or not names[0].isidentifier() or names[0] in BY_NAME:
        raise InputError(
            f"expected one new name for the effect, such as 'slack_tether', found {' '.join(names) or 'none'}"
        )
    out = Path(f"{names[0]}.py")
    if out.exists():
        raise InputError(f"{out}: is there already; a draft replaces no file")
    write_text(out, draft(names[0], formula, sentence(formula)))
    print(f"{out}: finish it by hand (its docstring says what is left), then put it into src/vtank/effects")
    return 0
