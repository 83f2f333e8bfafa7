"""Data sets: folders of runs, with a manifest where vtank wrote them, and the truth in a file of its own."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import InputError
from .documents import json_text, read_json
from .files import run_name, unread
from .folder import Kind, new_folder, refuse_loss
from .manifest import (
    FILE,
    SCHEMA,
    DataSetWarning,
    Entry,
    Manifest,
    manifest_text,
    read_manifest,
    sha256,
    warn_of_changes,
)
from .reader import read_run
from .run import Run
from .writer import DECIMALS, run_bytes

TRUTH_FILE = "truth.json"
TRUTH_SCHEMA = "vtank.truth/1"
DATA_SET = Kind("a data set", FILE, SCHEMA, lambda marker: [TRUTH_FILE, *(run["file"] for run in marker["runs"])])
CAMPAIGN, CAMPAIGN_RUNS, JOURNAL = "campaign.json", "data", "journal"  # in the folder of a campaign (studies/campaign)
LONGEST_HEADER = 10_000  # bytes of a header that are looked at; a choice


@dataclass(frozen=True, eq=False)
class DataSet:
    """Runs in natural order of their names (run_2 before run_10); `manifest` is None for foreign recordings."""

    path: Path
    runs: tuple[Run, ...]
    manifest: Manifest | None = None

    def __repr__(self) -> str:
        """Folder and runs."""
        return f"DataSet({str(self.path)!r}, {len(self)} runs: {', '.join(run.name for run in self)})"

    def __iter__(self) -> Iterator[Run]:
        """The runs in order."""
        return iter(self.runs)

    def __len__(self) -> int:
        """Number of runs."""
        return len(self.runs)


def read_dataset(path: Path | str) -> DataSet:
    """The data set in a folder, the runs of a campaign in the campaign's folder, or one CSV file as a data set.

    Never opens the truth. InputError where a run or the manifest cannot be used; DataSetWarning for a run that is
    not as the manifest says, and for a thruster's bench table among the runs, which is none.
    """
    path = Path(path)
    if not path.is_dir():
        return DataSet(path, (read_run(path),))
    if (path / JOURNAL / CAMPAIGN).is_file():
        raise InputError(f"{path}: a campaign that is not finished; vtank campaign goes on with it")
    if (path / CAMPAIGN).is_file():
        path = path / CAMPAIGN_RUNS
        if not path.is_dir():
            raise InputError(f"{path.parent}: a campaign without CSV runs; fly it with --format csv")
    files = sorted((f for f in _files(path) if f.lower().endswith(".csv")), key=natural_order)
    tables = [file for file in files if _is_bench_table(path / file)]
    for file in tables:
        warnings.warn(f"{path / file}: a thruster's bench table, no run", DataSetWarning, stacklevel=2)
    files = [file for file in files if file not in tables]
    if not files:
        raise InputError(f"{path}: no runs here, expected *.csv")
    runs = tuple(read_run(path / file) for file in files)
    manifest = read_manifest(path / FILE) if (path / FILE).exists() else None
    if manifest:
        warn_of_changes(path, manifest, files)
    return DataSet(path, runs, manifest)


def write_dataset(
    path: Path | str,
    runs: Sequence[Run],
    manifest: Manifest,
    truth: Mapping[str, Any] | None = None,
    decimals: int = DECIMALS,
) -> None:
    """Write runs, manifest and, if given, truth into a folder that appears whole or not at all.

    An existing data set is replaced. InputError for a folder that holds anything else, for two runs of one name and
    for a run that breaks the rules. The manifest's list of runs is made here.
    """
    path = Path(path)
    names = [run.name for run in runs]
    for name in names:
        run_name(Path(f"{name}.csv"))
    if not names or len(set(names)) != len(names):
        raise InputError(f"{path}: expected runs with different names, found {', '.join(names) or 'none'}")
    with new_folder(path, DATA_SET) as folder:
        entries = [_write(folder, run, decimals) for run in sorted(runs, key=lambda run: natural_order(run.name))]
        (folder / FILE).write_text(manifest_text(replace(manifest, runs=tuple(entries))), encoding="utf-8")
        if truth is not None:
            (folder / TRUTH_FILE).write_text(json_text({"schema": TRUTH_SCHEMA, **truth}), encoding="utf-8")


def refuse_strangers(path: Path | str) -> None:
    """InputError unless `path` is free, empty, or holds nothing but a data set that vtank wrote."""
    refuse_loss(path, DATA_SET)


def read_truth(path: Path | str) -> dict[str, Any] | None:
    """The truth beside a data set or a run, None where it is withheld; or the truth in a *.json file."""
    path = Path(path)
    if path.suffix == ".json":
        return read_json(path, TRUTH_SCHEMA)
    file = (path if path.is_dir() else path.parent) / TRUTH_FILE
    return read_json(file, TRUTH_SCHEMA) if file.exists() else None


def natural_order(name: str) -> tuple[list[str | int], str]:
    """Sort key that takes digits as numbers."""
    parts = re.split(r"([0-9]+)", name)  # text and digits in turn
    return [int(part) if k % 2 else part for k, part in enumerate(parts)], name


def _write(folder: Path, run: Run, decimals: int) -> Entry:
    data = run_bytes(run, decimals)
    file = f"{run.name}.csv"
    (folder / file).write_bytes(data)
    return Entry(file, sha256(data), run.time_s.size)


def _is_bench_table(file: Path) -> bool:
    """Whether a CSV file has the header of a vehicle's thrust curve: forces over an input, without times."""
    try:
        with file.open("rb") as lines:
            names = lines.readline(LONGEST_HEADER).decode("utf-8", "replace").replace(" ", "").strip().split(",")
    except OSError:  # what cannot be read is told of where it is read as a run
        return False
    return len(names) == 2 and names[1] == "force_N"


def _files(folder: Path) -> list[str]:
    try:
        return [entry.name for entry in folder.iterdir() if not entry.name.startswith(".")]
    except OSError as error:
        raise unread(folder, error) from None
