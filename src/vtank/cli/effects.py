"""`vtank effects`: the catalogue of effects that a simulator may leave out."""

from __future__ import annotations

import argparse


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
    from ..present.catalogue import as_data, catalogue_table, described
    from ..record import json_text

    for name in args.names:
        if name not in BY_NAME:
            raise InputError(f"no effect '{name}'; there are: {', '.join(BY_NAME)}")
    effects = [BY_NAME[name] for name in args.names] or list(CATALOGUE)
    if args.json:
        print(json_text([as_data(effect) for effect in effects]), end="")
    elif args.markdown:
        print(catalogue_table(effects), end="")
    else:
        print("\n\n".join(described(effect) for effect in effects))
    return 0
