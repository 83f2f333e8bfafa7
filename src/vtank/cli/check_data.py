"""`vtank check-data`: what a data set or a run holds."""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `check-data DATASET`."""
    text = "read a data set or a run by the rules for recordings and list its channels"
    parser = subparsers.add_parser("check-data", help=text, description=text)
    parser.add_argument("dataset", type=Path, metavar="DATASET", help="folder of *.csv runs, or one run")
    parser.add_argument("--vehicle", metavar="VEHICLE", help="vehicle file whose thrusters and sensors the runs are of")


def run(args: argparse.Namespace) -> int:
    """Print a line for the data set, a table of all channels, and what these do not allow to decide."""
    from ..logs import decidable
    from ..plant.recorded import check_recorded
    from ..plant.vehicle import load_vehicle
    from ..present.document import plain
    from ..present.recordings import channels
    from ..record import read_dataset

    data = read_dataset(args.dataset)
    if args.vehicle:
        vehicle = load_vehicle(args.vehicle)
        for run in data:
            check_recorded(run, vehicle)
    origin = "no manifest"
    if data.manifest:
        seed = "" if data.manifest.seed is None else f", seed {data.manifest.seed}"
        origin = f"written by vtank {data.manifest.versions.get('vtank', '?')}{seed}"
    print(f"{data.path}: {len(data)} run{'s' * (len(data) > 1)}, {origin}\n")
    print(plain(channels(data)))
    said = Counter(line for run in data for line in str(decidable(run)).splitlines())
    for line, runs in said.items():
        print(line if len(data) == 1 else f"{line} ({runs} of {len(data)} runs)")
    return 0
