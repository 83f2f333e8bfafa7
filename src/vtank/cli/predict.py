"""`vtank predict`: how well a diagnosed model predicts a run it has never seen."""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import Any


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `predict MODEL.toml RUN.csv [--json OUT]`."""
    text = "predict a run from its recorded input with the models of a diagnosis, and print the gaps left"
    parser = subparsers.add_parser("predict", help=text, description=text)
    parser.add_argument("model", type=Path, metavar="MODEL.toml", help="model written by vtank diagnose --model")
    parser.add_argument("run", type=Path, metavar="RUN.csv", help="a run the model has never seen")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the gaps as JSON; - prints it, and no table")


def run(args: argparse.Namespace) -> int:
    """Print root mean square gaps as a table, or as JSON where `--json -` asks for it."""
    from ..library import predict
    from ..present.document import plain
    from ..present.predicted import predicted
    from ..record import json_text, write_text
    from .checks import check_outputs, refuse_unwritable

    printed = args.json == Path("-")
    if not printed:
        refuse_unwritable(args.json)
        check_outputs(args, "json")
    found = predict(args.model, args.run)
    _warn(found, args.run)
    text = json_text(found)
    print(text if printed else f"{plain(predicted(found, args.run.stem))}\n", end="")
    if args.json and not printed:
        write_text(args.json, text)
    return 0


def _warn(found: dict[str, Any], run: Path) -> None:
    """Warn where simulations run away from the recording."""
    from ..diagnose.holdout import DIVERGED

    if lost := [name for name, gap in found.get("rms", {}).items() if gap >= DIVERGED]:
        why = "is it another vehicle, or are its input and measurements of different runs?"
        warnings.warn(f"{run}: runs away from it: {', '.join(lost)}; {why}", stacklevel=3)
