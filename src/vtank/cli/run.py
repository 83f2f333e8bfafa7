"""`vtank run`: simulate scenarios and write what was recorded as a data set, with the truth in a file of its own."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    from ..experiment import Result


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `run SCENARIO... --out DIR`."""
    text = "simulate scenarios in the virtual tank and write the recordings as a data set"
    parser = subparsers.add_parser("run", help=text, description=text)
    parser.add_argument("scenarios", nargs="+", metavar="SCENARIO", help="name of a scenario, or path of a .toml file")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the data set to write")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of all noise (default: the first scenario's)")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads; the results do not depend on it")
    parser.add_argument(
        "--model", choices=("tank", "surge"), default="tank", help="MuJoCo tank, or the surge equation alone"
    )
    parser.add_argument("--truth", metavar="NAME", help="truth preset, or path of a .toml file, for all scenarios")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="override a key of all scenarios; repeatable"
    )


def run(args: argparse.Namespace) -> int:
    """Simulate and write."""
    from ..experiment.fly import fly, plan_all, write_results
    from ..experiment.whole_scenario import is_whole
    from ..record.dataset import refuse_strangers
    from .checks import at_least, check_outputs
    from .progress import percent

    at_least(1, threads=args.threads)
    at_least(0, seed=args.seed)
    refuse_strangers(args.out)
    check_outputs(args, "out")
    if any(map(is_whole, args.scenarios)):
        return _run_whole(args)
    plans = plan_all(args.scenarios, args.set, args.seed, args.truth)
    with percent(f"simulating {len(plans)} run{'s' * (len(plans) > 1)}") as report:
        results = fly(plans, args.model, args.threads, report)
    write_results(args.out, results, args.model, args.set)
    for result in results:
        print(_line(result))
    print(f"wrote {args.out}")
    return 0


def _run_whole(args: argparse.Namespace) -> int:
    """Fly whole vehicles and write what their instruments recorded."""
    from ..experiment.whole_scenario import fly_scenarios, summary, write_flights
    from .progress import percent

    if args.truth or args.model != "tank":
        raise InputError("--truth and --model go with experiments of one axis; expected neither for a whole vehicle")
    with percent(f"flying {len(args.scenarios)} run{'s' * (len(args.scenarios) > 1)}") as report:
        scenarios, flights = fly_scenarios(args.scenarios, args.set, args.seed, report)
    write_flights(args.out, scenarios, flights, args.set)
    for scenario, flown in zip(scenarios, flights, strict=True):
        print(summary(scenario, flown))
    print(f"wrote {args.out}")
    return 0


def _line(result: Result) -> str:
    """One line about a run."""
    position, n = result.true["position_m"], result.true["n_rev_s"]
    return (
        f"{result.plan.name}: {result.run.duration_s:g} s, truth {result.plan.truth.name}, "
        f"moved {position.min():+.2f} to {position.max():+.2f} m, |n| up to {abs(n).max():.1f} rev/s"
    )
