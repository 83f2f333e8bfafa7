"""Sealing: case files that tell nothing but their data, and salted hashes that bind truth and answers.

DIR holds case_0001/run_1.csv ... and cases.json with the hash of every file, the commitment to every truth and the one
to what was asked for, seed and order. The truths, the order and their salts lie in another folder. So the hash of
cases.json binds everything; answers name it, and the hash of the answers is what is published.
"""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...record import NEW, Run, clear_rooms, current_versions, left_rooms, read_bytes, read_json, sha256
from ...record.files import resolved

SCHEMA, TRUTH_SCHEMA, SEAL_SCHEMA = "vtank.blind/3", "vtank.blind-truth/2", "vtank.blind-seal/2"
VEHICLES_SCHEMA = "vtank.blind-vehicles-truth/1"  # of the truths of whole vehicles
INDEX, SEAL = "cases.json", "seal.json"
SALT_BYTES = 32
EPOCH_S = 946684800  # [s] 1 January 2000: the time stamp of every file
FORMATS = {  # one width for all
    "time_s": "%10.4f",
    "n_rev_s": "%11.5f",
    "range_m": "%9.5f",
    "clean_m": "%10.6f",
    "spike_rev_s": "%11.5f",
}


def canonical(document: Any) -> bytes:
    """JSON with sorted keys and no spaces: one document, one sequence of bytes."""
    return json.dumps(document, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=True).encode()


def digest(document: Any) -> str:
    """SHA-256 of the canonical JSON, in hex."""
    return sha256(canonical(document))


def new_salt() -> str:
    """256 bits in hex, from the operating system and not from the seed, which could be guessed."""
    return secrets.token_hex(SALT_BYTES)


def commitment(salt: Any, document: Any) -> str:
    """SHA-256 of salt and canonical JSON: binds both, tells nothing about them; empty for what is no salt."""
    sound = isinstance(salt, str) and len(salt) == 2 * SALT_BYTES and set(salt) <= set("0123456789abcdef")
    return sha256(salt.encode() + canonical(document)) if sound and finite(document) else ""


def fixed_csv(run: Run) -> bytes:
    """The CSV file of a run with every cell as wide as its column, missing ones blank: all runs take the same bytes."""
    columns = {"time_s": run.time_s, **run.columns}
    widths = {name: FORMATS[name] for name in columns}
    cells = [[_cell(widths[name], value) for value in values.tolist()] for name, values in columns.items()]
    lines = [",".join(columns), *map(",".join, zip(*cells, strict=True))]
    return ("\n".join(lines) + "\n").encode()


def _cell(form: str, value: float) -> str:
    blank = " " * len(form % 0.0)
    text = blank if value != value else form % value
    if len(text) != len(blank):
        raise InputError(f"{value}: too large to be written as '{form}'")
    return text


def as_written(values: np.ndarray, name: str) -> np.ndarray:
    """Values as a reader of the file gets them, rounded like the column of that name, shape as given."""
    return np.round(values, int(FORMATS[name].split(".")[1].rstrip("f")))


def json_bytes(document: Any) -> bytes:
    """JSON to be read by people too."""
    return (json.dumps(document, indent=1, sort_keys=True, allow_nan=False) + "\n").encode()


def finite(document: Any) -> bool:
    """Whether it can be written: all its numbers are numbers, as JSON wants them."""
    try:
        return bool(json_bytes(document))
    except (ValueError, RecursionError):
        return False


@dataclass(frozen=True)
class Entry:
    """A case in the index: its name, hashes of its files, effects to do without, commitment to its truth.

    nominal: truth preset, or a file in DIR, of the simulator to compare with.
    """

    case: str
    nominal: str
    runs: dict[str, str]
    withheld: tuple[str, ...]
    commitment: str

    @property
    def data(self) -> str:
        """One hash for all its recordings."""
        return digest(self.runs)


@dataclass(frozen=True)
class Index:
    """What DIR says about itself: the cases, the commitment to the order; `sha256` of the file.

    vehicles: whether they are whole vehicles, and `nominal` of an entry the name of a vehicle file.
    """

    entries: tuple[Entry, ...]
    order: str
    sha256: str
    vehicles: bool = False


def write_runs(folder: Path, runs: Iterable[Run], as_bytes: Callable[[Run], bytes] = fixed_csv) -> dict[str, str]:
    """Write runs as run_1.csv, run_2.csv and so on into a new folder; file -> hash."""
    folder.mkdir(parents=True)
    contents = {f"run_{k}.csv": as_bytes(run) for k, run in enumerate(runs, 1)}
    for file, data in contents.items():
        (folder / file).write_bytes(data)
    return {file: sha256(data) for file, data in contents.items()}


def seal_truth(path: Path, truth: Mapping[str, Any]) -> str:
    """Write a truth and its salt; the commitment to it."""
    salt = new_salt()
    path.write_bytes(json_bytes({"salt": salt, "truth": truth}))
    return commitment(salt, truth)


def write_index(cases: Path, sealed: Path, entries: Iterable[Entry], order: Mapping[str, Any]) -> None:
    """Write what the folder of the cases says about itself, and the seal that binds the truths to it.

    Every file and folder gets one time stamp. order: what was asked for, the seed among it.
    """
    salt, about = new_salt(), {"order": order, "versions": current_versions()}
    listed = [vars(entry) for entry in entries]
    said = {"vehicles": True} if order.get("vehicles") else {}
    index = json_bytes({"schema": SCHEMA, "cases": listed, "order": commitment(salt, about), **said})
    (cases / INDEX).write_bytes(index)
    seal = {"schema": SEAL_SCHEMA, "index": sha256(index), "salt": salt, **about}
    (sealed / SEAL).write_bytes(json_bytes(seal))
    for folder in (cases, sealed):
        for path in [*sorted(folder.rglob("*"), reverse=True), folder]:
            os.utime(path, (EPOCH_S, EPOCH_S))


def read_index(folder: Path) -> Index:
    """The index of DIR; InputError where there is none."""
    path = folder / INDEX
    content = read_json(path, SCHEMA)
    try:
        entries, order = tuple(_entry(case) for case in content["cases"]), content["order"]
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: not an index of schema {SCHEMA} ({error})") from None
    names = [entry.case for entry in entries]
    if not names or len(set(names)) != len(names) or not isinstance(order, str):
        raise InputError(f"{path}: expected cases, each of them once, and the commitment to their order")
    return Index(entries, order, sha256(read_bytes(path)), content.get("vehicles") is True)


def read_seal(truth: Path, index: Index) -> tuple[dict[str, Any], list[str]]:
    """The seal in the folder of the truth, and what is wrong with it; InputError where there is none."""
    path = truth / SEAL
    seal, faults = read_json(path, SEAL_SCHEMA), []
    if seal.get("index") != index.sha256:
        faults.append(f"{path}: made for other cases, or cases.json was changed")
    elif commitment(seal.get("salt"), {key: seal.get(key) for key in ("order", "versions")}) != index.order:
        faults.append(f"{path}: seed, order or versions are not those that were sealed")
    return seal, faults


def is_name(name: Any) -> bool:
    """Whether it is the name of a file or folder here, and leads to no other place."""
    return isinstance(name, str) and name not in ("", "..") and Path(name).name == name


def _entry(case: dict[str, Any]) -> Entry:
    """A case of the index; ValueError for names that lead out of its folder or are no names."""
    runs, withheld = dict(case["runs"]), tuple(case["withheld"])
    for name in (case["case"], case["nominal"], *runs):
        if not is_name(name):
            raise ValueError(f"found {name!r}, expected the name of a case or of a run")
    if not all(isinstance(text, str) for text in (*runs.values(), *withheld, case["commitment"])):
        raise ValueError("expected hashes and names of effects as texts")
    return Entry(case["case"], case["nominal"], runs, withheld, case["commitment"])


def ended(cases: Path, sealed: Path, order: Mapping[str, Any]) -> bool:
    """Whether the truths of this order are in place and its cases stood ready beside theirs, where they are put now."""
    path, done = resolved(cases), False
    for ready in (left / NEW for left in left_rooms(path)):
        if not path.exists() and (ready / INDEX).is_file() and (sealed / SEAL).is_file():
            seal, faults = read_seal(sealed, read_index(ready))
            if not faults and canonical(seal["order"]) == canonical(order):
                ready.rename(path)
                done = True
    if path.exists():
        clear_rooms(path)
        clear_rooms(resolved(sealed))
    return done
