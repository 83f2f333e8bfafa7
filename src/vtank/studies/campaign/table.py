"""The table of all runs: how each ended, what was varied and what was true."""

from __future__ import annotations

import json
from collections.abc import Mapping
from operator import attrgetter
from typing import Any

from ...effects import CATALOGUE
from ...experiment import Plan
from ...plant import slot
from .campaign import LUMPED, Campaign

DONE, FAILED = "done", "failed"
HEAD = ("run", "status", "message", "scenario", "truth", "seed", "run_number", "samples")
TEXTS = HEAD[:5]
NOISE = ("sonar.noise_m", "sonar.resolution_m", "tachometer.noise_rev_s", "turbulence.acceleration_m_s2")

# Column -> slot of the parameter vector
SLOTS = {LUMPED[0]: slot("alpha"), LUMPED[1]: slot("beta")} | {
    f"effects.{effect.name}.{parameter.key}": slot(f"{effect.name}.{parameter.name}")
    for effect in CATALOGUE
    for parameter in effect.parameters
}

Row = dict[str, Any]


def columns(campaign: Campaign) -> tuple[str, ...]:
    """Names of the columns: head, what is varied, and of the truth what is anywhere in the campaign."""
    present = [column for column, index in SLOTS.items() if column in LUMPED or index in campaign.slots]
    return tuple(dict.fromkeys([*HEAD, *campaign.varied, *present, *NOISE]))


def numeric(campaign: Campaign) -> tuple[str, ...]:
    """The columns that hold nothing but numbers."""
    tried = {axis.key: axis.values for axis in campaign.grid} | {draw.key: draw.ends for draw in campaign.draws}
    words = {key for key, values in tried.items() if not all(type(value) in (int, float) for value in values)}
    return tuple(column for column in columns(campaign) if column not in TEXTS and column not in words)


def row(plan: Plan | None, choice: Mapping[str, Any], name: str, message: str = "") -> Row:
    """Column -> value of one run; without a plan only what was wanted."""
    wanted = dict(choice) | {"run": name, "status": FAILED if message else DONE, "message": message}
    if plan is None:
        return wanted
    known = {"truth": plan.truth.name, "seed": plan.seed, "run_number": plan.run, "samples": plan.scenario.samples}
    noise = {column: float(attrgetter(column)(plan.scenario)) for column in NOISE}
    return noise | {column: float(plan.p[index]) for column, index in SLOTS.items()} | wanted | known


def cell(value: Any) -> Any:
    """A value as it is written into runs.csv."""
    if isinstance(value, list | dict | bool):
        return json.dumps(value, separators=(",", ":"))
    return "" if value is None else repr(value) if isinstance(value, float) else value
