"""Effects from their files, whose faults are told by file and line: anybody may write one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pkgutil import iter_modules
from traceback import extract_tb
from typing import Any

from ..errors import InputError


def effects_in(package: str, folder: Iterable[str]) -> Iterator[tuple[str, Any]]:
    """File and effect of each module of a package that holds an EFFECT; InputError where one cannot be loaded."""
    for module in iter_modules(folder):
        name = f"{package}.{module.name}"
        spec = find_spec(name)
        file = str(spec.origin) if spec else name
        try:
            found = import_module(name)
        except InputError:
            raise
        except Exception as error:
            raise InputError(f"{_place(file, error)}: {type(error).__name__}: {error}") from error
        if hasattr(found, "EFFECT"):
            yield file, found.EFFECT


def _place(file: str, error: Exception) -> str:
    """File and line of the fault; the file alone where the fault came up elsewhere."""
    if isinstance(error, SyntaxError) and error.filename == file:
        return f"{file}:{error.lineno}"
    lines = [frame.lineno for frame in extract_tb(error.__traceback__) if frame.filename == file]
    return f"{file}:{lines[-1]}" if lines else file
