"""`vtank import`: a log of a vehicle as a run, and what it will not allow to decide."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `import LOG --out RUN.csv`, and `import LOG... --out FOLDER`."""
    text = (
        "read the log of a vehicle (ArduPilot, PX4, ROS, MCAP, any table) as a run, and say what can be decided from it"
    )
    parser = subparsers.add_parser("import", help=text, description=text)
    parser.add_argument(
        "logs", type=Path, nargs="+", metavar="LOG", help="*.tlog, *.BIN, *.ulg, *.bag, *.mcap, a ROS 2 bag's "
        "folder, a table in text; several are parts of one recording, or runs of their own in a folder",
    )  # fmt: skip
    parser.add_argument(
        "--map",
        type=Path,
        metavar="MAP.toml",
        help="which fields become which columns (default: a preset, or the header)",
    )
    parser.add_argument("--vehicle", metavar="VEHICLE", help="vehicle file, for the names of its thrusters")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--out", type=Path, metavar="RUN.csv|FOLDER", help="write the run; or a run of each log")
    where.add_argument("--preview", action="store_true", help="say what would be written, and write nothing")


def run(args: argparse.Namespace) -> int:
    """Import, write, and print the preview."""
    from ..logs import import_log
    from ..record.atomic import write_files
    from ..record.files import run_name
    from ..record.writer import run_bytes
    from .checks import check_outputs, refuse_unwritable

    if args.out and not args.out.suffix:
        parts, outs = [[log] for log in args.logs], [args.out / f"{run_name(log)}.csv" for log in args.logs]
    else:
        parts, outs = [args.logs], [args.out]
    refuse_unwritable(*outs)
    check_outputs(argparse.Namespace(**vars(args) | {"out": outs}), "out")
    found = [import_log(*logs, mapping=args.map, vehicle=args.vehicle) for logs in parts]
    write_files({out: run_bytes(each.run) for each, out in zip(found, outs, strict=True) if out})
    print("\n".join(str(each) for each in found), end="")
    return 0
