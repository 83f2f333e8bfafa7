"""A scenario as the text of a TOML file, which `load_scenario` reads back as it was."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

from ..effects.catalogue import PARAMETERS
from .excitation import CLOSED, SUFFIXES, Excitation
from .scenario import Scenario, Waves

Table = dict[str, Any]
OWN_TABLES = ("sonar", "tachometer", "turbulence", "control")


def as_toml(scenario: Scenario, comment: str = "") -> str:
    """The file's text, `comment` first; ValueError for waves, which are not written."""
    if scenario.waves != Waves():
        raise ValueError("a scenario with waves cannot be written")
    head: Table = {
        key: value
        for key in ("description", "truth", "duration_s", "period_s", "standoff_m", "depth_m", "n_limit_rev_s", "hold",
                    "seed", "vehicle", "walls")
        if (value := getattr(scenario, key)) is not None
    }  # fmt: skip
    tables: dict[str, Table] = {"excitation": _excitation(scenario.excitation)}
    for name in OWN_TABLES:
        part = getattr(scenario, name)
        tables[name] = {f.name: getattr(part, f.name) for f in fields(part)}
    if tables["sonar"]["max_range_m"] == float("inf"):
        del tables["sonar"]["max_range_m"]
    tables["filter"] = {"q_m2_per_s5": scenario.filter.q_m2_per_s5, "r_m2": scenario.filter.r_m2}
    for slot, value in scenario.effects.items():
        tables.setdefault(f"effects.{slot.partition('.')[0]}", {})[PARAMETERS[slot].key] = value
    parts = [f"# {comment}\n" if comment else "", _lines(head)]
    return "".join([*parts, *(f"\n[{name}]\n{_lines(table)}" for name, table in tables.items())])


def _excitation(e: Excitation) -> Table:
    place, drive = SUFFIXES[e.axis]
    suffix = place if e.loop == "position" else drive
    table: Table = {"kind": e.kind, "axis": e.axis, "ramp_s": e.ramp_s, f"offset{suffix}": e.offset}
    if e.kind == "multisine":
        table |= {f"amplitudes{suffix}": list(e.amplitudes), "frequencies_rad_s": list(e.frequencies_rad_s)}
        return table
    if e.amplitudes:
        table[f"amplitude{suffix}"] = e.amplitudes[0]
    if e.kind == "step_coast":
        return table | {"push_s": e.push_s, "coast_s": e.coast_s}
    if e.kind == "chirp":
        table |= {"from_rad_s": e.frequencies_rad_s[0], "to_rad_s": e.frequencies_rad_s[1]}
    elif e.frequencies_rad_s:
        table["frequency_rad_s"] = e.frequencies_rad_s[0]
    return table | ({"phase_rad": e.phase_rad} if e.kind not in CLOSED[1:] else {})


def _lines(table: Table) -> str:
    return "".join(f"{key} = {json.dumps(value, ensure_ascii=False)}\n" for key, value in table.items())
