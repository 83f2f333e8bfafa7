"""What is being done, told in words: a line rewritten on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

CLEAR = "\r\x1b[K"  # back to the start of the terminal's line, and wipe it


@contextmanager
def stages() -> Iterator[Callable[[str], None]]:
    """Yield `say(text)`, which tells on stderr what is being done."""
    terminal = sys.stderr.isatty()

    def say(text: str) -> None:
        start, end = (CLEAR, "") if terminal else ("", "\n")
        print(f"{start}{text} ...", end=end, file=sys.stderr, flush=True)

    try:
        yield say
    finally:
        if terminal:
            print(CLEAR, end="", file=sys.stderr, flush=True)
