"""`vtank run`: simulate scenarios and write what was recorded as a data set, with the truth in a file of its own."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..experiment import Result
    from ..experiment.plan import Plan


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
    from ..errors import InputError
    from ..experiment.written import provenance
    from ..record import write_dataset
    from ..record.dataset import refuse_strangers

    if args.threads < 1:
        raise InputError(f"--threads {args.threads}: expected at least 1")
    if args.seed is not None and args.seed < 0:
        raise InputError(f"--seed {args.seed}: expected a whole number of at least 0")
    refuse_strangers(args.out)
    plans = plan_all(args.scenarios, args.set, args.seed, args.truth)
    results = simulate(plans, args.model, args.threads)
    for result in results:
        result.check_clearance()
    documents = provenance(results, args.model, args.set)
    write_dataset(args.out, [result.run for result in results], *documents)
    for result in results:
        print(_line(result))
    print(f"wrote {args.out}")
    return 0


def plan_all(
    scenarios: Sequence[str], settings: Sequence[str] = (), seed: int | None = None, truth: str | None = None
) -> list[Plan]:
    """One plan for each scenario, in order, all with one seed; a scenario given twice makes two different runs."""
    from ..experiment.plan import plan_run
    from ..experiment.scenario import load_scenario

    loaded = [load_scenario(name, settings) for name in scenarios]
    seed = loaded[0].seed if seed is None else seed
    names = _names([scenario.name for scenario in loaded])
    pairs = zip(loaded, names, strict=True)
    return [plan_run(scenario, i, seed, truth, name) for i, (scenario, name) in enumerate(pairs)]


def simulate(plans: Sequence[Plan], model: str, threads: int) -> list[Result]:
    """Results on "tank" or "surge", with progress shown."""
    from ..experiment import simulate_surge, simulate_tank
    from .progress import percent

    with percent(f"simulating {len(plans)} run{'s' * (len(plans) > 1)}") as report:
        simulator = simulate_tank if model == "tank" else simulate_surge
        return simulator(plans, threads, report)


def _names(names: list[str]) -> list[str]:
    """The names, numbered where one appears more than once."""
    counts = {name: 0 for name in names}
    unique = []
    for name in names:
        counts[name] += 1
        unique.append(f"{name}-{counts[name]}" if names.count(name) > 1 else name)
    return unique


def _line(result: Result) -> str:
    """One line about a run."""
    position, n = result.true["position_m"], result.true["n_rev_s"]
    return (
        f"{result.plan.name}: {result.run.duration_s:g} s, truth {result.plan.truth.name}, "
        f"moved {position.min():+.2f} to {position.max():+.2f} m, |n| up to {abs(n).max():.1f} rev/s"
    )
