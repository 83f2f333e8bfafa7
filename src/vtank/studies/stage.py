"""How a study tells what it is doing: a stage of so many pieces of work, and a note after each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

Stage = Callable[[str, int], AbstractContextManager[Callable[[str], None]]]  # label, number of pieces -> advance(note)


@contextmanager
def silent(label: str, total: int) -> Iterator[Callable[[str], None]]:
    """A stage that shows nothing."""
    yield lambda note: None
