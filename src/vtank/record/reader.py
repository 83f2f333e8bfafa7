"""Read a run from CSV; what is wrong is told with file, line and column."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path

import numpy as np

from ..errors import InputError
from .contradictions import contradictions
from .doubts import doubts
from .files import read_text, stem
from .manifest import DataSetWarning
from .rules import content_fault, header_fault
from .run import TIME, FloatArray, Run

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_PLAIN = re.compile(r"[-+.0-9eE]*")  # what numbers are made of; float() also takes nan, inf, 1_000 and foreign digits
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}  # of other programs
HEADER_LINE = 1  # lines count from 1; row r of the data is line r + 2


def read_run(path: Path | str) -> Run:
    """The run in a CSV file; InputError says where it breaks the rules of a run, DataSetWarning what is doubted."""
    path = Path(path)
    text = read_text(path)
    if not text.strip():
        raise InputError(f"{path}: the file is empty, expected a header and rows of numbers")
    names, lines = _header_and_lines(path, text)
    fault = header_fault(names)
    if fault:
        raise InputError(f"{path}, line {HEADER_LINE}: {fault.message}")
    values = _values(path, names, lines)
    columns = dict(zip(names, np.ascontiguousarray(values.T), strict=True))
    run = Run(stem(path), columns.pop(TIME), columns)
    fault = content_fault(run)
    if fault:
        line = "" if fault.row is None else f", line {fault.row + 2}"
        raise InputError(f"{path}{line}: {fault.message}")
    for found in (*doubts(run), *contradictions(run)):
        warnings.warn(f"{path}: {found}", DataSetWarning, stacklevel=2)
    return run


def _header_and_lines(path: Path, text: str) -> tuple[list[str], list[str]]:
    """The column names and the lines below them, line ends and quotes removed."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").replace('"', "").rstrip("\n").split("\n")
    names = [name.strip() for name in lines[0].split(",")]
    other = next((word for mark, word in SEPARATORS.items() if mark in lines[0]), None)
    if other and len(names) == 1:
        raise InputError(f"{path}, line {HEADER_LINE}: cells separated by {other}, expected commas, and "
                         "decimal points; vtank import makes a run of any table")  # fmt: skip
    if any(_is_number(name) for name in names):
        raise InputError(f"{path}, line {HEADER_LINE}: expected a header with column names, found '{lines[0][:60]}'")
    return names, lines[1:]


def _values(path: Path, names: list[str], lines: list[str]) -> FloatArray:
    """All cells, shape (T, columns), NaN where empty. The search for the place of a fault runs only if there is one."""
    if not lines:
        raise InputError(f"{path}: no rows below the header")
    commas = len(names) - 1
    for row, line in enumerate(lines):
        if line.count(",") != commas:
            raise InputError(f"{path}, line {row + 2}: {_wrong_length(names, lines, row)}")
    values, plain = np.empty((len(lines), len(names))), True
    for row, line in enumerate(lines):  # as text, the cells of all rows would take many times what their numbers do
        cells = [cell.strip() for cell in line.split(",")]
        try:
            values[row] = [float(cell) if cell else math.nan for cell in cells]
        except ValueError:
            raise InputError(_wrong_cell(path, names, lines)) from None
        plain = plain and _PLAIN.fullmatch("".join(cells)) is not None
    if not plain or np.isinf(values).any():
        raise InputError(_wrong_cell(path, names, lines))
    return values


def _wrong_length(names: list[str], lines: list[str], row: int) -> str:
    found, expected = lines[row].count(",") + 1, len(names)
    if not lines[row].strip():
        return "found an empty line, expected numbers"
    if row == len(lines) - 1 and found < expected:
        return f"the last line has {found} of {expected} cells: the file is truncated"
    return f"found {found} cells, expected {expected} as in the header"


def _wrong_cell(path: Path, names: list[str], lines: list[str]) -> str:
    """The message for the first cell that is neither empty nor a finite number."""
    cells = ((row, column, cell.strip()) for row, line in enumerate(lines)
             for column, cell in zip(names, line.split(","), strict=True))  # fmt: skip
    row, column, cell = next(found for found in cells if found[2] and not _is_number(found[2]))
    return f"{path}, line {row + 2}, column {column}: found '{cell[:40]}', expected a number or an empty cell"


def _is_number(cell: str) -> bool:
    return _NUMBER.fullmatch(cell) is not None and math.isfinite(float(cell))
