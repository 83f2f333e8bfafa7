"""`vtank predict`: how well a diagnosed model predicts a run it has never seen."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `predict MODEL.toml RUN.csv [--json OUT]`."""
    text = "predict a run from its recorded input with the models of a diagnosis, and print the gaps left"
    parser = subparsers.add_parser("predict", help=text, description=text)
    parser.add_argument("model", type=Path, metavar="MODEL.toml", help="model written by vtank diagnose --model")
    parser.add_argument("run", type=Path, metavar="RUN.csv", help="a run the model has never seen")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write what is printed to a file as well")


def run(args: argparse.Namespace) -> int:
    """Print root mean square gaps as JSON."""
    import warnings

    from ..diagnose.holdout import DIVERGED
    from ..library import predict
    from ..record import json_text, write_text
    from .checks import check_outputs, refuse_unwritable

    refuse_unwritable(args.json)
    check_outputs(args, "json")
    found = predict(args.model, args.run)
    if lost := [name for name, gap in found["rms"].items() if gap >= DIVERGED]:
        why = "is it another vehicle, or are its input and measurements of different runs?"
        warnings.warn(f"{args.run}: runs away from it: {', '.join(lost)}; {why}", stacklevel=2)
    text = json_text(found)
    print(text, end="")
    if args.json:
        write_text(args.json, text)
    return 0
