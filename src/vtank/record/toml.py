"""TOML as text: parsed, overridden from the command line, and searched for the line of a key."""

from __future__ import annotations

import difflib
import reprlib
import textwrap
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import InputError
from .files import is_file

LONGEST = 80  # characters of a name or value as it stands in a message; a choice


def parse(text: str, where: object) -> dict[str, Any]:
    """What a TOML text says; InputError begins with `where`."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{where}: not valid TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{where}: not TOML that can be read: nested too deeply") from None
    except ValueError:
        raise InputError(f"{where}: not TOML that can be read: a whole number of thousands of digits") from None


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
    except (RecursionError, ValueError):
        raise InputError(f"--set {key}: nested too deeply, or a whole number of thousands of digits") from None
    return key


def line_of(path: Path, table: str, key: str) -> int:
    """Line of `key` in the `[table]` of a TOML file, counted from 1; 0 where it is not written there as plain key."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
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


def meant(word: str, known: Iterable[str]) -> str:
    """What may have been meant by a word, and all the words that are known, to end a message."""
    known = tuple(known)
    nearest = difflib.get_close_matches(word, known, 1, 0.6)
    return (f"; did you mean '{nearest[0]}'?" if nearest else ";") + f" there are: {', '.join(known)}"


def shown(value: Any) -> str:
    """A value as it stands in a message, cut where it is long."""
    return _CUT.repr(value)


_CUT = reprlib.Repr()
_CUT.maxstring = _CUT.maxother = LONGEST


def find_file(name_or_path: str | Path, folder: Path, what: str) -> Path:
    """The preset `<name>.toml` in `folder`, or the given path where it ends in .toml; InputError lists the presets."""
    if str(name_or_path).endswith(".toml"):
        return Path(name_or_path)
    if is_file(folder / f"{name_or_path}.toml"):
        return folder / f"{name_or_path}.toml"
    beside = (folder / name_or_path).parent
    inside = beside if folder in beside.parents and beside.is_dir() else folder
    presets = sorted(str(path.relative_to(folder).with_suffix("")) for path in inside.glob("*.toml"))
    word = textwrap.shorten(str(name_or_path), LONGEST)
    raise InputError(f"no {what} named '{word}'{meant(word, presets)}; or the path of a .toml file")
