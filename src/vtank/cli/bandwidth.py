"""`vtank bandwidth`: what the surge controller can follow, and which waves it can hold the vehicle in."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..experiment.scenario import Scenario
    from ..present.blocks import Table
    from ..studies.bandwidth.response import Response
    from ..studies.bandwidth.station import Stations

PARTS = ("response", "seas")


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
    from ..experiment.scenario import load_scenario
    from ..record.folder import refuse_loss, results_folder
    from ..studies.bandwidth import RESULTS

    if args.threads < 1:
        raise InputError(f"--threads {args.threads}: expected at least 1")
    if any(not amplitude > 0.0 for amplitude in args.amplitude or ()):
        raise InputError("--amplitude: expected a number of metres above 0")
    scenario = load_scenario(args.scenario, args.set)
    if args.out is not None:
        refuse_loss(args.out, RESULTS)
    files: dict[str, str | bytes] = {}
    tables: list[Table] = []
    if args.only != "seas":
        files |= _response(args, scenario, tables)
    if args.only != "response":
        files |= _seas(args, scenario, tables)
    if args.out is not None:
        from ..studies.bandwidth.report import page

        files["bandwidth.html"] = page(_subject(args, scenario), tables, files)
        with results_folder(args.out, RESULTS, {"scenario": scenario.name}) as folder:
            for name, content in files.items():
                (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        print(f"\nwrote {', '.join(files)} in {args.out}")
    return 0


def _response(args: argparse.Namespace, scenario: Scenario, tables: list[Table]) -> dict[str, str | bytes]:
    import numpy as np

    from ..present.document import plain
    from ..studies.bandwidth.balance import balance
    from ..studies.bandwidth.figures import response_figure
    from ..studies.bandwidth.loop import Loop
    from ..studies.bandwidth.report import response_csv, response_table
    from ..studies.bandwidth.response import AMPLITUDES_M, sine_plan, sweep
    from .progress import percent

    amplitudes = sorted(set(args.amplitude or AMPLITUDES_M))
    with percent("frequency response") as report:
        measured: Response = sweep(scenario, amplitudes, truth=args.truth, nthread=args.threads, progress=report)
    plan = sine_plan(scenario, amplitudes[0], float(measured.rad_s[0]), args.truth)
    loop = Loop(plan)
    linear = loop.response(measured.rad_s) if loop.stable() else np.full(measured.rad_s.size, complex(np.nan, np.nan))
    balanced = np.array([balance(plan, amplitude, measured.rad_s)[0] for amplitude in amplitudes])
    tables.append(response_table(measured))
    print(plain(tables[-1]))
    files: dict[str, str | bytes] = {"response.csv": response_csv(measured, linear, balanced)}
    if args.out is not None:
        files["response.png"] = response_figure(measured, linear, balanced, _subject(args, scenario))
    return files


def _seas(args: argparse.Namespace, scenario: Scenario, tables: list[Table]) -> dict[str, str | bytes]:
    from ..experiment.plan import plan_run
    from ..present.document import plain
    from ..studies.bandwidth.figures import station_figure
    from ..studies.bandwidth.report import station_csv, station_tables
    from ..studies.bandwidth.station import keep_station
    from .progress import percent

    seas: list[Stations] = []
    for kind in ("regular", "irregular"):
        with percent(f"station keeping, {kind} waves") as report:
            seas.append(
                keep_station(scenario, kind, truth=args.truth, model=args.seas, nthread=args.threads, progress=report)
            )
        tables += (new := station_tables(seas[-1]))
        print(plain(*new))
    files: dict[str, str | bytes] = {"seas.csv": station_csv(seas)}
    if args.out is not None:
        plan = plan_run(scenario, truth=args.truth)
        files["seas.png"] = station_figure(seas, plan, _subject(args, scenario))
    return files


def _subject(args: argparse.Namespace, scenario: Scenario) -> str:
    """What the figures are about."""
    return (
        f"{Path(scenario.vehicle).stem}, truth {Path(args.truth or scenario.truth).stem}, controller of {scenario.name}"
    )
