"""Progress of long work on stderr: counts and time left on a terminal, an occasional line elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from shutil import get_terminal_size
from threading import RLock
from typing import Any, Self, TextIO

from .shown import one_line

INTERVAL_S = 10.0  # [s] between lines where stderr is not a terminal; a choice
COUNTED = "{desc} {n_fmt}/{total_fmt} |{bar:20}| {elapsed}, {remaining} left{postfix}"
NAMED = "{desc} ... {elapsed}"


class progress:
    """Call it after each of `total` pieces of work; without a total, before each, with what comes next.

    with progress("simulating", len(runs)) as advance:
        for run in runs: ...; advance(run.name)
    with progress() as say:
        say("where the gap lies"); ...
    """

    def __init__(self, label: str = "", total: int | None = None, stream: TextIO | None = None) -> None:
        from tqdm import tqdm

        tqdm.monitor_interval = 0  # no thread beside work that may start processes
        tqdm.set_lock(RLock())
        self.label, self.total, self.done, self.before, self.start = label, total, 0, 0, time.monotonic()
        self.next_line, self.stream = self.start + INTERVAL_S, sys.stderr if stream is None else stream
        self.bar: Any = tqdm(
            desc=label,
            total=total,
            file=self.stream,
            leave=total is not None,
            disable=not self.stream.isatty(),
            bar_format=NAMED if total is None else COUNTED,
            ncols=get_terminal_size().columns,
            nrows=get_terminal_size().lines,  # tqdm shows nothing where a terminal does not tell its own
        )

    def __call__(self, note: str = "", count: int = 1) -> None:
        """Count, several at once where they were done together, and show the note."""
        self.done, note = self.done + count, one_line(note)
        if self.bar.disable:
            self._line(note)
        elif self.total is None:
            self.bar.set_description_str(note)
        else:
            self.bar.set_postfix_str(note, refresh=False)
            self.bar.update(count)
        if self.done == self.total:
            self.bar.close()

    def done_before(self, count: int) -> None:
        """Count work of an earlier go, which tells nothing of the time left."""
        self.done = self.before = count
        self.bar.n = self.bar.initial = count

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.bar.close()

    def _line(self, note: str) -> None:
        now = time.monotonic()
        if self.total is None:
            self.stream.write(f"{note} ...\n")
        elif self.done == self.total or now >= self.next_line:
            text = f"{self.label} {self.done}/{self.total} {note}".rstrip()
            left = (now - self.start) / max(self.done - self.before, 1) * (self.total - self.done)
            self.stream.write(f"{text} ({now - self.start:.0f} s, {left:.0f} s left)\n")
            self.next_line = now + INTERVAL_S
        self.stream.flush()


@contextmanager
def percent(label: str, stream: TextIO | None = None) -> Iterator[Callable[[float], None]]:
    """Yield `report(share)`, to be called with the share of the work that is done, 0 to 1."""
    with progress(f"{label}, percent", 100, stream) as advance:

        def report(share: float) -> None:
            if (more := int(100.0 * share + 1e-9) - advance.done) > 0:
                advance(count=more)

        yield report


@contextmanager
def taken_up_later(where: str = "", what: str = "the same command") -> Iterator[None]:
    """Say that the same command goes on where the work within was interrupted."""
    try:
        yield
    except KeyboardInterrupt:
        print(f"\n{where}unfinished; {what} goes on from here", file=sys.stderr)
        raise
