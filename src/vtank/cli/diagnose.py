"""`vtank diagnose`: where recordings and simulator part, which effect causes it, and how far the gap shrinks."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..resources import NOMINAL


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `diagnose DATASET`."""
    text = "find where the gap between recordings and a simulator lies, which effect causes it, and how far it shrinks"
    parser = subparsers.add_parser("diagnose", help=text, description=text)
    parser.add_argument("dataset", type=Path, metavar="DATASET", help="folder of *.csv runs, or one run")
    parser.add_argument(
        "--nominal", metavar="FILE.toml",
        help=f"simulator to be explained: a truth preset (default {NOMINAL}), the path of one, or 'none' for a foreign "
        "vehicle, whose own refit is the simulator; of a whole vehicle its file, vehicle.toml",
    )  # fmt: skip
    parser.add_argument(
        "--axes", metavar="A,B", type=lambda text: tuple(part.strip() for part in text.split(",")),
        help="axes of a whole vehicle that are asked about, such as surge,yaw (default: all that something tells of); "
        "the others enter as known motion where they were measured",
    )  # fmt: skip
    parser.add_argument(
        "--against", type=Path, metavar="FOLDER",
        help="runs that your own simulator has flown, of any make, in the same columns: a plant is fitted to them and "
        "stands for it; of a whole vehicle --nominal gives layout and first guesses",
    )  # fmt: skip
    parser.add_argument(
        "--json", type=Path, metavar="OUT", help="write the findings as JSON (schema vtank.diagnosis/2)"
    )
    parser.add_argument("--report", type=Path, metavar="OUT.html", help="write the report, one HTML file")
    parser.add_argument("--model", type=Path, metavar="OUT.toml", help="write the diagnosed model, for vtank predict")
    parser.add_argument(
        "--law", type=int, default=0, metavar="N",
        help="accept law N of an unknown cause into the diagnosed model, 1 for the first (default: none)",
    )  # fmt: skip
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the simulated new data (default 0)")


def run(args: argparse.Namespace) -> int:
    """Diagnose, print, and write what was asked for."""
    from ..library import diagnose, load
    from .checks import at_least, check_outputs, refuse_unwritable
    from .progress import progress, taken_up_later

    at_least(0, seed=args.seed, law=args.law)
    refuse_unwritable(args.json, args.report, args.model)
    check_outputs(args, "json", "report", "model")
    runs = load(args.dataset)
    with progress() as say, taken_up_later(what="of a whole vehicle the same command"):
        found = diagnose(runs, args.nominal, args.seed, progress=say, axes=args.axes, against=args.against)
        text = str(found)
        found.write(args.json, args.model, args.report, args.law)
    print(text, end="")
    return 0
