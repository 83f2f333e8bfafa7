"""A user's MJCF read with MuJoCo's own reader: what cannot be read, or would take minutes, is an InputError."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from ..errors import InputError
from ..record.files import is_file

MOST_ELEMENTS = 5000  # copies included; MuJoCo's time grows with their square, 3 s for this many bodies


def read(path: Path) -> mujoco.MjSpec:
    """The specification in an MJCF file; InputError names the file."""
    if not is_file(path):
        raise InputError(f"{path}: no such MJCF file")
    with named(path):
        check_size(path)
        with mujoco_says("cannot read it"):
            return mujoco.MjSpec.from_file(str(path))


def check_size(path: Path) -> None:
    """Raise InputError where the file, with what it includes and replicates, has more than MOST_ELEMENTS."""
    total, waiting = 0, [(element, 1) for element in _root(path)]
    while waiting:
        element, copies = waiting.pop()
        copies *= _count(element)
        total += copies
        if total > MOST_ELEMENTS:
            raise InputError(f"more than {MOST_ELEMENTS} elements, copies by 'count' included: too many for a tank")
        inside = _root(path.parent / element.get("file", "")) if element.tag == "include" else list(element)
        waiting += [(child, copies) for child in inside]


def _root(path: Path) -> list[ElementTree.Element]:
    """The elements of a file; none where MuJoCo will say better what is wrong with it."""
    try:
        return list(ElementTree.parse(path).getroot())
    except (OSError, ElementTree.ParseError):
        return []


def _count(element: ElementTree.Element) -> int:
    """Copies that an element asks for: `count`, one number or a grid of them."""
    numbers = element.get("count", "1").split()
    return math.prod(int(number) for number in numbers) if all(map(str.isdecimal, numbers)) else 1


@contextmanager
def named(path: Path) -> Iterator[None]:
    """Put the file before the message of an InputError."""
    try:
        yield
    except InputError as reason:
        raise InputError(f"{path}: {reason}") from None


@contextmanager
def mujoco_says(what: str) -> Iterator[None]:
    """Turn MuJoCo's complaint into an InputError; its warnings, bound for console and a log file, are dropped."""
    kept = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (ValueError, mujoco.FatalError) as reason:
        raise InputError(f"MuJoCo {what}: {' '.join(str(reason).split())}") from None
    finally:
        mujoco.set_mju_user_warning(kept)
