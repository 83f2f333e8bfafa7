"""Numbers with a source: how vehicle files and truth presets are read.

A number is written with its unit in the key, either bare (`mass_kg = 11.5`) or with its origin
(`mass_kg = { value = 197.313, imperial = "13.520 slug", source = "S1", confidence = "H", note = "..." }`).
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError

_ORIGIN = ("value", "imperial", "source", "confidence", "note")


@dataclass(frozen=True)
class Table:
    """A table of a TOML file that knows where it stands, so that complaints can name file and key."""

    path: Path
    name: str
    entries: dict[str, Any]

    def check_keys(self, known: Iterable[str]) -> Table:
        """Refuse keys that nobody reads: a misspelt key or unit would otherwise be ignored in silence."""
        known = tuple(known)
        for key in self.entries:
            if key not in known:
                raise self.error(key, f"unknown key; expected one of: {', '.join(known)}")
        return self

    def table(self, key: str) -> Table:
        """A sub-table, empty where the file has none."""
        return self._subtable(key, self.entries.get(key, {}))

    def tables(self, key: str) -> tuple[Table, ...]:
        """An array of tables, empty where the file has none."""
        entries = self.entries.get(key, [])
        if not isinstance(entries, list):
            raise self.error(key, f"expected an array of tables, [[{key}]]")
        return tuple(self._subtable(f"{key}[{index}]", entry) for index, entry in enumerate(entries))

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number [unit as in the key]."""
        value = self._value(key, default)
        if not _is_number(value):
            raise self.error(key, f"expected a number, found {value!r}")
        return float(value)

    def positive(self, key: str) -> float:
        """A number above zero."""
        value = self.number(key)
        if value <= 0.0:
            raise self.error(key, f"expected a number above 0, found {value:g}")
        return value

    def vector(self, key: str) -> tuple[float, float, float]:
        """Three numbers along the body axes."""
        value = self._value(key, None)
        if not (isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))):
            raise self.error(key, f"expected three numbers [x, y, z], found {value!r}")
        return float(value[0]), float(value[1]), float(value[2])

    def text(self, key: str, default: str | None = None) -> str:
        """A string."""
        value = self._value(key, default)
        if not isinstance(value, str):
            raise self.error(key, f"expected a text in quotes, found {value!r}")
        return value

    def error(self, key: str, message: str) -> InputError:
        """An InputError that names file, table and key."""
        return InputError(f"{self.path}: {self.name + '.' if self.name else ''}{key}: {message}")

    def _value(self, key: str, default: Any) -> Any:
        value = self.entries.get(key, default)
        if isinstance(value, dict):
            self._subtable(key, value).check_keys(_ORIGIN)
            value = value.get("value")
        if value is None:
            raise self.error(key, "missing")
        return value

    def _subtable(self, key: str, entries: Any) -> Table:
        if not isinstance(entries, dict):
            raise self.error(key, "expected a table")
        return Table(self.path, f"{self.name}.{key}" if self.name else key, entries)


def read_table(path: Path) -> Table:
    """The whole TOML file at `path`; InputError where it is missing or not TOML."""
    try:
        return Table(path, "", tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None


def find_file(name_or_path: str | Path, folder: Path, what: str) -> Path:
    """The preset `<name>.toml` in `folder`, or the given path where it ends in .toml; InputError lists the presets."""
    if str(name_or_path).endswith(".toml"):
        return Path(name_or_path)
    if (folder / f"{name_or_path}.toml").is_file():
        return folder / f"{name_or_path}.toml"
    presets = ", ".join(sorted(path.stem for path in folder.glob("*.toml")))
    raise InputError(f"no {what} named '{name_or_path}'; there are: {presets}; or give the path of a .toml file")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < float("inf")
