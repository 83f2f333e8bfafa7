"""Keys carry their unit as a suffix: `noise_m`, `amplitude_rev_s`."""

from __future__ import annotations

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


def in_unit(key: str) -> str:
    """The unit of a key in brackets, after a blank; nothing where it carries none."""
    unit = split_unit(key)[1]
    return f" [{unit}]" if unit else ""


def wrong_unit(found: str, expected: str) -> str:
    """The message for a key in another unit than the one that is read."""
    return f"wrong unit: expected '{expected}'{in_unit(expected)}, found '{found}'{in_unit(found)}"
