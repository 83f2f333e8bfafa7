"""A scenario as text: whole, which `load_scenario` reads back as it was, or only what is known before the truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from ..effects.catalogue import PARAMETERS
from ..record.files import read_text
from ..record.manifest import Manifest
from .excitation import CLOSED, SUFFIXES, Excitation
from .plan import Plan
from .result import Result
from .scenario import Scenario, Waves

Keys = dict[str, Any]
CARD = ("duration_s", "period_s", "standoff_m", "depth_m", "hold")
OWN_TABLES = ("sonar", "tachometer", "turbulence", "control", "filter")


def as_toml(scenario: Scenario, comment: str = "") -> str:
    """The file's text, `comment` first; ValueError for waves, which are not written."""
    if scenario.waves != Waves():
        raise ValueError("a scenario with waves cannot be written")
    head: Keys = {
        key: value
        for key in ("description", "truth", "duration_s", "period_s", "standoff_m", "depth_m", "n_limit_rev_s", "hold",
                    "seed", "vehicle", "walls")
        if (value := getattr(scenario, key)) is not None
    }  # fmt: skip
    tables: dict[str, Keys] = {"excitation": _excitation(scenario.excitation)}
    tables |= {name: asdict(getattr(scenario, name)) for name in OWN_TABLES}
    if tables["sonar"]["max_range_m"] == float("inf"):
        del tables["sonar"]["max_range_m"]
    if tables["control"]["thrust_m_per_rev2"] is None:
        del tables["control"]["thrust_m_per_rev2"]
    for slot, value in scenario.effects.items():
        tables.setdefault(f"effects.{slot.partition('.')[0]}", {})[PARAMETERS[slot].key] = value
    parts = [f"# {comment}\n" if comment else "", _lines(head)]
    return "".join([*parts, *(f"\n[{name}]\n{_lines(table)}" for name, table in tables.items())])


def test_card(scenario: Scenario) -> str:
    """What whoever flies a run knows of it beforehand: its times, its place and the command; nothing of the truth."""
    head, command = {key: getattr(scenario, key) for key in CARD}, _excitation(scenario.excitation)
    return f"{_lines(head)}\n[excitation]\n{_lines(command)}"


def provenance(results: Sequence[Result], model: str, settings: Sequence[str] = ()) -> tuple[Manifest, dict[str, Any]]:
    """What a data set of simulated runs tells of itself, and its truth: the scenarios as flown and what was true.

    model: "tank" or "surge". settings: key=value of the command line.
    """
    plans = [result.plan for result in results]
    flown = [{"name": plan.name, "text": _as_flown(plan, settings)} for plan in plans]
    true = [result.truth() for result in results]
    truth = {"model": model, "settings": list(settings), "scenarios": flown, "runs": true}
    return Manifest({plan.name: test_card(plan.scenario) for plan in plans}), truth


def _as_flown(plan: Plan, settings: Sequence[str]) -> str:
    """The scenario's file, and as comments what was changed on the command line."""
    changes = [f"# --set {setting}" for setting in settings]
    if plan.truth.name != plan.scenario.truth:
        changes.append(f"# --truth {plan.truth.name}")
    return read_text(plan.scenario.path) + "".join(f"\n{change}" for change in changes)


def _excitation(e: Excitation) -> Keys:
    place, drive = SUFFIXES[e.axis]
    suffix = place if e.loop == "position" else drive
    table: Keys = {"kind": e.kind, "axis": e.axis, "ramp_s": e.ramp_s, f"offset{suffix}": e.offset}
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


def _lines(table: Keys) -> str:
    return "".join(f"{key} = {json.dumps(value, ensure_ascii=False)}\n" for key, value in table.items())
