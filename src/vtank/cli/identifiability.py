"""`vtank identifiability`: what a plan of experiments can tell, before the tank is booked."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `identifiability [SCENARIO...] [--design] [--out DIR]`."""
    text = "what a plan of experiments can tell, and which plan would tell more: bounds, effects, estimators, design"
    parser = subparsers.add_parser("identifiability", help=text, description=text)
    parser.add_argument(
        "scenarios", nargs="*", metavar="SCENARIO", help="names or .toml files (default: the paper's four experiments)"
    )
    parser.add_argument(
        "--nominal", metavar="FILE.toml", help="vehicle file that flies scenarios of a whole vehicle (default: theirs)"
    )
    parser.add_argument(
        "--truth", metavar="NAME", help="truth preset, or path of a .toml file (default: the scenario's)"
    )
    parser.add_argument(
        "--model", choices=("I", "II", "III"), help="to identify (default: the smallest with the truth in it)"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="override a key of all scenarios; repeatable"
    )
    parser.add_argument(
        "--seeds", type=int, default=100, metavar="N", help="of the Monte Carlo; 0 for none (default: %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of all noise (default: %(default)s)")
    parser.add_argument(
        "--processes", type=int, default=2, metavar="N", help="the results do not depend on it (default: %(default)s)"
    )
    parser.add_argument(
        "--design", action="store_true", help="search for a better plan that fits the tank in the same time"
    )
    parser.add_argument("--write-plan", type=Path, metavar="DIR", help="with --design: folder for the plan's scenarios")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder for the page (HTML, PNG), tables (CSV) and JSON"
    )
    parser.add_argument("--json", type=Path, metavar="OUT", help="write everything to a JSON file")


def run(args: argparse.Namespace) -> int:
    """Look at the plan, print verdicts and tables, write what was asked for."""
    import textwrap

    from ..present.document import plain
    from ..record import json_text, write_text
    from ..studies.design import PAPER, document, examine, write_findings, write_plan
    from .progress import progress

    _check(args)
    if _is_whole(args):
        return _run_whole(args)
    found = examine(
        args.scenarios or PAPER, args.truth, args.model, args.set,
        seeds=args.seeds, seed=args.seed, processes=args.processes, design=args.design, stage=progress,
    )  # fmt: skip
    for sentence in found.sentences():
        print(textwrap.fill(sentence, 110, initial_indent="- ", subsequent_indent="  "))
    print(plain(*found.sheets()))
    if args.json:
        write_text(args.json, json_text(document(found)))
    if args.out:
        print(f"\nwrote {', '.join(write_findings(args.out, found))} in {args.out}")
    if args.write_plan:
        print(f"\nwrote {', '.join(write_plan(args.write_plan, found))} in {args.write_plan}; fly them with")
        print(f"  vtank run {args.write_plan}/*.toml --out data")
    return 0


def _is_whole(args: argparse.Namespace) -> bool:
    """Whether scenarios of a whole vehicle are meant; InputError where others are among them, or options not theirs."""
    from ..errors import InputError
    from ..experiment.whole_scenario import is_whole

    whole = [is_whole(name) for name in args.scenarios]
    if not any(whole):
        if args.nominal is not None:
            raise InputError("--nominal goes with scenarios of a whole vehicle; expected --truth with one axis")
        return False
    if not all(whole):
        single = args.scenarios[whole.index(False)]
        raise InputError(f"{single}: an experiment of one axis; expected it apart from those of whole vehicles")
    if args.truth or args.model or args.design or args.write_plan:
        raise InputError("--truth, --model, --design and --write-plan go with experiments of one axis; expected none")
    return True


def _run_whole(args: argparse.Namespace) -> int:
    import textwrap

    from ..present.document import plain
    from ..record import json_text, write_text
    from ..studies.design import examine_whole, write_whole

    found = examine_whole(args.scenarios, args.nominal, args.set)
    for sentence in found.sentences():
        print(textwrap.fill(sentence, 110, initial_indent="- ", subsequent_indent="  "))
    print(plain(*found.sheets()))
    if args.json:
        write_text(args.json, json_text(found.document()))
    if args.out:
        print(f"\nwrote {', '.join(write_whole(args.out, found))} in {args.out}")
    return 0


def _check(args: argparse.Namespace) -> None:
    """InputError, before any work, for arguments that do not go together and folders that cannot be written."""
    from ..errors import InputError
    from ..record import refuse_loss
    from ..studies.design import PLAN, RESULTS
    from .checks import at_least, check_outputs, refuse_unwritable

    at_least(0, seeds=args.seeds, seed=args.seed)
    at_least(1, processes=args.processes)
    if args.seeds == 1:
        raise InputError("--seeds 1: expected 0, or at least 2")
    if args.write_plan and not args.design:
        raise InputError("--write-plan needs --design, which finds the plan")
    refuse_unwritable(args.json)
    check_outputs(args, "json", "out", "write_plan")
    for folder, kind in ((args.out, RESULTS), (args.write_plan, PLAN)):
        if folder:
            refuse_loss(folder, kind)
