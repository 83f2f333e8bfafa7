"""`vtank identify`: the surge models that a data set asks for, by likelihood and by the paper's methods.

With --monte-carlo N no data set is read: the paper's experiments are simulated N times and the likelihood is put to the
test: `vtank identify --monte-carlo 400 --model II --truth paper-ii --set tachometer.noise_rev_s=0`.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..estimate.comparison import Comparison
    from ..estimate.paper.regression import Model
    from ..present.blocks import Table
    from ..record import Run

MODELS: tuple[Model, ...] = ("I", "II", "III")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `identify DATASET [--model M] [--truth T] [--method M] [--json OUT] [--out DIR]`."""
    text = "identify the paper's surge models from a data set, simulated or real"
    parser = subparsers.add_parser("identify", help=text, description=text)
    parser.add_argument("dataset", type=Path, nargs="?", metavar="DATASET", help="folder of *.csv runs, or one run")
    parser.add_argument(
        "--model", choices=(*MODELS, "all"), default="all", help="I: drag and thrust; II: and lag; III: and thrust loss"
    )
    parser.add_argument(
        "--method", choices=("ml", "paper", "all"), default="all", help="maximum likelihood, the paper's estimators"
    )
    parser.add_argument(
        "--process-noise",
        choices=("auto", "on", "off"),
        default="auto",
        help="whether the likelihood knows of turbulence (default: where the residuals ask for it)",
    )
    parser.add_argument("--truth", metavar="TRUTH", help="truth preset, or a truth.json, to set beside the estimates")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write everything to a JSON file")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for tables (Markdown, CSV) and pictures")
    trials = parser.add_argument_group("in place of a data set: bias, coverage and variance on simulated experiments")
    trials.add_argument("--monte-carlo", type=int, metavar="N", help="simulate the paper's experiments on N seeds")
    trials.add_argument("--simulator", choices=("surge", "tank"), default="surge", help="default: the surge model")
    trials.add_argument("--seed", type=int, default=1, metavar="N", help="of all noise (default: %(default)s)")
    trials.add_argument("--threads", type=int, default=1, metavar="N", help="of the simulation")
    trials.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="override a key of the scenarios"
    )


def run(args: argparse.Namespace) -> int:
    """Identify, print the tables, write what was asked for."""
    import json

    from ..errors import InputError
    from ..present.document import plain
    from ..present.identification_json import IDENTIFICATION, identification
    from ..record import read_dataset
    from ..record.atomic import write_text
    from ..record.folder import refuse_loss

    if (args.dataset is None) == (args.monte_carlo is None):
        raise InputError("expected a data set, or --monte-carlo N in its place")
    if args.monte_carlo is not None:
        return try_seeds(args)
    if args.out:
        refuse_loss(args.out, IDENTIFICATION)
    data = read_dataset(args.dataset)
    truth = read_known(args.truth) if args.truth else None
    found, skipped = identify_all(data.runs, MODELS if args.model == "all" else (args.model,), args)
    tables = chosen_sheets(found, truth, args.method)
    print(f"{data.path}: {len(data)} run{'s' * (len(data) > 1)}, input {found[0].runs[0].input_name}")
    print(plain(*tables))
    for reason in skipped:
        print(f"\n{reason}")
    content = json.dumps(identification(str(data.path), found, truth), indent=2) + "\n"
    if args.json:
        write_text(args.json, content)
    if args.out:
        write_folder(args.out, tables, found, content)
        print(f"\nwrote {args.out}")
    return 0


def try_seeds(args: argparse.Namespace) -> int:
    """Monte Carlo: print the table, write it as CSV or JSON where asked for."""
    import json

    from ..errors import InputError
    from ..present.document import plain
    from ..record.atomic import write_text
    from ..studies.design.montecarlo import monte_carlo, trials_sheet
    from .progress import progress

    if args.monte_carlo < 2 or args.threads < 1 or args.seed < 0 or args.out:
        raise InputError("--monte-carlo takes at least 2 seeds, --threads at least 1, --seed at least 0, and no --out")
    model: Model = "II" if args.model == "all" else args.model
    truth = args.truth or "paper-ii"
    with progress("identifying", args.monte_carlo) as advance:
        found = monte_carlo(truth, model, args.monte_carlo, args.simulator, args.set, args.seed, args.threads, advance)
    sheet = trials_sheet(found)
    print(plain(sheet))
    if args.json:
        rows = [dict(zip(sheet.header, row, strict=True)) for row in sheet.rows]
        write_text(args.json, json.dumps({"title": sheet.title, "rows": rows, "notes": sheet.notes}, indent=2) + "\n")
    return 0


def identify_all(
    runs: Sequence[Run], models: Sequence[Model], args: argparse.Namespace
) -> tuple[list[Comparison], list[str]]:
    """The models that these runs can carry, and for the others the reason; InputError where none can."""
    from ..errors import InputError
    from ..estimate.comparison import compare
    from ..estimate.observed import stretches
    from ..estimate.paper.settings import ESTIMATORS
    from .progress import progress

    estimators = () if args.method == "ml" else ESTIMATORS
    process_noise = {"auto": None, "on": True, "off": False}[args.process_noise]
    runs = stretches(runs)
    found: list[Comparison] = []
    skipped: list[str] = []
    with progress("identifying", len(models) * (len(runs) + 1)) as advance:
        for model in models:
            try:
                found.append(compare(runs, model, estimators, process_noise, advance))
            except InputError as error:
                skipped.append(f"Model {model} skipped: {error}")
    if not found:
        raise InputError(skipped[0])
    return found, skipped


def read_known(truth: str) -> dict[str, float]:
    """Parameters by name, SI, of a preset or of the first run in a truth.json; InputError where there are none."""
    from ..errors import InputError
    from ..plant.parameters import slot
    from ..plant.truth import load_truth
    from ..present.identification import NAMES
    from ..record import read_truth

    if truth.endswith(".json") or Path(truth).is_dir():
        content = read_truth(Path(truth)) or {}
        parameters = next((run.get("parameters") for run in content.get("runs", [])), None)
        if not isinstance(parameters, Mapping):
            raise InputError(f"{truth}: no runs with parameters in it, expected the truth.json of a data set")
        return {name: float(parameters.get(name, 0.0)) for name in NAMES}
    p = load_truth(truth).vector()
    return {name: float(p[slot(name)]) for name in NAMES}


def chosen_sheets(found: Sequence[Comparison], truth: Mapping[str, float] | None, method: str) -> list[Table]:
    """The tables of all models; those of the paper's methods alone, or without them, where that was asked for."""
    from ..present.identification import sheets

    by_name = {sheet.name: sheet for c in found for sheet in sheets(c, truth)}
    linear = by_name.pop("linear_model", None)
    tables = list(by_name.values()) + ([linear] if linear else [])
    return [s for s in tables if method != "paper" or s.name.endswith(("_methods", "linear_model"))]


def write_folder(path: Path, tables: Sequence[Table], found: Sequence[Comparison], content: str) -> None:
    """Markdown, one CSV per table, one picture per run, and the JSON; the folder appears whole or not at all."""
    import json

    from ..present.document import Block, Heading, Picture, csv_text, markdown
    from ..present.fit_picture import fit_picture
    from ..present.identification_json import IDENTIFICATION
    from ..record.folder import results_folder

    title = Heading(f"Identification of {json.loads(content)['dataset']}", 1)
    blocks: list[Block] = [title, *tables, Heading("Measured and simulated")]
    files = {f"{sheet.name}.csv": csv_text(sheet.header, sheet.rows).encode() for sheet in tables}
    for i, seen in enumerate(found[0].runs):
        files[f"{seen.name}.png"] = fit_picture(found, i)
        blocks.append(Picture(f"{seen.name}.png", f"{seen.name}: free run of every model"))
    files["identification.md"] = markdown(blocks).encode()
    with results_folder(path, IDENTIFICATION, json.loads(content)) as folder:
        for name, data in files.items():
            (folder / name).write_bytes(data)
