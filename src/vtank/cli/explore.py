"""`vtank explore`: the run that lowers the doubt most, planned for a real tank or flown in a sealed one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .checks import check_outputs, refuse_unwritable

if TYPE_CHECKING:
    from ..plant import Vehicle
    from ..studies.explore import Candidate


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `explore --tank SEALED` and `explore RUNS --nominal FILE`."""
    text = "plan the run that lowers the doubt about a whole vehicle most; fly it in a sealed tank, till decided"
    parser = subparsers.add_parser("explore", help=text, description=text)
    parser.add_argument("runs", nargs="?", type=Path, metavar="RUNS", help="recordings so far, of a tank of your own")
    parser.add_argument("--nominal", metavar="FILE.toml", help="vehicle file, with RUNS")
    parser.add_argument(
        "--tank", type=Path, metavar="SEALED", help="truth of a case of vtank blind make --vehicles, which only the "
        "process that flies opens",
    )  # fmt: skip
    parser.add_argument("--minutes", type=float, default=30.0, metavar="N", help="of flights at most (default 30)")
    parser.add_argument("--fixed", action="store_true", help="fly all runs in their order instead, for comparison")
    parser.add_argument("--reveal", action="store_true", help="open the truth of the sealed tank at the end")
    parser.add_argument("--depth", type=float, metavar="M", help="at which runs begin (default: 50 m of what dives)")
    parser.add_argument("--walls", default="", metavar="NAME", help="basin, or path of its MJCF (default: open water)")
    parser.add_argument("--write-plan", type=Path, metavar="OUT.toml", help="write the next run, for vtank run")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write what was done as JSON")


def run(args: argparse.Namespace) -> int:
    """Plan, or fly and diagnose, and print."""
    refuse_unwritable(args.json, args.write_plan)
    check_outputs(args, "json", "write_plan")
    if (args.runs is None) == (args.tank is None):
        raise InputError("expected recordings, with --nominal, or --tank, and not both")
    if args.depth is not None and not 0.0 <= args.depth <= 1e4:
        raise InputError(f"--depth {args.depth:g}: expected a number from 0 to 1e4 m")
    if args.walls:
        from ..experiment.clearance import missing_walls

        if missing := missing_walls(args.walls):
            raise InputError(f"--walls: {missing}")
    return _plan(args) if args.tank is None else _explore(args)


def _explore(args: argparse.Namespace) -> int:
    from ..present.document import plain
    from ..record import json_text, write_text
    from ..studies.explore import Planner, SealedTank, document, explore, told
    from .progress import progress

    if not 0.0 < args.minutes <= 1440.0:
        raise InputError(f"--minutes {args.minutes:g}: expected a number above 0 and up to 1440")
    with SealedTank(args.tank) as tank, progress() as say:
        say("flights of the nominal")
        planner = Planner(tank.vehicle, _candidates(args, tank.vehicle))
        found = explore(planner, tank.fly, args.minutes, fixed=args.fixed, say=say)
        truth = tank.reveal() if args.reveal else ""
    print(plain(*told(found)), end="")
    if args.reveal:
        print(f"\nThe truth: {truth}.")
    if args.json:
        write_text(args.json, json_text(document(found) | ({"truth": truth} if truth else {})))
    if args.write_plan and found.plan:
        write_text(args.write_plan, found.plan.candidate.text)
    return 0


def _plan(args: argparse.Namespace) -> int:
    from ..diagnose.whole import diagnose
    from ..library import load
    from ..plant import load_vehicle
    from ..present.document import plain
    from ..record import write_text
    from ..studies.explore import Doubt, Planner, advice, answer_of
    from .progress import progress

    if not args.nominal:
        raise InputError("RUNS: expected the vehicle file as well, --nominal vehicle.toml")
    if args.fixed or args.reveal or args.json:
        raise InputError("--fixed, --reveal and --json go with --tank; expected none of them with RUNS")
    vehicle, runs = load_vehicle(args.nominal), load(args.runs)
    with progress() as say:
        say("diagnosing")
        diagnosis = diagnose(runs, vehicle, progress=say)
        say("what every run would tell")
        doubt = Doubt(Planner(vehicle, _candidates(args, vehicle)), None)
        chance, decided = doubt.decided(diagnosis, runs)
        plans = doubt.plans(diagnosis)
    print(f"{answer_of(diagnosis)}, {100.0 * chance:.0f} %{', decided' if decided else ''}")
    print(plain(advice(plans[0])))
    if args.write_plan:
        write_text(args.write_plan, plans[0].candidate.text)
        print(f"wrote {args.write_plan}; fly it with vtank run {args.write_plan}")
    return 0


def _candidates(args: argparse.Namespace, vehicle: Vehicle) -> list[Candidate]:
    from ..experiment.whole_scenario import DEEP_M
    from ..studies.explore import candidates

    depth_m = args.depth if args.depth is not None or vehicle.heave_N_per_m else DEEP_M
    return candidates(vehicle, depth_m, args.walls)
