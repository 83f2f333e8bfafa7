"""Verification before any score: recordings, truths and answers are what was committed to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...record import parse_json, read_bytes, read_json, read_text, sha256
from .answer import SCHEMA as ANSWERS_SCHEMA
from .seal import (
    TRUTH_SCHEMA,
    VEHICLES_SCHEMA,
    Index,
    canonical,
    commitment,
    digest,
    finite,
    is_name,
    read_index,
    read_seal,
)


@dataclass(frozen=True)
class Opened:
    """Everything that is needed to score, verified.

    Attributes:
        truths, answers: by case.
        sources: of the program that answered, their hash.
        checked: what was verified, in sentences.
        folder: of the cases. vehicles: whether they are whole vehicles.
    """

    truths: dict[str, dict[str, Any]]
    answers: dict[str, dict[str, Any]]
    sources: str
    checked: tuple[str, ...]
    folder: Path
    vehicles: bool = False


def open_all(folder: Path, truth: Path, answers: Path, published: str | None = None) -> Opened:
    """Verify every hash and open the seals; InputError names all that was changed, is missing or does not belong.

    published: SHA-256 of the answers as it was made known before the truth was opened. Without it nothing tells whether
    answers and their hashes were written anew together.
    """
    index = read_index(folder)
    faults = [fault for entry in index.entries for fault in _files(folder / entry.case, entry.runs, "recording")]
    seal, found = read_seal(truth, index)
    faults += found
    schema = VEHICLES_SCHEMA if index.vehicles else TRUTH_SCHEMA
    truths = {entry.case: _truth(truth, entry.case) for entry in index.entries}
    for entry in index.entries:
        document = truths[entry.case]["truth"]
        if commitment(truths[entry.case].get("salt"), document) != entry.commitment:
            faults.append(f"{truth / entry.case}.json: the truth is not the one that was sealed")
        elif document.get("schema") != schema or document.get("data") != entry.data:
            faults.append(f"{truth / entry.case}.json: the truth does not belong to the recordings of {entry.case}")
        else:
            faults += _flights(truth, entry.case, document, "held_out")
            faults += _flights(truth, entry.case, document, "plain") if index.vehicles else []
    content, found = _answers(answers, index)
    faults += found
    total = sha256(read_bytes(answers))
    if published is not None and total != published:
        faults.append(f"{answers}: SHA-256 {total}, but {published} was published")
    if faults:
        raise InputError("nothing is scored:\n  " + "\n  ".join(faults))
    given = sum(len(entry.runs) for entry in index.entries)
    held = sum(len(t["truth"]["held_out_files"]) for t in truths.values())
    checked = (
        f"Cases: {len(index.entries)} with {given} recordings; SHA-256 of their index {index.sha256}.",
        f"Truths: {len(truths)} with {held} held-out runs, all as the index commits to, and so is what was asked for: "
        f"{canonical(seal.get('order')).decode()}.",
        f"Answers: one to each case, given to these recordings with seed {content.get('seed')}; SHA-256 {total}, "
        + ("as published." if published else "NOT held against a published one: no proof that they came first."),
    )
    return Opened(
        {case: t["truth"] for case, t in truths.items()},
        content["answers"],
        content["sources"],
        checked,
        folder,
        index.vehicles,
    )


def _truth(truth: Path, case: str) -> dict[str, Any]:
    path = truth / f"{case}.json"
    content = parse_json(read_text(path), path)
    if not isinstance(content, dict) or not isinstance(content.get("truth"), dict):
        raise InputError(f"{path}: not the truth of a case")
    return content


def _flights(truth: Path, case: str, document: dict[str, Any], kind: str) -> list[str]:
    """What is wrong with the flights of a kind, held_out or plain, that lie beside a truth."""
    files, words = document.get(f"{kind}_files"), kind.replace("_", "-")
    if not isinstance(files, dict) or not all(map(is_name, files)):
        return [f"{truth / case}.json: does not list the {words} runs"]
    return list(_files(truth / kind / case, files, f"{words} run"))


def _files(folder: Path, hashes: Mapping[str, str], what: str) -> Iterator[str]:
    """What is wrong with the files of these names and hashes."""
    for path, expected in ((folder / name, expected) for name, expected in hashes.items()):
        if not path.is_file():
            yield f"{path}: missing"
        elif sha256(read_bytes(path)) != expected:
            yield f"{path}: the {what} was changed"


def _answers(path: Path, index: Index) -> tuple[dict[str, Any], list[str]]:
    content = read_json(path, ANSWERS_SCHEMA)
    listed = path.with_suffix(".sha256")
    try:
        committed = {name: hash for hash, name in (line.split("  ", 1) for line in read_text(listed).splitlines())}
    except (InputError, ValueError):
        raise InputError(f"{listed}: cannot be read, expected the hashes of {path.name}") from None
    if not isinstance(content.get("answers"), dict) or not isinstance(content.get("sources"), str):
        raise InputError(f"{path}: not answers of schema {ANSWERS_SCHEMA}")
    faults = []
    if content.get("index") != index.sha256:
        faults.append(f"{path}: answers to other cases")
    for entry in index.entries:
        answer = content["answers"].get(entry.case)
        if answer is None:
            faults.append(f"{path}: no answer to {entry.case}")
        elif not _is_answer(answer):
            faults.append(f"{path}: the answer to {entry.case} has no verdict, or no probabilities")
        elif committed.get(entry.case) != digest(answer):
            faults.append(f"{path}: the answer to {entry.case} is not the one that was committed to")
        elif answer.get("data") != entry.data:
            faults.append(f"{path}: the answer to {entry.case} was given to other recordings")
    if not faults and committed.get(path.name) != sha256(read_bytes(path)):
        faults.append(f"{path}: changed since the answers were committed to")
    return content, faults


def _is_answer(answer: Any) -> bool:
    document = answer.get("document") if isinstance(answer, dict) and finite(answer) else None
    return isinstance(document, dict) and all(isinstance(document.get(k), dict) for k in ("verdict", "probabilities"))
