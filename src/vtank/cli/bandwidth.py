"""`vtank bandwidth`: what the surge controller can follow, and which waves it can hold the vehicle in."""

from __future__ import annotations

import argparse
from pathlib import Path

PARTS = ("response", "seas")
LARGEST_M = 100.0  # [m] amplitude of a command, which no tank holds; a choice


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `bandwidth [SCENARIO] [--out DIR]`."""
    text = "closed-loop response of surge position in the tank, and station keeping before a wall in waves"
    parser = subparsers.add_parser("bandwidth", help=text, description=text)
    parser.add_argument(
        "scenario",
        nargs="?",
        default="paper-ds1",
        metavar="SCENARIO",
        help="vehicle, sensors and controller (default: %(default)s); its excitation is replaced",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for tables (CSV) and figures (PNG)")
    parser.add_argument("--only", choices=PARTS, help="the response alone, or the station keeping alone")
    parser.add_argument(
        "--amplitude", type=float, action="append", metavar="M", help="amplitude of the command [m]; repeatable"
    )
    parser.add_argument(
        "--seas",
        choices=("tank", "surge"),
        default="tank",
        help="simulate seas in the MuJoCo tank (minutes) or on the surge equation alone (seconds)",
    )
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads; the results do not depend on it")
    parser.add_argument("--truth", metavar="NAME", help="truth preset, or path of a .toml file")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="override a key of the scenario; repeatable"
    )


def run(args: argparse.Namespace) -> int:
    """Simulate, print, and write where a folder is given."""
    from ..errors import InputError
    from ..experiment import load_scenario
    from ..present.document import plain
    from ..record import refuse_loss
    from ..studies.bandwidth import AMPLITUDES_M, RESULTS, frequency_response, station_keeping, write_parts
    from .checks import at_least, check_outputs
    from .progress import percent

    at_least(1, threads=args.threads)
    check_outputs(args, "out")
    if any(not 0.0 < amplitude <= LARGEST_M for amplitude in args.amplitude or ()):
        raise InputError(f"--amplitude: expected a number of metres above 0 and up to {LARGEST_M:g}")
    scenario, how = load_scenario(args.scenario, args.set), (args.threads, args.out is not None, percent)
    if args.out is not None:
        refuse_loss(args.out, RESULTS)
    parts = []
    if args.only != "seas":
        parts.append(frequency_response(scenario, args.amplitude or AMPLITUDES_M, args.truth, *how))
        print(plain(*parts[-1].tables))
    if args.only != "response":
        parts.append(station_keeping(scenario, args.truth, args.seas, *how))
        print(plain(*parts[-1].tables))
    if args.out is not None:
        print(f"\nwrote {', '.join(write_parts(args.out, scenario, args.truth, parts))} in {args.out}")
    return 0
