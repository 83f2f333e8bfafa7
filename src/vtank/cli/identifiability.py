"""`vtank identifiability`: what a plan of experiments can tell, before the tank is booked."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..estimate.paper.regression import Model
    from ..experiment.scenario import Scenario
    from ..plant.truth import Truth
    from ..studies.design.findings import Findings


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `identifiability [SCENARIO...] [--design] [--out DIR]`."""
    text = "what a plan of experiments can tell, and which plan would tell more: bounds, effects, estimators, design"
    parser = subparsers.add_parser("identifiability", help=text, description=text)
    parser.add_argument(
        "scenarios", nargs="*", metavar="SCENARIO", help="names or .toml files (default: the paper's four experiments)"
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
    from ..errors import InputError
    from ..record.folder import refuse_loss
    from ..studies.design import PLAN, RESULTS
    from .diagnose import refuse_unwritable

    if args.seeds < 0 or args.seeds == 1 or args.processes < 1 or args.seed < 0:
        raise InputError("--seeds takes 0 or at least 2, --processes at least 1, --seed at least 0")
    if args.write_plan and not args.design:
        raise InputError("--write-plan needs --design, which finds the plan")
    refuse_unwritable(args.json)
    for folder, kind in ((args.out, RESULTS), (args.write_plan, PLAN)):
        if folder:
            refuse_loss(folder, kind)
    scenarios, truth, model = _chosen(args)
    found = _found(args, scenarios, truth, model)
    _print(found)
    _write(args, found)
    return 0


def _chosen(args: argparse.Namespace) -> tuple[list[Scenario], Truth, Model]:
    """Scenarios with names of their own, the truth of all, and the model."""
    from ..errors import InputError
    from ..experiment.scenario import load_scenario
    from ..plant.truth import load_truth
    from ..studies.design.study import PAPER, natural_model

    scenarios = [load_scenario(name, args.set) for name in args.scenarios or PAPER]
    truths = sorted({scenario.truth for scenario in scenarios})
    if args.truth is None and len(truths) > 1:
        raise InputError(f"the scenarios have different truths ({', '.join(truths)}): choose one with --truth")
    truth = load_truth(args.truth or truths[0])
    return scenarios, truth, args.model or natural_model(truth)


def _found(args: argparse.Namespace, scenarios: list[Scenario], truth: Truth, model: Model) -> Findings:
    """Bounds and advice always, the rest as asked for."""
    from ..studies.design.advice import library, options, remedies
    from ..studies.design.findings import Findings
    from ..studies.design.profile import profiles
    from ..studies.design.study import study
    from .progress import progress

    looked = study(scenarios, truth, model, args.seed)
    some = library(looked)
    with progress("runs that could be added", len(some)) as advance:
        advice = remedies(looked, options(looked, some, advance))
    found = Findings(looked, tuple(advice), tuple(profiles(looked)))
    if args.seeds:
        found = _tried(args, found, scenarios)
    return _designed(args, found) if args.design else found


def _tried(args: argparse.Namespace, found: Findings, scenarios: list[Scenario]) -> Findings:
    """With the Monte Carlo of the plan, and single runs over frequency and noise."""
    from dataclasses import replace

    from ..studies.design.bias import bias_map, cells, seeds_of_cell
    from ..studies.design.trials import trials
    from .progress import progress

    looked, rest = found.study, (args.seed, args.processes)
    with progress("Monte Carlo", args.seeds) as advance:
        tried = trials(scenarios, looked.truth, looked.model, looked.bound, args.seeds, *rest, advance)
    some = cells(scenarios[0], looked.truth)
    with progress("bias over frequency and noise", len(some)) as advance:
        bias = bias_map(some, looked.truth, looked.model, seeds_of_cell(args.seeds), *rest, advance)
    return replace(found, trials=tried, bias=bias)


def _designed(args: argparse.Namespace, found: Findings) -> Findings:
    """With a better plan, and its Monte Carlo."""
    from dataclasses import replace

    from ..studies.design.design import confirmed, longest, pool
    from ..studies.design.trials import trials
    from .progress import progress

    looked = found.study
    some = longest(looked)
    with progress("runs to choose from", len(some)) as advance:
        items = pool(looked, some, advance)
    plan = confirmed(looked, items, args.processes)
    if not args.seeds:
        return replace(found, design=plan)
    scenarios = [item.flown.scenario for item in plan.items]
    bound = plan.relative(plan.items) * looked.information.sizes(looked.free)
    with progress("Monte Carlo of the design", args.seeds) as advance:
        rest = (args.seed, args.processes, advance)
        checked = trials(scenarios, looked.truth, looked.model, bound, args.seeds, *rest)
    return replace(found, design=plan, checked=checked)


def _print(found: Findings) -> None:
    """Verdicts first, then tables."""
    import textwrap

    from ..present.document import plain

    for sentence in found.sentences():
        print(textwrap.fill(sentence, 110, initial_indent="- ", subsequent_indent="  "))
    print(plain(*found.sheets()))


def _write(args: argparse.Namespace, found: Findings) -> None:
    import json

    from ..present.document import csv_text
    from ..record.atomic import write_text
    from ..record.folder import results_folder
    from ..studies.design import RESULTS
    from ..studies.design.document import document
    from ..studies.design.figures import page

    content = json.dumps(document(found), indent=2, allow_nan=False) + "\n"
    if args.json:
        write_text(args.json, content)
    if args.out:
        png = page(found.study, found.trials, found.bias, list(found.profiles))
        files = {f"{sheet.name}.csv": csv_text(sheet.header, sheet.rows).encode() for sheet in found.sheets()}
        files |= {
            "identifiability.png": png,
            "identifiability.html": found.page(png).encode(),
        }
        with results_folder(args.out, RESULTS, json.loads(content)) as folder:
            for name, data in files.items():
                (folder / name).write_bytes(data)
        print(f"\nwrote {', '.join(files)}, {RESULTS.marker} in {args.out}")
    if args.write_plan:
        _write_plan(args.write_plan, found)


def _write_plan(folder: Path, found: Findings) -> None:
    """The designed runs as scenario files, and the command that flies them."""
    from ..record.folder import results_folder
    from ..studies.design import PLAN
    from ..studies.design.design import scenario_texts

    assert found.design is not None
    texts = scenario_texts(found.design)
    with results_folder(folder, PLAN) as new:
        for name, text in texts.items():
            (new / name).write_text(text, encoding="utf-8")
    print(f"\nwrote {', '.join(texts)} in {folder}; fly them with")
    print(f"  vtank run {folder}/*.toml --out data")
