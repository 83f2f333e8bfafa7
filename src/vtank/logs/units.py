"""Units as logs write them, in the unit of a column."""

from __future__ import annotations

import math

STANDARD_GRAVITY = 9.80665  # [m/s2], ISO 80000-3
POUND_FORCE = 4.4482216152605  # [N], international
RPM = 1.0 / 60.0  # [rev/s]

# Unit of a column -> unit of a log -> factor.
UNITS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "dm": 0.1, "km": 1e3, "ft": 0.3048, "in": 0.0254},
    "rad": {"rad": 1.0, "mrad": 1e-3, "deg": math.radians(1.0), "°": math.radians(1.0), "cdeg": math.radians(0.01)},
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "ft/s": 0.3048, "km/h": 1.0 / 3.6, "kn": 1852.0 / 3600.0},
    "rad/s": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": math.radians(1.0), "°/s": math.radians(1.0)},
    "m/s2": {"m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0, "cm/s2": 1e-2, "g": STANDARD_GRAVITY,
             "mg": 1e-3 * STANDARD_GRAVITY},
    "N": {"N": 1.0, "kN": 1e3, "kgf": STANDARD_GRAVITY, "lbf": POUND_FORCE},
    "N m": {"N m": 1.0, "Nm": 1.0, "kN m": 1e3},
    "rev/s": {"rev/s": 1.0, "rpm": RPM, "1/min": RPM, "rps": 1.0},
    "-": {"-": 1.0, "%": 1e-2},
    "V": {"V": 1.0, "mV": 1e-3, "cV": 1e-2},
    "A": {"A": 1.0, "mA": 1e-3, "cA": 1e-2},
}  # fmt: skip


def factor(written: str, unit: str) -> float | None:
    """By what a number in a log's unit is multiplied to be in a column's; None where they do not go together."""
    known, written = UNITS[unit], written.strip()
    if any(written in names for names in UNITS.values()):  # kn is not kN
        return known.get(written)
    return {name.lower(): each for name, each in known.items()}.get(written.lower())
