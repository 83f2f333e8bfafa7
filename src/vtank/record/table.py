"""A table of a TOML file, read key by key, whose complaints name the file, the line and the key.

A key that nobody reads is refused: with the right unit where only the unit differs, with the nearest known key where it
looks misspelt. A number stands bare (`mass_kg = 11.5`) or with its origin
(`mass_kg = { value = 197.313, imperial = "13.520 slug", source = "S1", confidence = "H", note = "..." }`).
"""

from __future__ import annotations

import difflib
import os
import re
import sys
import textwrap
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import InputError
from .files import read_text
from .suffix import in_unit, split_unit, wrong_unit
from .toml import LONGEST, find_file, line_of, meant, nearest, override, parse, shown

LARGEST = 100.0  # of listed amplitudes [m, rev/s] and frequencies [rad/s], against slips of the keyboard; a choice
GREATEST = 1e12  # of any number: no mass, inertia, force or gain of a vehicle is larger in SI or feet; a guess
NAME = re.compile(r"[^\s,;.\"']+")  # that columns of a table may begin with
NO_NAME = "expected a name without blank, comma, semicolon, dot or quote: columns begin with it"
ORIGIN = ("value", "imperial", "source", "confidence", "note")


@dataclass
class Table:
    """A TOML table; `known` collects the keys that were asked for, `close` refuses the others.

    Attributes:
        path: of the file, which need not exist.
        name: of the table, dotted; "" for the whole file.
        entries: key -> value.
        overridden: full keys that were set on the command line.
    """

    path: Path
    name: str
    entries: dict[str, Any]
    overridden: frozenset[str] = frozenset()
    known: set[str] = field(default_factory=set)

    def has(self, key: str) -> bool:
        """Whether the table has a key that need not be there."""
        self.known.add(key)
        return key in self.entries

    def number(self, key: str, default: float | None = None, low: float = -GREATEST, high: float = GREATEST) -> float:
        """A number within [low, high] [unit as in the key]."""
        value = self._value(key, default)
        if not _is_number(value):
            raise self.error(key, f"expected a number{in_unit(key)}, found {shown(value)}")
        if not low <= value <= high:
            raise self.error(key, f"expected {_between(low, high)}{in_unit(key)}, found {value:g}")
        return float(value)

    def positive(self, key: str, default: float | None = None, high: float = GREATEST) -> float:
        """A number above zero and not above `high`."""
        value = self.number(key, default, -float("inf"), float("inf"))
        if not 0.0 < value <= high:
            top = f" and up to {high:g}" if high < GREATEST or value > high else ""
            raise self.error(key, f"expected a number above 0{top}{in_unit(key)}, found {value:g}")
        return value

    def numbers(self, key: str, low: float = -LARGEST, high: float = LARGEST) -> tuple[float, ...]:
        """A list of numbers, each within [low, high]."""
        values = self._value(key, None)
        if not isinstance(values, list) or not values or not all(map(_is_number, values)):
            raise self.error(key, f"expected a list of numbers{in_unit(key)}, found {shown(values)}")
        for value in values:
            if not low <= value <= high:
                raise self.error(key, f"expected {_between(low, high)}{in_unit(key)}, found {value:g} among them")
        return tuple(map(float, values))

    def vector(self, key: str, most: float = GREATEST) -> tuple[float, float, float]:
        """Three numbers along three axes, each within -most..most."""
        values = self.numbers(key, -most, most)
        if len(values) != 3:
            raise self.error(key, f"expected three numbers [x, y, z], found {shown(list(values))}")
        return values[0], values[1], values[2]

    def integer(self, key: str, default: int, low: int = 0, high: int = 2**63 - 1) -> int:
        """A whole number within [low, high]."""
        value = self._value(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            top = f" and up to {high}" if isinstance(value, int) and value > high else ""
            raise self.error(key, f"expected a whole number of at least {low}{top}, found {shown(value)}")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """A text."""
        value = self._value(key, default)
        if not isinstance(value, str) or "\0" in value:
            raise self.error(key, f"expected a text in quotes, found {shown(value)}")
        return value

    def name_of(self, key: str, default: str | None = None) -> str:
        """A text that columns of a recording may begin with."""
        name = self.text(key, default)
        if name and not NAME.fullmatch(name):
            raise self.error(key, f"{NO_NAME}, found {shown(name)}")
        return name

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts."""
        values = self._value(key, None)
        if not (isinstance(values, list) and values and all(isinstance(value, str) for value in values)):
            raise self.error(key, f"expected a list of texts in quotes, found {shown(values)}")
        return tuple(values)

    def choice(self, key: str, choices: tuple[str, ...], default: str | None = None) -> str:
        """One of the words that are understood."""
        value = self.text(key, default)
        if value not in choices:
            slip = f", did you mean '{near}'?" if (near := nearest(value, choices)) else ""
            raise self.error(key, f"expected one of {', '.join(choices)}; found {shown(value)}{slip}")
        return value

    def file(
        self, key: str, default: str | None = None, ending: str = ".toml", presets: tuple[Path, str] | None = None
    ) -> str:
        """The name of a preset, or the path of a file: beside this one, or where vtank runs if set there.

        presets: where they lie and what they are called, if a name must be one of them.
        """
        value = self.text(key, default)
        if not value.endswith(ending):
            try:
                if presets:
                    find_file(value, *presets)
            except InputError as reason:
                raise self.error(key, str(reason)) from None
            return value
        return os.path.abspath(value if self._full(key) in self.overridden else self.path.parent / value)

    def either(self, *keys: str) -> str:
        """The one of these keys that the table has; InputError where it has none or several."""
        self.known.update(keys)
        given = [key for key in keys if key in self.entries]
        if not given:
            self._look_for_other_units(keys[0])
        if len(given) != 1:
            raise self.error(keys[0], f"expected exactly one of {', '.join(keys)}; found {', '.join(given) or 'none'}")
        return given[0]

    def table(self, key: str) -> Table:
        """A table within this one, empty where the file has none."""
        return self._within(key, self.entries[key] if self.has(key) else {})

    def tables(self, key: str) -> tuple[Table, ...]:
        """An array of tables, empty where the file has none."""
        entries = self.entries[key] if self.has(key) else []
        if not isinstance(entries, list):
            raise self.error(key, f"expected an array of tables, [[{key}]]")
        return tuple(self._within(f"{key}[{index}]", entry) for index, entry in enumerate(entries))

    def check_keys(self, known: Iterable[str]) -> Table:
        """Refuse all other keys than these at once; returns the table."""
        self.known.update(known)
        self.close()
        return self

    def close(self) -> None:
        """Refuse the keys that nobody asked for: a misspelt one would otherwise be passed over in silence."""
        for key in self.entries:
            if key not in self.known:
                raise self.error(key, self._unknown(key))

    def error(self, key: str, message: str) -> InputError:
        """An InputError that names file, line and key, or the command line where the value was set there."""
        full = self._full(key)
        if full in self.overridden:
            return InputError(f"--set {full} (over {self.path}): {message}")
        line = line_of(self.path, self.name, key)
        if not line and (setting := self._setting_of(full)):
            return InputError(f"--set {setting} (over {self.path}): {full}: {message}")
        full = textwrap.shorten(full, LONGEST, placeholder="...")
        return InputError(f"{self.path}{f':{line}' if line else ''}: {full}: {message}")

    def _setting_of(self, full: str) -> str:
        """The setting that made a key of which the file has none, or its table; "" for none."""
        made = [f"{full}."] if line_of(self.path, "", self.name) or not self.name else [f"{full}.", f"{self.name}."]
        return next((setting for setting in sorted(self.overridden) if setting.startswith(tuple(made))), "")

    def _within(self, key: str, entries: Any) -> Table:
        if not isinstance(entries, dict):
            raise self.error(key, f"expected a table [{self._full(key)}], found {shown(entries)}")
        return Table(self.path, self._full(key), entries, self.overridden)

    def _full(self, key: str) -> str:
        return f"{self.name}.{key}" if self.name else key

    def _value(self, key: str, default: Any) -> Any:
        self.known.add(key)
        value = self.entries.get(key, default)
        if isinstance(value, dict):
            value = self._within(key, value).check_keys(ORIGIN).entries.get("value")
        if value is None:
            self._look_for_other_units(key)
            unread = [found for found in self.entries if found not in self.known]
            near = difflib.get_close_matches(key, unread, 1, 0.8)
            slip = f"; is '{near[0]}' meant to be it?" if near else ""
            raise self.error(key, f"missing; expected a value{in_unit(key)}{slip}")
        return value

    def _look_for_other_units(self, key: str) -> None:
        for found in self.entries:
            if found not in self.known and split_unit(found)[0] == split_unit(key)[0]:
                raise self.error(found, wrong_unit(found, key))

    def _unknown(self, key: str) -> str:
        for known in sorted(self.known):
            if split_unit(known)[0] == split_unit(key)[0] and split_unit(known)[1]:
                return wrong_unit(key, known)
        return "unknown key" + meant(key, sorted(self.known))


def open_table(path: Path, settings: tuple[str, ...] = ()) -> Table:
    """The whole TOML file, with `key.key=value` settings of the command line laid over it."""
    return table_of(read_text(path), path, settings)


def table_of(text: str, path: Path, settings: tuple[str, ...] = ()) -> Table:
    """A TOML text as the file at `path` would be, which need not be there; as `open_table`."""
    entries = parse(text, path)
    names = [override(entries, setting) for setting in settings]
    return Table(path, "", entries, frozenset(names))


def _is_number(value: Any) -> bool:
    """Whether it is a number that a computation can take; infinity is one, which bounds may refuse."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    return abs(value) <= sys.float_info.max or abs(value) == float("inf")


def _between(low: float, high: float) -> str:
    return f"at least {low:g}" if high == float("inf") else f"a number from {low:g} to {high:g}"
