"""`vtank identify`: the surge models that a data set asks for, by likelihood and by the paper's methods.

With --monte-carlo N no data set is read: the paper's experiments are simulated N times and the likelihood is put to the
test: `vtank identify --monte-carlo 400 --model II --truth paper-ii --set tachometer.noise_rev_s=0`.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..estimate.paper import Model

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
    parser.add_argument("--nominal", metavar="VEHICLE.toml", help="of recordings of a whole vehicle, its file")
    parser.add_argument(
        "--axes", metavar="A,B", type=lambda text: tuple(part.strip() for part in text.split(",")),
        help="axes of a whole vehicle that are asked about (default: all that something tells of)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="OUT", help="write everything to a JSON file")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for tables (Markdown, CSV) and pictures")
    parser.add_argument("--verbose", action="store_true", help="print all tables: residuals, validation, every method")
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
    from ..errors import InputError
    from .checks import check_outputs

    if (args.dataset is None) == (args.monte_carlo is None):
        raise InputError("expected a data set, or --monte-carlo N in its place")
    check_outputs(args, "json", "out")
    if args.nominal:
        return identify_whole(args)
    if args.axes:
        raise InputError("--axes: goes with --nominal vehicle.toml and recordings of a whole vehicle; expected neither")
    return try_seeds(args) if args.dataset is None else identify(args)


def identify_whole(args: argparse.Namespace) -> int:
    """Own parameters of a whole vehicle: print the table, write it where asked for."""
    from ..diagnose.whole.identified import WholeEstimate
    from ..errors import InputError
    from ..library import identify as identify_runs
    from ..library import load
    from ..record import json_text, write_text
    from .checks import refuse_unwritable

    refuse_unwritable(args.json)
    if args.dataset is None or args.out:
        raise InputError("--nominal: expected a data set, and no --out: --json OUT keeps what is printed")
    found = identify_runs(load(args.dataset), nominal=args.nominal, axes=args.axes)
    if not isinstance(found, WholeEstimate):
        raise InputError(f"--nominal {args.nominal}: expected the file of a vehicle, and its recordings")
    print(found, end="")
    for note in found.notes:
        print(note)
    if args.json:
        write_text(args.json, json_text(found.document))
    return 0


def identify(args: argparse.Namespace) -> int:
    """Models of a data set: a page on the terminal, everything in the files."""
    from ..estimate.comparison import compare_all
    from ..estimate.observed import stretches
    from ..library import load
    from ..present import identified
    from ..present.document import plain
    from ..record import json_text, refuse_loss, write_text
    from .checks import refuse_unwritable
    from .progress import progress

    refuse_unwritable(args.json)
    if args.out:
        refuse_loss(args.out, identified.IDENTIFICATION)
    runs, models = stretches(load(args.dataset)), MODELS if args.model == "all" else (args.model,)
    truth = identified.known_truth(args.truth) if args.truth else None
    noise = {"auto": None, "on": True, "off": False}[args.process_noise]
    with progress("identifying", len(models) * (len(runs) + 1)) as advance:
        found, skipped = compare_all(runs, models, args.method != "ml", noise, advance)
    tables = identified.tables(found, truth, args.method)
    print(f"{args.dataset}: {len(runs)} run{'s' * (len(runs) > 1)}, input {runs[0].input}")
    print(plain(*(tables if args.verbose else identified.page(tables))))
    for reason in skipped:
        print(f"\n{reason}")
    if not args.verbose and len(tables) > len(identified.page(tables)):
        print("\nResiduals, validation across runs and each run by each method: --verbose, or --out DIR.")
    content = identified.identification(str(args.dataset), found, truth)
    if args.json:
        write_text(args.json, json_text(content))
    if args.out:
        identified.write_folder(args.out, tables, found, content)
        print(f"\nwrote {args.out}")
    return 0


def try_seeds(args: argparse.Namespace) -> int:
    """Monte Carlo: print the table, write it as CSV or JSON where asked for."""
    from ..errors import InputError
    from ..present.document import plain
    from ..record import json_text, write_text
    from ..studies.design import monte_carlo, trials_sheet
    from .checks import at_least, refuse_unwritable
    from .progress import progress

    at_least(2, monte_carlo=args.monte_carlo)
    at_least(1, threads=args.threads)
    at_least(0, seed=args.seed)
    refuse_unwritable(args.json)
    if args.out:
        raise InputError("--monte-carlo prints a table, --json OUT keeps it; expected no --out")
    model: Model = "II" if args.model == "all" else args.model
    truth = args.truth or "paper-ii"
    with progress("identifying", args.monte_carlo) as advance:
        found = monte_carlo(truth, model, args.monte_carlo, args.simulator, args.set, args.seed, args.threads, advance)
    sheet = trials_sheet(found)
    print(plain(sheet))
    if args.json:
        rows = [dict(zip(sheet.header, row, strict=True)) for row in sheet.rows]
        write_text(args.json, json_text({"title": sheet.title, "rows": rows, "notes": sheet.notes}))
    return 0
