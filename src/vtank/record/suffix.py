"""Keys carry their unit as a suffix: `noise_m`, `amplitude_rev_s`."""

from __future__ import annotations

import re

# Units in use as they stand at the end of a key, the longest first, so that "_m_s2" is not taken for "_s2"
WRITTEN = (
    "N_m_s_per_rad N_s_per_m N_s2_per_m2 N_m_s2_per_rad2 N_s2_per_m3 kg_m2 "
    "m_per_rev2 ft_per_rev2 m2_per_s5 ft2_per_s5 per_rev per_s2 per_s per_m rev_s rad_s ft_s2 m_s2 deg_s ft_s m_s "
    "rpm ft2 m2 rad deg min mm cm ft in ms hz N_m N m s"
)


def _unit(written: str) -> str:
    """As it is read aloud: m_s2 is m/s2, per_rev is 1/rev, N_m is N m, N_s_per_m is N s/m."""
    above, per, below = written.partition("_per_")
    if per:
        return f"{above}/{below}".replace("_", " ")
    return re.sub("_(?=s)", "/", written.replace("per_", "1/").replace("hz", "Hz")).replace("_", " ")


UNITS = {f"_{written}": _unit(written) for written in WRITTEN.split()}


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
