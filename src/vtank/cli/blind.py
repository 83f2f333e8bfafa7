"""`vtank blind`: sealed cases, answers committed by hash, and their score."""

from __future__ import annotations

import argparse
import re
import textwrap
from pathlib import Path

from ..errors import InputError
from .checks import at_least, check_outputs, refuse_unwritable


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `blind make`, `blind answer` and `blind score`."""
    text = "prove the diagnosis on sealed cases whose cause is withheld"
    parser = subparsers.add_parser("blind", help=text, description=text)
    commands = parser.add_subparsers(dest="blind", metavar="COMMAND", required=True)
    _make_parser(commands)
    _answer_parser(commands)
    _score_parser(commands)


def _make_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    text = "draw cases, fly them in the MuJoCo tank and seal their truth in another folder"
    more = "an interrupted go is taken up when the same command is given again"
    parser = commands.add_parser("make", help=text, description=f"{text}; {more}")
    parser.set_defaults(work=_make)
    parser.add_argument("--trials", type=int, required=True, metavar="N", help="number of cases")
    parser.add_argument("--seed", type=int, required=True, metavar="S", help="seed of everything that is drawn")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the cases")
    parser.add_argument("--truth-out", type=Path, metavar="DIR", help="folder for the truth (default: DIR-truth)")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="cases at a time (default 2)")
    parser.add_argument(
        "--vehicles", action="store_true", help="whole vehicles with effects at places, of which nothing else is chosen"
    )
    parser.add_argument("--kinds", nargs="+", metavar="KIND", help="kinds of cases (default all)")
    parser.add_argument(
        "--effects", nargs="+", metavar="NAME", help="effects, laws and own parameters that may come up"
    )
    parser.add_argument("--familiar", action="store_true", help="closed-loop sinusoids and white sonar noise only")
    parser.add_argument(
        "--no-separations",
        action="store_true",
        help="do not compute what known effects leave of an unknown cause: much faster",
    )


def _answer_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    text = "diagnose every case from its runs alone and commit to the answers by hash"
    parser = commands.add_parser("answer", help=text, description=text)
    parser.set_defaults(work=_answer)
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the cases")
    parser.add_argument("--out", type=Path, metavar="FILE", help="answers (default: DIR/answers.json)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the diagnosis (default 0)")
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="cases at a time (default 2)")


def _score_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    text = "verify every hash and score the answers"
    parser = commands.add_parser("score", help=text, description=text)
    parser.set_defaults(work=_score)
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of the cases")
    parser.add_argument("--truth", type=Path, required=True, metavar="DIR", help="folder of the truth")
    parser.add_argument("--answers", type=Path, metavar="FILE", help="answers (default: DIR/answers.json)")
    parser.add_argument(
        "--published", metavar="SHA256", help="hash of the answers, published before the truth was opened"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for tables and figures (default: DIR-score)")
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="cases at a time (default 2)")


def run(args: argparse.Namespace) -> int:
    """Do what the sub-command asks."""
    code: int = args.work(args)
    return code


def _make(args: argparse.Namespace) -> int:
    from .progress import taken_up_later

    at_least(1, trials=args.trials, threads=args.threads)
    at_least(0, seed=args.seed)
    truth_out = args.truth_out or _beside(args.out, "-truth")
    with taken_up_later(f"{args.out}: "):
        _made_cases(args, truth_out)
    print(f"wrote {args.trials} cases to {args.out}, their truth to {truth_out}: keep it away from whoever answers")
    return 0


def _made_cases(args: argparse.Namespace, truth_out: Path) -> None:
    from ..studies.blind.case import KINDS
    from ..studies.blind.make import Order, make
    from .progress import progress

    if args.vehicles:
        _make_vehicles(args, truth_out)
        return
    kinds = tuple(KINDS) if args.kinds is None else tuple(args.kinds)
    effects = None if args.effects is None else tuple(args.effects)
    order = Order(args.trials, args.seed, kinds, effects, args.familiar, not args.no_separations, args.threads)
    make(order, args.out, truth_out, progress)


def _make_vehicles(args: argparse.Namespace, truth_out: Path) -> None:
    from ..studies.blind.whole.make import make_whole
    from .progress import progress

    if args.kinds or args.effects or args.familiar or args.no_separations:
        raise InputError("--kinds, --effects, --familiar and --no-separations do not go with --vehicles; expected none")
    make_whole(args.trials, args.seed, args.out, truth_out, args.threads, progress)


def _answer(args: argparse.Namespace) -> int:
    from ..studies.blind.answer import answer
    from .progress import progress

    at_least(1, processes=args.processes)
    at_least(0, seed=args.seed)
    out = args.out or args.folder / "answers.json"
    refuse_unwritable(out)
    check_outputs(argparse.Namespace(folder=args.folder, out=out), "out")
    total = answer(args.folder, out, args.seed, args.processes, progress)
    print(f"wrote {out}\nsha256 {total}: publish it before the truth is opened")
    return 0


def _score(args: argparse.Namespace) -> int:
    from ..present.document import plain
    from ..record.folder import refuse_loss
    from ..studies.blind.score import RESULTS, score, write_score
    from ..studies.blind.tables import tables
    from .progress import progress

    at_least(1, processes=args.processes)
    answers = args.answers or args.folder / "answers.json"
    if args.published is not None and not re.fullmatch("[0-9a-f]{64}", args.published):
        raise InputError(f"--published {args.published}: expected the 64 hexadecimal digits of a SHA-256")
    out = args.out or _beside(args.folder, "-score")
    refuse_loss(out, RESULTS)
    read = {"folder": args.folder, "truth": args.truth, "answers": answers}
    check_outputs(argparse.Namespace(**read, out=out), "out")
    scored = score(args.folder, args.truth, answers, args.processes, progress, args.published)
    write_score(out, scored)
    for sentence in scored["checked"]:
        print(textwrap.fill(sentence, 110, subsequent_indent="  "))
    print(plain(tables(scored["measures"], scored["scheme"].bars)[0]))
    print(f"wrote {out}")
    return 0


def _beside(folder: Path, ending: str) -> Path:
    """The folder next to this one whose name has the ending."""
    place = folder if folder.name not in ("", "..") else folder.resolve()
    if not place.name:
        raise InputError(f"{folder}: the root of the file system has no folder beside it; choose another")
    return place.with_name(place.name + ending)
