"""TOML as text: parsed, overridden from the command line, and searched for the line of a key."""

from __future__ import annotations

import difflib
import re
import reprlib
import textwrap
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import InputError
from .files import is_file

INDEX = re.compile(r"\[(\d+)\]")  # of a part of an array: excite[0].axis is excite.0.axis
LONGEST = 80  # characters of a name or value as it stands in a message; a choice
MANY, FEW = 20, 5  # names beyond which only the nearest are listed in a message, and how many; choices
NEAR = 0.6  # likeness, 0 to 1, from which a name may be meant by another word; a choice


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
    """Lay one `key.key=value` over the entries, in place; returns its key. The value is TOML, or else a bare text.

    A part of an array goes by its number: excite[0].axis=sway, or excite.0.axis=sway.
    """
    key, equals, text = (part.strip() for part in setting.partition("="))
    names = INDEX.sub(r".\1", key).split(".")
    if not equals or not all(names):
        raise InputError(f"--set {setting}: expected key=value, such as sonar.noise_m=0.006")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text
    except (RecursionError, ValueError):
        raise InputError(f"--set {key}: nested too deeply, or a whole number of thousands of digits") from None
    within: Any = entries
    full = ""
    for name in names[:-1]:
        index = _index(within, name, full, setting)
        full += f"[{name}]" if isinstance(within, list) else f".{name}" if full else name
        within = within[index] if isinstance(within, list) else within.setdefault(index, {})
        if not isinstance(within, dict | list):
            raise InputError(f"--set {setting}: '{name}' is a value and not a table")
    within[_index(within, names[-1], full, setting)] = value
    return full + (f"[{names[-1]}]" if isinstance(within, list) else f".{names[-1]}" if full else names[-1])


def _index(within: dict[str, Any] | list[Any], name: str, key: str, setting: str) -> Any:
    """The key of a table, or the number of a part of an array; InputError where the array has none such."""
    if isinstance(within, dict):
        return name
    if not name.isdecimal() or len(name) > 9 or int(name) >= len(within):
        known = ", ".join(f"{key}[{number}]" for number in range(len(within))) or "none"
        raise InputError(f"--set {setting}: '{key}' is an array; expected one of its parts: {known}")
    return int(name)


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
    """What may have been meant by a word, and the words that are known, of many the nearest, to end a message."""
    known = tuple(known)
    near, shown = nearest(word, known), known
    if len(known) > MANY:
        close = difflib.get_close_matches(word, known, FEW, 0.0)
        shown = tuple(name for name in known if name in close)
    more = f" and {len(known) - len(shown)} more" if len(shown) < len(known) else ""
    return (f"; did you mean '{near}'?" if near else ";") + f" there are: {', '.join(shown)}{more}"


def nearest(word: str, known: Iterable[str]) -> str:
    """The name that a misspelt one is most like, "" where it is like none: an ending that both share makes none so."""
    known = tuple(known)
    for name in difflib.get_close_matches(word, known, max(len(known), 1), NEAR):
        one, other = word.split("_"), name.split("_")
        while len(one) > 1 and len(other) > 1 and one[-1] == other[-1]:
            one, other = one[:-1], other[:-1]
        if difflib.SequenceMatcher(None, "_".join(one), "_".join(other)).ratio() >= NEAR:
            return name
    return ""


def no_file(path: Path) -> str:
    """What is said of a file that is not there: which of its kind lie beside."""
    beside = sorted(other.name for other in path.parent.glob("*") if other.suffix == path.suffix)
    return f"no file {path}{meant(path.name, beside or ['none'])}"


def shown(value: Any) -> str:
    """A value as it stands in a message, cut where it is long."""
    return _CUT.repr(value)


_CUT = reprlib.Repr()
_CUT.maxstring = _CUT.maxother = LONGEST


def find_file(name_or_path: str | Path, folder: Path, what: str, inner: str = "") -> Path:
    """The preset `<name>.toml` in `folder`, or the given path where it ends in .toml; InputError lists the presets.

    inner: folder within, whose presets are listed too.
    """
    if str(name_or_path).endswith(".toml"):
        return Path(name_or_path)
    if is_file(folder / f"{name_or_path}.toml"):
        return folder / f"{name_or_path}.toml"
    beside = (folder / name_or_path).parent
    inside = beside if folder in beside.parents and beside.is_dir() else folder
    found = [*inside.glob("*.toml"), *(inside.glob(f"{inner}/*.toml") if inner else ())]
    presets = sorted(str(path.relative_to(folder).with_suffix("")) for path in found)
    word = textwrap.shorten(str(name_or_path), LONGEST)
    raise InputError(f"no {what} named '{word}'{meant(word, presets)}; or the path of a .toml file")
