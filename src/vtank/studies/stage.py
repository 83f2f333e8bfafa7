"""How a study tells what it is doing: a stage of so many pieces of work, and a note after each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

Stage = Callable[[str, int], AbstractContextManager[Callable[[str], None]]]  # label, number of pieces -> advance(note)
Shares = Callable[[str], AbstractContextManager[Callable[[float], None]]]  # label -> report(share done, 0 to 1)


@contextmanager
def silent(label: str, total: int = 0) -> Iterator[Callable[[Any], None]]:
    """A stage that shows nothing."""
    yield lambda note: None
