"""A step of the story, the same on the terminal and on the start page."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from ...present import Block
from ..stage import Shares


@dataclass(frozen=True)
class Step:
    """What was done and found.

    Attributes:
        title, text: for terminal and page; the text is a sentence or three with the figures and their units.
        blocks: for the page alone.
        card: (what, answer, detail) among the answers at the head of the page; empty for none.
    """

    title: str
    text: str
    blocks: tuple[Block, ...] = ()
    card: tuple[str, str, str] | tuple[()] = ()


@dataclass(frozen=True)
class Act:
    """Where an act writes, what it is drawn from, and whom it tells how far its long parts are.

    Attributes:
        folder: exists, and holds nothing that the act writes.
        seed: of cause, sizes and all noise.
        shares: label -> report(share done, 0 to 1).
        stages: () -> say(what is being done).
    """

    folder: Path
    seed: int
    shares: Shares
    stages: Callable[[], AbstractContextManager[Callable[[str], None]]]
