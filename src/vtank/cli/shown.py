"""What is printed is safe for a terminal: names of files and headers may hold any character, escape sequences too."""

from __future__ import annotations

import re
from typing import Any, TextIO

CONTROL = r"\x00-\x08\x0b-\x1f\x7f-\x9f"


def one_line(text: str) -> str:
    """The text with control characters spelled, as \\x1b, line ends and tabs too."""
    return re.sub(rf"[{CONTROL}\n\t]", _spelled, text)


def _spelled(found: re.Match[str]) -> str:
    return repr(found[0])[1:-1]


class Shown:
    """A stream that spells control characters but for line ends and tabs; otherwise the stream that it is given."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        """Everything else is the stream's."""
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write it; how many characters it had."""
        self._stream.write(re.sub(f"[{CONTROL}]", _spelled, text))
        return len(text)
