"""`vtank blind answer`: diagnose every case from its runs alone and commit to the answers by hash.

A case that cannot be diagnosed is a refusal: an answer with uniform probabilities and the message, scored like any
other. So is one in which the program fails, but that is told. Work that was interrupted goes on where it stopped,
unless the recordings or the program have changed since.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import vtank

from ...effects import CATALOGUE
from ...errors import InputError
from ...plant import load_truth, switched_on
from ...record import Held, cannot_write, current_versions, jsonable, locked, read_bytes, sha256, write_files
from ..processes import processes
from ..stage import Stage, silent
from .seal import Entry, Index, canonical, digest, json_bytes, read_index

SCHEMA = "vtank.blind-answers/1"
UNSCORED = ("parameters", "baselines")  # of a diagnosis, what no question is asked about
Refuse = Callable[[str, tuple[str, ...], str], dict[str, Any]]  # message, withheld effects, nominal
AnswerCase = Callable[[Path, int, tuple[str, ...], str], dict[str, Any]]  # folder, seed, withheld effects, nominal


def diagnose_case(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
    """The diagnosis of one case: its document, how far the gap shrinks, and the text of the diagnosed model's file."""
    from ...diagnose import diagnose, model_text
    from ...estimate import observe
    from ...record import read_dataset

    runs = [observe(run) for run in read_dataset(folder)]
    names = [effect.name for effect in CATALOGUE if effect.name not in withheld] if withheld else None
    diagnosis = diagnose(runs, load_truth(nominal).vector(), seed, names)
    document = {key: value for key, value in diagnosis.document.items() if key not in UNSCORED}
    return {"document": document, "model": model_text(diagnosis)}


def diagnose_vehicle(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
    """The diagnosis of a case of a whole vehicle, as `diagnose_case`; nothing in it is drawn from the seed."""
    from ...diagnose.whole import diagnose, model_text
    from ...plant import load_vehicle
    from ...record import read_dataset

    found = diagnose(read_dataset(folder).runs, load_vehicle(nominal))
    return {"document": found.document, "model": model_text(found)}


def refuse_vehicle(message: str, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
    """The answer of one who cannot answer, to a case of a whole vehicle: nothing is said."""
    verdict: dict[str, Any] = {
        "kind": "undecided",
        "effects": [],
        "places": [],
        "class": [],
        "channel": None,
        "probability": 0.0,
    }
    return {"refused": message, "document": {"verdict": verdict, "probabilities": {}}}


def answer(
    folder: Path,
    out: Path,
    seed: int = 0,
    count: int = 2,
    stage: Stage = silent,
    answer_case: AnswerCase | None = None,
) -> str:
    """Write the answers to all cases in `folder` to `out`, their hashes beside it; returns the hash of all.

    answer_case: by default a diagnosis of one axis, or of a whole vehicle, as the index says.

    InputError where a recording is not the one that the index lists, and where `out` holds other answers.
    """
    index = read_index(folder)
    for entry in index.entries:
        check_data(folder, entry)
    if answer_case is None:
        answer_case = diagnose_vehicle if index.vehicles else diagnose_case
    program = sources()
    _refuse_other(out, {"schema": SCHEMA, "index": index.sha256, "seed": seed, "sources": program})
    mark = digest({"index": index.sha256, "seed": seed, "sources": program})
    one = partial(_one, folder, seed, answer_case, refuse_vehicle if index.vehicles else refusal)
    with _taken(out) as part:
        done = _resume(part, mark)
        rest = [entry for entry in index.entries if entry.case not in done]
        with processes(count) as work, stage("diagnosing", len(rest)) as said:
            for entry, found in zip(rest, work(one, rest), strict=True):
                done[entry.case] = found
                line = json.dumps({"mark": mark, "case": entry.case, "answer": found}, allow_nan=False)
                with cannot_write(part), part.open("a", encoding="utf-8") as lines:
                    lines.write(line + "\n")
                said(entry.case)
        total = _commit(out, index, seed, program, done)
        part.unlink()
    for case in (entry.case for entry in index.entries if done[entry.case].get("fault")):
        warnings.warn(f"{case}: answered by a refusal, for vtank failed: {done[case]['refused']}", stacklevel=2)
    return total


def _refuse_other(out: Path, about: dict[str, Any]) -> None:
    """InputError where a file is in the place of the answers that is not the same ones: answers are committed to."""
    if not out.exists():
        return
    try:
        there = json.loads(read_bytes(out))
        same = {key: there[key] for key in about} == about
    except (ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{out}: is there already, and holds no answers; expected another --out") from None
    if not same:
        told = "holds answers of another seed, program or trials, which are committed to"
        hashes = out.with_suffix(".sha256").name
        raise InputError(f"{out}: {told}; expected another --out, or remove it and {hashes} to answer anew")


@contextmanager
def _taken(out: Path) -> Iterator[Path]:
    """The file of the answers so far, held by this process alone; InputError where another one answers into it."""
    part = out.with_name(out.name + ".part")
    with cannot_write(part):
        out.parent.mkdir(parents=True, exist_ok=True)
        part.touch()
    try:
        with locked(part):
            yield part
    except Held:
        raise InputError(f"{out}: another process is answering into it; wait for it, or choose another --out") from None


def check_data(folder: Path, entry: Entry) -> None:
    """InputError where a recording of a case is missing, added or changed."""
    present = {path.name: path for path in (folder / entry.case).glob("*")}
    for file in sorted({*present, *entry.runs}):
        path = folder / entry.case / file
        if file not in present:
            raise InputError(f"{path}: missing; the index lists it")
        if sha256(read_bytes(path)) != entry.runs.get(file):
            raise InputError(f"{path}: not the recording that the index lists; changed since the cases were made")


def sources() -> str:
    """One hash for all source files and frozen numbers of the package: which program gave the answers."""
    root = Path(vtank.__file__).parent
    files = sorted(path for pattern in ("*.py", "*.toml", "*.xml") for path in root.rglob(pattern))
    return digest({str(path.relative_to(root)): sha256(path.read_bytes()) for path in files})


def _one(folder: Path, seed: int, answer_case: AnswerCase, refuse: Refuse, entry: Entry) -> dict[str, Any]:
    own = folder / entry.nominal
    nominal = str(own) if own.is_file() else entry.nominal
    try:
        found = jsonable(answer_case(folder / entry.case, seed, entry.withheld, nominal))
        canonical(found)
    except InputError as reason:
        found = refuse(str(reason), entry.withheld, nominal)
    except (MemoryError, OSError):
        raise  # not a matter of the case
    except Exception as error:  # whatever goes wrong in one case must not stop the others
        found = refuse(f"{type(error).__name__}: {error}", entry.withheld, nominal) | {"fault": True}
    return {"data": entry.data, **found}


def refusal(message: str, withheld: tuple[str, ...] = (), nominal: str = "paper-ii") -> dict[str, Any]:
    """The answer of one who cannot answer: every effect, none, parameters and unknown are equally likely."""
    known = {*withheld, *(effect.name for effect in switched_on(load_truth(nominal).vector()))}
    chosen = [e for e in CATALOGUE if e.standing != "absorbed" and not e.same_as and e.name not in known]
    chosen.sort(key=lambda effect: effect.standing == "separable")
    names = ["none", "parameters", "unknown", *(effect.name for effect in chosen)]
    p = 1.0 / len(names)
    verdict: dict[str, Any] = {"kind": "undecided", "effects": [], "class": [], "channel": None, "probability": p}
    return {"refused": message, "document": {"verdict": verdict, "probabilities": dict.fromkeys(names, p)}}


def _resume(part: Path, mark: str) -> dict[str, Any]:
    """Answers of an interrupted run of the same program on the same cases; a line that is none is left out."""
    done: dict[str, Any] = {}
    data = read_bytes(part)
    whole = data[: data.rfind(b"\n") + 1]
    for line in whole.splitlines():
        try:
            content = json.loads(line)
            if content["mark"] == mark:
                done[str(content["case"])] = dict(content["answer"])
        except (ValueError, KeyError, TypeError, RecursionError):
            continue
    os.truncate(part, len(whole))  # a line cut short by a kill would spoil the next
    return done


def _commit(out: Path, index: Index, seed: int, program: str, answers: dict[str, Any]) -> str:
    content = {"schema": SCHEMA, "index": index.sha256, "seed": seed, "sources": program,
               "versions": current_versions(), "answers": answers}  # fmt: skip
    data = json_bytes(content)
    lines = [f"{sha256(data)}  {out.name}", *(f"{digest(found)}  {case}" for case, found in sorted(answers.items()))]
    write_files({out.with_suffix(".sha256"): ("\n".join(lines) + "\n").encode(), out: data})
    return sha256(data)
