"""Numbers as they are shown, and as they are written to JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def percent(share: float) -> str:
    """A probability or share, never rounded up to certainty."""
    if share > 0.99:
        return "over 99 %"
    return "under 1 %" if 0.0 < share < 0.01 else f"{100.0 * share:.0f} %"


def number(value: float, digits: int = 4, missing: str = "-") -> str:
    """A number of so many digits; a dash where there is none."""
    return f"{value:.{digits}g}" if np.isfinite(value) else missing


def fixed(value: float, decimals: int, missing: str = "-") -> str:
    """A number of so many decimals; a dash where there is none."""
    return f"{value:.{decimals}f}" if np.isfinite(value) else missing


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
    return None if isinstance(value, float) and not np.isfinite(value) else value
