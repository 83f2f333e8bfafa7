"""A table of a scenario file, read key by key, whose complaints name the file, the line and the key.

Keys carry their unit as a suffix. A key that nobody reads is refused: with the right unit where only the unit differs,
with the nearest known key where it looks misspelt.
"""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import InputError
from .quantity import read_table

LARGEST = (
    100.0  # bound of listed amplitudes [m, rev/s] and frequencies [rad/s], against slips of the keyboard; a choice
)

# Unit suffixes in use, the longest first, so that "_m_s2" is not taken for "_s2"
UNITS = {
    "_m_per_rev2": "m/rev2",
    "_ft_per_rev2": "ft/rev2",
    "_m2_per_s5": "m2/s5",
    "_ft2_per_s5": "ft2/s5",
    "_per_rev": "1/rev",
    "_per_s2": "1/s2",
    "_per_s": "1/s",
    "_per_m": "1/m",
    "_rev_s": "rev/s",
    "_rad_s": "rad/s",
    "_ft_s2": "ft/s2",
    "_m_s2": "m/s2",
    "_deg_s": "deg/s",
    "_ft_s": "ft/s",
    "_m_s": "m/s",
    "_rpm": "rpm",
    "_ft2": "ft2",
    "_m2": "m2",
    "_rad": "rad",
    "_deg": "deg",
    "_min": "min",
    "_mm": "mm",
    "_cm": "cm",
    "_ft": "ft",
    "_in": "in",
    "_ms": "ms",
    "_hz": "Hz",
    "_N_m": "N m",
    "_N": "N",
    "_m": "m",
    "_s": "s",
}


def split_unit(key: str) -> tuple[str, str]:
    """(name, unit) of a key; the unit is "" where the key carries none."""
    for suffix, unit in UNITS.items():
        if key.endswith(suffix):
            return key.removesuffix(suffix), unit
    return key, ""


@dataclass
class Section:
    """A TOML table; `known` collects the keys that were asked for, `close` refuses the others."""

    path: Path
    name: str
    entries: dict[str, Any]
    overridden: frozenset[str] = frozenset()
    known: set[str] = field(default_factory=set)

    def number(
        self, key: str, default: float | None = None, low: float = -float("inf"), high: float = float("inf")
    ) -> float:
        """A number within [low, high] [unit as in the key]."""
        value = self._value(key, default)
        if not _is_number(value):
            raise self.error(key, f"expected a number{_in(key)}, found {value!r}")
        if not low <= value <= high:
            raise self.error(key, f"expected {_between(low, high)}{_in(key)}, found {value:g}")
        return float(value)

    def positive(self, key: str, default: float | None = None, high: float = float("inf")) -> float:
        """A number above zero and not above `high`."""
        value = self.number(key, default)
        if not 0.0 < value <= high:
            raise self.error(
                key, f"expected a number above 0{f' and up to {high:g}' * (high < 1e300)}{_in(key)}, found {value:g}"
            )
        return value

    def numbers(self, key: str, low: float = -LARGEST, high: float = LARGEST) -> tuple[float, ...]:
        """A list of numbers, each within [low, high]."""
        values = self._value(key, None)
        if not isinstance(values, list) or not values or not all(map(_is_number, values)):
            raise self.error(key, f"expected a list of numbers{_in(key)}, found {values!r}")
        for value in values:
            if not low <= value <= high:
                raise self.error(key, f"expected {_between(low, high)}{_in(key)}, found {value:g} among them")
        return tuple(float(value) for value in values)

    def integer(self, key: str, default: int, low: int = 0) -> int:
        """A whole number, at least `low`."""
        value = self._value(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or value < low:
            raise self.error(key, f"expected a whole number of at least {low}, found {value!r}")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """A text."""
        value = self._value(key, default)
        if not isinstance(value, str):
            raise self.error(key, f"expected a text in quotes, found {value!r}")
        return value

    def choice(self, key: str, choices: tuple[str, ...], default: str | None = None) -> str:
        """One of the words that are understood."""
        value = self.text(key, default)
        if value not in choices:
            raise self.error(key, f"expected one of {', '.join(choices)}; found '{value}'")
        return value

    def either(self, *keys: str) -> str:
        """The one of these keys that the table has; InputError where it has none or several."""
        self.known.update(keys)
        given = [key for key in keys if key in self.entries]
        if not given:
            self._look_for_other_units(keys[0])
        if len(given) != 1:
            raise self.error(keys[0], f"expected exactly one of {', '.join(keys)}; found {', '.join(given) or 'none'}")
        return given[0]

    def section(self, key: str) -> Section:
        """A table within this one, empty where the file has none."""
        value = self._value(key, {})
        if not isinstance(value, dict):
            raise self.error(key, f"expected a table [{self._full(key)}], found {value!r}")
        return Section(self.path, self._full(key), value, self.overridden)

    def close(self) -> None:
        """Refuse the keys that nobody asked for."""
        for key in self.entries:
            if key not in self.known:
                raise self.error(key, self._unknown(key))

    def error(self, key: str, message: str) -> InputError:
        """An InputError that names file, line and key, or the command line where the value was set there."""
        full = self._full(key)
        if full in self.overridden:
            return InputError(f"--set {full} (over {self.path}): {message}")
        line = line_of(self.path, self.name, key)
        return InputError(f"{self.path}{f':{line}' if line else ''}: {full}: {message}")

    def _full(self, key: str) -> str:
        return f"{self.name}.{key}" if self.name else key

    def _value(self, key: str, default: Any) -> Any:
        self.known.add(key)
        value = self.entries.get(key, default)
        if value is None:
            self._look_for_other_units(key)
            raise self.error(key, f"missing; expected a value{_in(key)}")
        return value

    def _look_for_other_units(self, key: str) -> None:
        for found in self.entries:
            if found not in self.known and split_unit(found)[0] == split_unit(key)[0]:
                raise self.error(found, _wrong_unit(found, key))

    def _unknown(self, key: str) -> str:
        for known in sorted(self.known):
            if split_unit(known)[0] == split_unit(key)[0] and split_unit(known)[1]:
                return _wrong_unit(key, known)
        return "unknown key" + meant(key, tuple(sorted(self.known)))


def open_section(path: Path, settings: tuple[str, ...] = ()) -> Section:
    """The whole TOML file, with `key.key=value` settings of the command line laid over it."""
    entries = read_table(path).entries
    names = [override(entries, setting) for setting in settings]
    return Section(path, "", entries, frozenset(names))


def override(entries: dict[str, Any], setting: str) -> str:
    """Lay one `key.key=value` over the entries, in place; returns its key. The value is TOML, or else a bare text."""
    key, equals, text = (part.strip() for part in setting.partition("="))
    if not equals or not all(key.split(".")):
        raise InputError(f"--set {setting}: expected key=value, such as sonar.noise_m=0.006")
    *tables, last = key.split(".")
    for name in tables:
        entries = entries.setdefault(name, {})
        if not isinstance(entries, dict):
            raise InputError(f"--set {setting}: '{name}' is a value and not a table")
    try:
        entries[last] = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        entries[last] = text
    return key


def line_of(path: Path, table: str, key: str) -> int:
    """Line of `key` in the `[table]` of a TOML file, counted from 1; 0 where it is not written there as plain key."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return 0
    here = ""
    for number, line in enumerate(lines, 1):
        text = line.split("#")[0].strip()
        if text.startswith("["):
            here = text.strip("[] ")
            if here == (f"{table}.{key}" if table else key):
                return number
        elif here == table and text.split("=")[0].strip() == key:
            return number
    return 0


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value == value


def _in(key: str) -> str:
    unit = split_unit(key)[1]
    return f" [{unit}]" if unit else ""


def _between(low: float, high: float) -> str:
    if high == float("inf"):
        return f"at least {low:g}"
    return f"at most {high:g}" if low == -float("inf") else f"a number from {low:g} to {high:g}"


def meant(word: str, known: tuple[str, ...]) -> str:
    """What may have been meant by a word, and all the words that are known, to end a message."""
    nearest = difflib.get_close_matches(word, known, 1, 0.6)
    return (f"; did you mean '{nearest[0]}'?" if nearest else ";") + f" there are: {', '.join(known)}"


def _wrong_unit(found: str, expected: str) -> str:
    return f"wrong unit: expected '{expected}'{_in(expected)}, found '{found}'{_in(found)}"
