"""The manifest of a data set: where its runs come from, and their hashes.

It holds no times and no paths: the same work gives the same bytes. Nor does it tell anything of the truth, which is
withheld with truth.json: no effect, no truth preset, no noise, nor the seed with which the noise can be made again.
"""

from __future__ import annotations

import hashlib
import platform
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from .. import __version__
from ..errors import InputError
from .documents import json_text, read_json
from .files import read_bytes

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

    scenarios   name -> what is known of a run before its truth: the test card, as TOML
    seed        of older data sets; None in those written today, whose noise is part of the truth
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
    return json_text(content)


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
    except (AttributeError, TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{path}: not a manifest of schema {SCHEMA} ({error})") from None


def sha256(data: bytes) -> str:
    """SHA-256 in hex."""
    return hashlib.sha256(data).hexdigest()


def warn_of_changes(folder: Path, manifest: Manifest, files: list[str]) -> None:
    """Say with a DataSetWarning which runs are not as the manifest says: changed, gone or added since."""
    listed = {entry.file: entry.sha256 for entry in manifest.runs}
    for file in files:
        if file not in listed:
            _warn(f"{folder / file}: not in the manifest, added since the data set was written")
        elif sha256(read_bytes(folder / file)) != listed[file]:
            _warn(f"{folder / file}: changed since the data set was written")
    for file in listed.keys() - set(files):
        _warn(f"{folder / file}: in the manifest but not here")


def _warn(message: str) -> None:
    warnings.warn(message, DataSetWarning, stacklevel=4)
