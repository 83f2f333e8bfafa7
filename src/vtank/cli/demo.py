"""`vtank demo`: a recording whose cause is withheld, its simulator, the gap between them, and the gap closed."""

from __future__ import annotations

import argparse
import shutil
import textwrap
import time
from pathlib import Path
from typing import TYPE_CHECKING

from .checks import at_least
from .reproduce import DEFAULT_SEED

if TYPE_CHECKING:
    from ..studies.story.step import Step

WIDTH = 110  # columns of text on a terminal, at most
REPRODUCE = "The paper's tables and figures, and a study of its estimator: vtank reproduce (make reproduce)."


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `demo [--out DIR] [--seed N]`."""
    text = "a recording whose cause is withheld, its simulator, the gap, its cause, and the gap closed"
    text += " (half a minute, and two or three more the first time, for compiling)"
    parser = subparsers.add_parser("demo", help=text, description=text)
    parser.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="folder to write (default: out)")
    parser.add_argument("--seed", type=int, default=DEFAULT_SEED, metavar="N", help="of the cause and of all noise")


def run(args: argparse.Namespace) -> int:
    """Tell the acts one after the other; the start page is there after the first and completed by the second."""
    from ..record.folder import Kind, results_folder
    from ..studies.story.bluerov import bluerov
    from ..studies.story.page import write_page
    from ..studies.story.phoenix import phoenix
    from ..studies.story.step import Act
    from .progress import percent, progress

    at_least(0, seed=args.seed)
    start, kind, steps = time.monotonic(), Kind("what vtank demo makes", "demo.json", "vtank.demo/1"), []
    acts = (phoenix, bluerov)
    for number, act in enumerate(acts, 1):
        with results_folder(args.out, kind, {"seed": args.seed, "acts": number}) as folder:
            if number > 1:  # the first act stays as it was until both are there
                shutil.copytree(args.out, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns(kind.marker))
            for step in act(Act(folder, args.seed, percent, progress)):
                steps.append(step)
                show(len(steps), step)
            write_page(folder, steps, number == len(acts))
        told = "" if number == len(acts) else "; a second act follows, of a whole vehicle, and completes it"
        print(f"\nAfter {time.monotonic() - start:.0f} s: {args.out / 'index.html'} is the page to start at{told}.\n")
    print(REPRODUCE)
    return 0


def show(number: int, step: Step) -> None:
    """A step in a line or three."""
    text = f"{number:2}  {step.title}. {step.text}"
    width = min(shutil.get_terminal_size((100, 24)).columns, WIDTH)
    print(textwrap.fill(text, width, subsequent_indent=" " * 4), flush=True)
