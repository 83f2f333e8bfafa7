"""`vtank reproduce`: the paper's tables and figures on simulated data, and how far its estimator makes its drag."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..resources import TRUTHS

DEFAULT_SEED = 1996


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `reproduce [--out DIR] [--seed N] [--truth NAME] [--quick]`."""
    text = "reproduce the paper's Tables 1 to 4 and Figures 1 to 12 on simulated data, and study its estimator's bias"
    parser = subparsers.add_parser("reproduce", help=text, description=text)
    out = Path("reproduction")
    parser.add_argument("--out", type=Path, default=out, metavar="DIR", help=f"folder to write (default: {out})")
    parser.add_argument(
        "--seed", type=int, default=DEFAULT_SEED, metavar="N", help="seed of all noise (default: %(default)s)"
    )
    parser.add_argument(
        "--truth",
        choices=(*TRUTHS, "all"),
        default="all",
        help="truth of the tables and figures; the study has all three",
    )
    parser.add_argument("--quick", action="store_true", help="a study on few seeds, for a first look")


def run(args: argparse.Namespace) -> int:
    """Simulate, identify, study, write."""
    from ..present.blocks import Paragraph
    from ..present.document import plain
    from ..record import current_versions, results_folder
    from ..studies.paper.findings import summary
    from ..studies.paper.overview import overview
    from ..studies.paper.run import FULL, QUICK, REPRODUCTION, fly, reproduce, write_flights
    from .checks import at_least, check_outputs
    from .progress import percent, progress

    at_least(0, seed=args.seed)
    check_outputs(args, "out")
    truths = TRUTHS if args.truth == "all" else (args.truth,)
    about = {"seed": args.seed, "truths": list(truths), "quick": args.quick, "versions": current_versions()}
    with results_folder(args.out, REPRODUCTION, about) as folder:
        with percent("simulating the experiments") as report:
            flights = fly(truths, args.seed, report)
        write_flights(folder / "data", flights)
        results = reproduce(folder, flights, args.seed, QUICK if args.quick else FULL, progress)
    print(plain(overview(results.campaigns)), plain(Paragraph(summary(results))), sep="\n\n")
    print(f"\nwrote {args.out}: start at {args.out / 'index.html'}")
    return 0
