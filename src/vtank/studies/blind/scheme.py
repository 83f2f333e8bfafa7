"""What the score of one sort of trials consists of; everything else is the same for all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .measures import Measure
from .verify import Opened


@dataclass(frozen=True)
class Scheme:
    """How the cases of one sort of trials are scored.

    Attributes:
        row: (opened, folder of the truths, case) -> its row.
        groups: what the cases are grouped by. measures: of some rows, by name; bars: of these, in words.
        rules: how to read the tables. csv: one line per case. draw: figures, name -> caption and PNG.
    """

    row: Callable[[Opened, Path, str], Any]
    groups: Mapping[str, Callable[[Any], str]]
    measures: Callable[[Sequence[Any]], dict[str, Measure]]
    bars: Mapping[str, str]
    rules: str
    csv: Callable[[Sequence[Any]], str]
    draw: Callable[[Sequence[Any]], dict[str, tuple[str, bytes]]]
