"""What is checked of the arguments before any work."""

from __future__ import annotations

import argparse
import os
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..record.files import is_file, read_text, resolved

# Most that an option may ask for, against slips of the keyboard, which would fill the memory; choices
MOST = {
    "threads": 1024,
    "processes": 1024,
    "local_cluster": 1024,
    "trials": 100_000,
    "seeds": 1_000_000,
    "monte_carlo": 1_000_000,
}
# What may lie in a folder of recordings without being one of its inputs: what commands write, but for what these read
WRITTEN = (".json", ".html", ".toml", ".mp4", ".md", ".png")
READ = ("manifest.json", "truth.json", "cases.json", "seal.json", "campaign.json")


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


def check_outputs(args: argparse.Namespace, *outputs: str) -> None:
    """InputError where an option's file or folder would take the place of what is read, through links too.

    outputs: names of the options; every path among all other arguments is read.
    """
    written = [path for name in outputs for path in _listed(getattr(args, name)) if isinstance(path, Path)]
    given = [value for name, values in vars(args).items() if name not in outputs for value in _listed(values)]
    for out in filter(Path.exists, written):
        for read in _named(given):
            if os.path.samefile(out, read) or out.is_dir() and resolved(out) in resolved(read).parents:
                raise InputError(f"{out}: is or holds the input {read}, which would be lost; expected another path")
        for read in _inside(given):
            if out.is_file() and os.path.samefile(out, read):
                raise InputError(f"{out}: is the input {read}, which would be overwritten; expected another path")


def _listed(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list | tuple) else [value]


def _named(given: Iterable[Any]) -> Iterator[Path]:
    """Files that arguments name, also as KEY=FILE, folders that are paths, and what TOML files name in their turn."""
    for value in given:
        path = Path(value.rpartition("=")[2]) if isinstance(value, str) else value
        if isinstance(path, Path) and (is_file(path) or isinstance(value, Path) and path.is_dir()):
            yield path
            yield from _named_in(path)


def _inside(given: Iterable[Any]) -> Iterator[Path]:
    """Files in the folders that arguments are: recordings and what belongs to them."""
    for folder in given:
        if isinstance(folder, Path) and folder.is_dir():
            files = filter(is_file, chain(folder.glob("*"), folder.glob("*/*")))
            yield from (file for file in files if file.suffix not in WRITTEN or file.name in READ)


def _named_in(path: Path, deep: int = 3) -> Iterator[Path]:
    """Files that a TOML file names, found beside it, and those that they name."""
    if path.suffix != ".toml" or deep == 0:
        return
    try:
        texts = _texts(tomllib.loads(read_text(path)))
    except (InputError, tomllib.TOMLDecodeError, RecursionError):
        return  # whoever reads it will say so
    for text in filter(None, texts):
        if is_file(named := path.parent / text):
            yield named
            yield from _named_in(named, deep - 1)


def _texts(content: Any) -> list[str]:
    """All texts in what a TOML file holds."""
    parts = list(content.values()) if isinstance(content, Mapping) else content if isinstance(content, list) else []
    return [content] if isinstance(content, str) else [text for part in parts for text in _texts(part)]
