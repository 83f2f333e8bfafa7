"""A user's MJCF read with MuJoCo's own reader: what cannot be read, or would take minutes, is an InputError."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from ..errors import InputError
from ..plant.vehicle import Vehicle
from ..record.files import check_file, is_file, read_text
from ..record.toml import no_file

USER = ("body", "jnt", "geom", "site", "cam", "tendon", "actuator", "sensor")
SIZES = (  # element, its attributes, and how much their product may be; choices
    ("texture", ("width", "height"), 2**24),
    ("hfield", ("nrow", "ncol"), 2**24),
    *(("size", (name,), 2**14) for name in ("nkey", "nuserdata", *(f"nuser_{kind}" for kind in USER))),
)
FOLDERS = ("meshdir", "texturedir", "assetdir")
DIGITS = 20  # of a whole number, beyond which MuJoCo refuses it
MOST_ELEMENTS = 5000  # copies included; MuJoCo's time grows with their square, 3 s for this many bodies

JOINED = ("Attach", "Child model")  # warnings of two models made one, whose options and names the tank sets itself


def read(path: Path) -> mujoco.MjSpec:
    """The specification in an MJCF file; InputError names the file."""
    if not is_file(path):
        raise InputError(f"{path}: no such MJCF file")
    read_text(path)
    with named(path):
        check_size(path)
        with mujoco_says("cannot read it"):
            return mujoco.MjSpec.from_file(str(path))


def read_hull(vehicle: Vehicle) -> mujoco.MjSpec:
    """The specification of a vehicle's rigid body; InputError names the vehicle's file where it is not there."""
    if not is_file(vehicle.mjcf):
        raise InputError(f"{vehicle.path}: mjcf: {no_file(vehicle.mjcf)}")
    return read(vehicle.mjcf)


def check_size(path: Path) -> None:
    """Raise InputError where the file, with what it includes and replicates, has more than MOST_ELEMENTS.

    And where one of them asks for more than SIZES, or names what is no file to read.
    """
    total, elements, waiting = 0, [], [(element, 1) for element in _root(path)]
    while waiting:
        element, copies = waiting.pop()
        copies *= _product(element, ("count",))
        total += copies
        if total > MOST_ELEMENTS:
            raise InputError(f"more than {MOST_ELEMENTS} elements, copies by 'count' included: too many for a tank")
        elements.append(element)
        inside = _root(path.parent / element.get("file", "")) if element.tag == "include" else list(element)
        waiting += [(child, copies) for child in inside]
    for tag, names, most in SIZES:
        if any(element.tag == tag and _product(element, names) > most for element in elements):
            raise InputError(f"<{tag}>: expected {' times '.join(names)} up to {most}, found more")
    folders = {element.get(key, "") for element in elements for key in FOLDERS}
    for name in {name for element in elements if (name := element.get("file"))}:
        for place in (path.parent / folder / name for folder in folders):
            if place.exists():
                check_file(place)


def _root(path: Path) -> list[ElementTree.Element]:
    """The elements of a file; none where MuJoCo will say better what is wrong with it."""
    if not is_file(path):
        return []
    try:
        return list(ElementTree.fromstring(read_text(path)))
    except (ElementTree.ParseError, ValueError):
        return []


def _product(element: ElementTree.Element, names: Sequence[str]) -> int:
    """Of all whole numbers in some attributes: `count` is one number or a grid of them."""
    numbers = [number for name in names for number in element.get(name, "1").split()]
    return math.prod(map(int, numbers)) if all(n.isdecimal() and len(n) < DIGITS for n in numbers) else 1


@contextmanager
def named(path: Path) -> Iterator[None]:
    """Put the file before the message of an InputError."""
    try:
        yield
    except InputError as reason:
        raise InputError(f"{path}: {reason}") from None


@contextmanager
def mujoco_says(what: str) -> Iterator[None]:
    """Turn MuJoCo's complaint into an InputError, and what it warns of, on the console and in a log, into warnings."""
    said: list[str] = []
    kept = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            yield
    except (ValueError, RuntimeError, MemoryError, mujoco.FatalError) as reason:
        raise InputError(f"MuJoCo {what}: {' '.join(str(reason).split())}") from None
    finally:
        mujoco.set_mju_user_warning(kept)
    for text in dict.fromkeys([*said, *(str(one.message) for one in found)]):
        if not text.startswith(JOINED):
            warnings.warn(f"MuJoCo warns: {' '.join(text.split())}", stacklevel=4)
