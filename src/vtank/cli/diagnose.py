"""`vtank diagnose`: where recordings and simulator part, which effect causes it, and how far the gap shrinks."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from ..diagnose.diagnosis import Diagnosis
    from ..estimate.observed import Observed
    from ..record import Run

NOMINAL = "paper-ii"
CLEAR = "\r\x1b[K"  # back to the start of the terminal's line, and wipe it
ORDER = ("schema", "verdict", "probabilities", "where", "shrink", "estimates", "absorbed", "tied", "next_experiment")
FEWEST_SAMPLES = 50  # measurements a run must have: five seconds at 10 Hz; a choice


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `diagnose DATASET`."""
    text = "find where the gap between recordings and a simulator lies, which effect causes it, and how far it shrinks"
    parser = subparsers.add_parser("diagnose", help=text, description=text)
    parser.add_argument("dataset", type=Path, metavar="DATASET", help="folder of *.csv runs, or one run")
    parser.add_argument(
        "--nominal", default=NOMINAL, metavar="FILE.toml",
        help=f"simulator to be explained: a truth preset (default {NOMINAL}), the path of one, or 'none' for a foreign "
        "vehicle, whose own refit is the simulator",
    )  # fmt: skip
    parser.add_argument(
        "--json", type=Path, metavar="OUT", help="write the findings as JSON (schema vtank.diagnosis/1)"
    )
    parser.add_argument("--report", type=Path, metavar="OUT.html", help="write the report, one HTML file")
    parser.add_argument("--model", type=Path, metavar="OUT.toml", help="write the diagnosed model, for vtank predict")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the simulated new data (default 0)")


def run(args: argparse.Namespace) -> int:
    """Diagnose, print, and write what was asked for."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: more threads only get in each other's way
    import json
    from shutil import get_terminal_size

    from ..errors import InputError
    from ..record import read_dataset
    from ..record.atomic import write_text

    if args.seed < 0:
        raise InputError(f"--seed {args.seed}: expected a whole number of at least 0")
    for path in (args.json, args.report, args.model):
        refuse_unwritable(path)
    runs = observed(read_dataset(args.dataset).runs)
    nominal = nominal_vector(args.nominal, runs)

    from numpy.linalg import LinAlgError

    from ..diagnose.diagnosis import diagnose
    from ..present.terminal import terminal_text

    with stages() as say:
        try:
            diagnosis = diagnose(runs, nominal, args.seed, say=say)
            document = complete(diagnosis, say)
        except LinAlgError as error:
            raise InputError(
                f"{args.dataset}: the recordings do not tell the simulator's parameters apart ({error}); "
                "expected runs in which the vehicle speeds up and slows down"
            ) from error
        if args.json:
            write_text(args.json, json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
        if args.model:
            from ..diagnose.model_file import write_model

            write_model(args.model, diagnosis)
        if args.report:
            from ..present.page import write_report

            write_report(args.report, diagnosis, document)
    print(terminal_text(document, min(get_terminal_size((100, 24)).columns, 110)), end="")
    return 0


def refuse_unwritable(path: Path | None) -> None:
    """InputError, before any work, where a file could not be written."""
    from ..errors import InputError

    if path is None:
        return
    parent = next(folder for folder in path.resolve().parents if folder.exists())
    if path.is_dir() or not parent.is_dir() or not os.access(parent, os.W_OK):
        raise InputError(f"{path}: cannot be written, expected the path of a file")


def observed(runs: Sequence[Run]) -> list[Observed]:
    """The runs as the diagnosis sees them; InputError where they do not go together or hold too little."""
    from ..errors import InputError
    from ..estimate.observed import observe, stretches

    found = [observe(run) for run in stretches(runs)]
    first = found[0]
    for run in found:
        if run.input_name != first.input_name:
            raise InputError(
                f"run {run.name}: its input is {run.input_name}, that of run {first.name} is {first.input_name}; "
                "all runs of a diagnosis need the same input"
            )
        if run.time_s.size < FEWEST_SAMPLES:
            raise InputError(
                f"run {run.name}: {run.time_s.size} measurements, expected at least {FEWEST_SAMPLES} to diagnose"
            )
        if run.input.size < 2:
            raise InputError(f"run {run.name}: one value of {run.input_name}, expected one for every change of it")
    if all(float(abs(run.input).max()) == 0.0 for run in found):
        raise InputError(
            f"{first.input_name} is zero in all runs: nothing drives the vehicle, nothing can be diagnosed"
        )
    return found


def nominal_vector(name: str, runs: Sequence[Observed]) -> np.ndarray | None:
    """Parameter vector of the nominal simulator, shape (P,); None for a foreign vehicle; InputError if it cannot be."""
    from ..errors import InputError
    from ..plant.truth import load_truth

    if name == "none":
        return None
    truth = load_truth(name)
    if runs[0].input_name != "n_rev_s":
        raise InputError(
            f"run {runs[0].name}: its input is {runs[0].input_name}, but the nominal simulator {truth.name} is driven "
            "by a propeller speed, n_rev_s; for a foreign vehicle use --nominal none"
        )
    return truth.vector()


def complete(diagnosis: Diagnosis, say: Callable[[str], None]) -> dict[str, Any]:
    """The whole document of schema vtank.diagnosis/1: with where, how far, and what next."""
    from ..diagnose.diagnosis import own_parameters
    from ..diagnose.localise.where import locate
    from ..diagnose.next_experiment import next_experiment
    from ..diagnose.shrink import shrink

    selection, verdict, chances = diagnosis.selection, diagnosis.verdict, diagnosis.probabilities
    document = diagnosis.document()
    say("where the gap lies")
    document["where"] = locate(selection, verdict, chances).document()
    say("how far it shrinks on runs left out")
    document["shrink"] = shrink(selection, verdict, diagnosis.seed)
    say("next experiment")
    document["next_experiment"] = next_experiment(selection, verdict, chances)
    document["parameters"] = own_parameters(selection, verdict)
    return {key: document[key] for key in (*ORDER, *(k for k in document if k not in ORDER))}


@contextmanager
def stages() -> Iterator[Callable[[str], None]]:
    """Yield `say(text)`, which tells on stderr what is being done: a line rewritten on a terminal, lines elsewhere."""
    terminal = sys.stderr.isatty()

    def say(text: str) -> None:
        start, end = (CLEAR, "") if terminal else ("", "\n")
        print(f"{start}{text} ...", end=end, file=sys.stderr, flush=True)

    try:
        yield say
    finally:
        if terminal:
            print(CLEAR, end="", file=sys.stderr, flush=True)
