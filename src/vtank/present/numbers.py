"""Numbers as they are shown."""

from __future__ import annotations

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
