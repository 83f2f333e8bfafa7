"""What is checked of the arguments before any work."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import InputError
from ..record.files import resolved

# Most that an option may ask for, against slips of the keyboard, which would fill the memory; choices
MOST = {
    "threads": 1024,
    "processes": 1024,
    "local_cluster": 1024,
    "trials": 100_000,
    "seeds": 1_000_000,
    "monte_carlo": 1_000_000,
}


def at_least(least: int, **arguments: int | None) -> None:
    """InputError for a whole number below `least`, or above MOST; None is one that was not given."""
    for name, value in arguments.items():
        most = MOST.get(name, value)
        if value is not None and most is not None and not least <= value <= most:
            expected = f"of at least {least}" if value < least else f"up to {most}"
            raise InputError(f"--{name.replace('_', '-')} {value}: expected a whole number {expected}")


def refuse_unwritable(*paths: Path | None) -> None:
    """InputError where a file could not be written, or two are one; None is one that was not asked for."""
    named = [path for path in paths if path is not None]
    for number, path in enumerate(named):
        if resolved(path) in [resolved(other) for other in named[:number]]:
            raise InputError(f"{path}: named twice, expected files of their own")
        parent = next(folder for folder in resolved(path).parents if folder.exists())
        if path.is_dir() or not parent.is_dir() or not os.access(parent, os.W_OK):
            raise InputError(f"{path}: cannot be written, expected the path of a file")
