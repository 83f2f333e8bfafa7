"""JSON documents: read with the schema they name, written as plain numbers, lists and texts."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from .files import read_text
from .toml import shown


def read_json(path: Path, schema: str) -> dict[str, Any]:
    """A JSON object that names its schema; InputError for anything else."""
    content = parse_json(read_text(path), path)
    found = content.get("schema") if isinstance(content, dict) else None
    if found != schema:
        raise InputError(f"{path}: found schema {shown(found)}, expected {schema!r}")
    return dict(content)


def parse_json(text: str, where: object) -> Any:
    """What a JSON text says; InputError begins with `where`."""
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{where}, line {error.lineno}: not JSON ({error.msg})") from None
    except RecursionError:
        raise InputError(f"{where}: not JSON that can be read (nested too deeply)") from None
    except ValueError:
        raise InputError(f"{where}: not JSON that can be read (a whole number of thousands of digits)") from None


def json_text(content: Any) -> str:
    """A document as JSON, ended by LF."""
    return json.dumps(jsonable(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def jsonable(value: Any) -> Any:
    """Mappings, lists, numbers and texts in place of dataclasses, arrays and numpy's numbers; not finite is None."""
    if is_dataclass(value):
        return {field.name: jsonable(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return jsonable(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [jsonable(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
