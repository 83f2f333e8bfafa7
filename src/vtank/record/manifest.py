"""The manifest of a data set: where its runs come from, and their hashes.

It holds no times and no paths: the same work gives the same bytes.
"""

from __future__ import annotations

import hashlib
import json
import platform
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from .. import __version__
from ..errors import InputError

FILE = "manifest.json"
SCHEMA = "vtank.manifest/1"


class DataSetWarning(UserWarning):
    """A data set can be used, but it is not as it was written."""


@dataclass(frozen=True)
class Entry:
    """One run as it was written: file name, SHA-256 of the file in hex, number of rows."""

    file: str
    sha256: str
    rows: int


def current_versions() -> dict[str, str]:
    """Versions of everything that decides the numbers, without loading any of it."""
    found = {"vtank": __version__, "python": platform.python_version()}
    for package in ("mujoco", "numpy", "numba", "scipy"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "absent"
    return found


@dataclass(frozen=True)
class Manifest:
    """Where a data set comes from.

    scenarios   name -> text of the scenario's file
    seed        the one seed of all random streams; None where nothing was drawn
    versions    package -> version
    runs        filled in when the data set is written
    """

    scenarios: Mapping[str, str] = field(default_factory=dict)
    seed: int | None = None
    versions: Mapping[str, str] = field(default_factory=current_versions)
    runs: tuple[Entry, ...] = ()


def manifest_text(manifest: Manifest) -> str:
    """The manifest as JSON."""
    content = {
        "schema": SCHEMA,
        "seed": manifest.seed,
        "versions": dict(manifest.versions),
        "scenarios": [{"name": name, "text": text} for name, text in manifest.scenarios.items()],
        "runs": [vars(entry) for entry in manifest.runs],
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def read_manifest(path: Path) -> Manifest:
    """The manifest in a file; InputError where it is not one."""
    content = read_json(path, SCHEMA)
    try:
        return Manifest(
            scenarios={str(item["name"]): str(item["text"]) for item in content["scenarios"]},
            seed=content["seed"],
            versions=dict(content["versions"]),
            runs=tuple(Entry(str(run["file"]), str(run["sha256"]), int(run["rows"])) for run in content["runs"]),
        )
    except KeyError as error:
        raise InputError(f"{path}: no key {error}, expected a manifest of schema {SCHEMA}") from None
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: not a manifest of schema {SCHEMA} ({error})") from None


def read_json(path: Path, schema: str) -> dict[str, Any]:
    """A JSON object that names its schema; InputError for anything else."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{path}, line {error.lineno}: not JSON ({error.msg})") from None
    found = content.get("schema") if isinstance(content, dict) else None
    if found != schema:
        raise InputError(f"{path}: found schema {found!r}, expected {schema!r}")
    return dict(content)


def sha256(data: bytes) -> str:
    """SHA-256 in hex."""
    return hashlib.sha256(data).hexdigest()


def warn_of_changes(folder: Path, manifest: Manifest, files: list[str]) -> None:
    """Say with a DataSetWarning which runs are not as the manifest says: changed, gone or added since."""
    listed = {entry.file: entry.sha256 for entry in manifest.runs}
    for file in files:
        if file not in listed:
            _warn(f"{folder / file}: not in the manifest, added since the data set was written")
        elif sha256((folder / file).read_bytes()) != listed[file]:
            _warn(f"{folder / file}: changed since the data set was written")
    for file in listed.keys() - set(files):
        _warn(f"{folder / file}: in the manifest but not here")


def _warn(message: str) -> None:
    warnings.warn(message, DataSetWarning, stacklevel=4)
