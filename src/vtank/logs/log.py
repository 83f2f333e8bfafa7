"""What was read of a log: a stream for each message or topic, with the numbers that were wanted."""

from __future__ import annotations

import importlib
import math
import re
from array import array
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

REASON = 100  # characters of why something could not be decoded; a choice
NAMED = 12  # kinds of messages that could not be decoded, the most frequent, that are named; a choice
Wanted = Callable[[str, str], Sequence[str]]  # (message or topic, its type) -> fields to keep; none: only count


@dataclass
class Stream:
    """One message or topic: how often and when it came, and what was kept of it.

    Attributes:
        kind: type of the message, "" where the log has none.
        count, first_s, last_s: of all its messages [s], the clock of the log.
        time_s: stamps of the kept messages, shape (K,) [s].
        values: field -> numbers as they are in the log, shape (K,); NaN where a message has no such number.
        sample: the first message, to name its fields; None where nothing is kept.
        down: whether its axes have z down, by the name of its frame.
    """

    kind: str = ""
    count: int = 0
    first_s: float = math.inf
    last_s: float = -math.inf
    time_s: array[float] = field(default_factory=lambda: array("d"))
    values: dict[str, array[float]] = field(default_factory=dict)
    sample: Any = None
    down: bool = False

    @property
    def rate_hz(self) -> float:
        """Messages a second [Hz]; 0 where there are fewer than two stamps."""
        return (self.count - 1) / (self.last_s - self.first_s) if self.last_s > self.first_s else 0.0

    def tick(self, time_s: float) -> None:
        """Count a message."""
        self.count += 1
        self.first_s, self.last_s = min(self.first_s, time_s), max(self.last_s, time_s)

    def keep(self, time_s: float, message: Any) -> None:
        """Keep the wanted fields of a message that is counted already."""
        if self.sample is None:
            self.sample = message
        self.time_s.append(time_s)
        for name, values in self.values.items():
            values.append(number(message, name))

    def samples(self, name: str) -> NDArray[np.float64]:
        """The kept numbers of a field, shape (K,)."""
        return np.array(self.values[name])


@dataclass
class Log:
    """All that was read; readers fill it.

    Attributes:
        wanted: what to keep.
        kind: of the file, in words.
        streams: name of the message or topic -> what it held.
        parameters: of the vehicle, as the log tells them.
        undecoded: name of a message -> how many could not be decoded.
        why: name of a message -> why the first of them could not be decoded, where that is known.
        remarks: what the reader of the preview should know, in words.
    """

    wanted: Wanted
    kind: str = ""
    streams: dict[str, Stream] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=dict)
    undecoded: Counter[str] = field(default_factory=Counter)
    why: dict[str, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def stream(self, name: str, kind: str = "") -> Stream:
        """The stream of a name, new where it was not seen before."""
        if name not in self.streams:
            self.streams[name] = Stream(kind, values={key: array("d") for key in self.wanted(name, kind)})
        return self.streams[name]

    def learn(self, name: str, value: float) -> None:
        """Keep a parameter of the vehicle; one that is no finite number is counted and left out."""
        if math.isfinite(value):
            self.parameters[name] = value
        else:
            self.lose(f"parameter {name}", "no number")

    def lose(self, name: str, why: str = "") -> None:
        """Count a message that could not be decoded."""
        self.undecoded[name] += 1
        if why:
            self.why.setdefault(name, " ".join(why.split())[:REASON])

    def lost(self, before: str = "") -> str:
        """What could not be decoded, and why, in words behind `before`; "" where all could."""
        if not self.undecoded:
            return ""
        counts = ", ".join(
            f"{count} of {name}" + (f" ({self.why[name]})" if name in self.why else "")
            for name, count in self.undecoded.most_common(NAMED)
        )
        more = ", ..." * (len(self.undecoded) > NAMED)
        return f"{before}{sum(self.undecoded.values())} could not be decoded: {counts}{more}"

    def cut(self, what: str) -> None:
        """Say that the file ends too early."""
        self.remarks.append(f"the log is cut off: {what}; it is read as far as it goes")


@cache
def steps(field_name: str) -> tuple[str | int, ...]:
    """The way to a field: `rpm[2]` and `pose.position.x` as names and numbers in turn."""
    return tuple(int(index) if index else name for name, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", field_name))


def number(message: Any, name: str) -> float:
    """A field of a message as a number; NaN where it has none. A mapping may hold the field under its whole name."""
    try:
        if isinstance(message, dict) and name in message:
            return float(message[name])
        for step in steps(name):
            message = message[step] if isinstance(step, int) or isinstance(message, dict) else getattr(message, step)
        return float(message)
    except (AttributeError, LookupError, TypeError, ValueError, OverflowError):
        return math.nan


def field_names(message: Any, depth: int = 4) -> list[str]:
    """The fields of a message that hold something, those within others dotted."""
    own: dict[str, Any] = message if isinstance(message, dict) else dict(getattr(message, "__dict__", {}))
    if not isinstance(message, dict) and hasattr(message, "get_fieldnames"):
        own = {name: getattr(message, name) for name in message.get_fieldnames()}
    found = []
    for name, value in own.items():
        inside = field_names(value, depth - 1) if depth and not name.startswith("_") else []
        found += [f"{name}.{each}" for each in inside] or ([] if name.startswith("_") else [name])
    return found


def library(module: str, package: str, what: str) -> ModuleType:
    """A package of the extra `logs`, loaded now; InputError tells how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(f"{what} is read with {package}, which is not here; pip install 'vtank[logs]'") from None
