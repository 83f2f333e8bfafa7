"""JSON documents: read with the schema they name, written as plain numbers, lists and texts."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from .files import read_text


def read_json(path: Path, schema: str) -> dict[str, Any]:
    """A JSON object that names its schema; InputError for anything else."""
    content = parse_json(read_text(path), path)
    found = content.get("schema") if isinstance(content, dict) else None
    if found != schema:
        raise InputError(f"{path}: found schema {found!r}, expected {schema!r}")
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
    return json.dumps(plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """A document of plain numbers, lists and texts; what is not finite becomes null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
