"""Progress of long work: a counter rewritten in place on a terminal, an occasional line elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

INTERVAL_S = 10.0  # [s] between lines where stderr is not a terminal; a choice


@contextmanager
def progress(label: str, total: int, stream: TextIO | None = None) -> Iterator[Callable[[str], None]]:
    """Yield `advance(note)`, to be called after each of `total` pieces of work.

    with progress("simulating", len(runs)) as advance:
        for run in runs: ...; advance(run.name)
    """
    stream = sys.stderr if stream is None else stream
    counter = _Counter(label, total, stream)
    try:
        yield counter.advance
    finally:
        counter.close()


@contextmanager
def percent(label: str, stream: TextIO | None = None) -> Iterator[Callable[[float], None]]:
    """Yield `report(share)`, to be called with the share of the work that is done, 0 to 1."""
    with progress(f"{label}, percent", 100, stream) as advance:
        shown = 0

        def report(share: float) -> None:
            nonlocal shown
            while shown < int(100.0 * share + 1e-9):
                shown += 1
                advance("")

        yield report


class _Counter:
    def __init__(self, label: str, total: int, stream: TextIO) -> None:
        self.label, self.total, self.stream = label, total, stream
        self.done, self.width, self.start = 0, 0, time.monotonic()
        self.next_line = self.start + INTERVAL_S
        self._show("")

    def advance(self, note: str = "") -> None:
        self.done += 1
        self._show(note)

    def close(self) -> None:
        if self.stream.isatty():
            self.stream.write("\n")
            self.stream.flush()

    def _show(self, note: str) -> None:
        text = f"{self.label} {self.done}/{self.total} {note}".rstrip()
        if self.stream.isatty():
            self.stream.write("\r" + text.ljust(self.width))
            self.width = len(text)
        elif self._line_is_due():
            self.stream.write(f"{text} ({time.monotonic() - self.start:.0f} s)\n")
        self.stream.flush()

    def _line_is_due(self) -> bool:
        now = time.monotonic()
        due = self.done >= self.total or now >= self.next_line
        if due:
            self.next_line = now + INTERVAL_S
        return due
