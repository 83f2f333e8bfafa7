"""The names under which effects at places are scored: one for each law at each place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

ONE_LAW = {  # names of a law that another name covers: a clock that is ahead is late, a unit and a sign are factors
    "clock_offset": "sensor_latency",
    "wrong_unit": "sensor_scale",
    "wrong_sign": "sensor_scale",
}


def scored_name(name: str) -> str:
    """The name under which EFFECT@PLACE:DETAIL, several of them joined with +, none or unknown@PLACE is scored."""
    return "+".join(sorted({_one(part) for part in name.split("+")}))


def true_name(truth: Mapping[str, Any]) -> str:
    """The right answer to a case."""
    label = str(truth["label"])
    other = (truth["effects"].get(label) or {}).get("other")
    return scored_name(f"{label}:{other}" if other else label)


def parts(name: str) -> list[tuple[str, str]]:
    """Effect and place of each effect of a scored name."""
    pairs = [part.partition("@")[::2] for part in name.split("+")]
    return [(effect, place) for effect, place in pairs if place]


def _one(part: str) -> str:
    effect, _, rest = part.partition("@")
    place, _, detail = rest.partition(":")
    if effect == "unknown" or not place:
        return effect
    if effect == "wrong_allocation":  # of two thrusters, either of which may be named first
        place = ",".join(sorted((place, detail)))
    return f"{ONE_LAW.get(effect, effect)}@{place}"
