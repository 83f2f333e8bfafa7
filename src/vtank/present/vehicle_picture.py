"""A vehicle from above, with its thrusters, fins and instruments, on which the places of effects light up."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from .numbers import percent
from .svg import drawn

if TYPE_CHECKING:
    from ..plant.vehicle import Vehicle

WIDTH, LARGEST = 500.0, (145.0, 110.0)  # [px] of the picture, and half the hull's length and width at most
ROOM, RIM = 58.0, 14.0  # [px] above and below the hull, and from the outermost place to its side
CHIPS = ("surge", "sway", "heave", "roll", "pitch", "yaw", "vehicle")  # places that are nowhere on the hull
CHIP = 26.0  # [px] height of one
LETTER, LINE = 7.0, 16.0  # [px] width and height of a letter, about
NEAR = 10.0  # [px] within which places share a mark
ARROW = 26.0  # [px] of a thruster's direction
Box = tuple[float, float, float, float]


def vehicle_picture(vehicle: Vehicle, lit: Mapping[str, float]) -> str:
    """An SVG; lit: place -> probability, by which it is filled; of "thrusters", all of them are."""
    said = ", ".join(f"{name} {percent(p)}" for name, p in lit.items()) or "none"
    if together := lit.get("thrusters", 0.0):
        lit = {**lit, **{t.name: max(lit.get(t.name, 0.0), together) for t in vehicle.thrusters}}
    places = [(t.name, vehicle.sites[t.site]) for t in vehicle.thrusters]
    places += [(f.name, vehicle.sites[f.site]) for f in vehicle.fins]
    places += [(s.name, s.position_m) for s in vehicle.sensors]
    points = np.array([(0.0, 0.0), *(p[:2] for _, p in places), *(p[:2] for p in vehicle.sites.values())])
    reach = np.maximum(np.abs(points).max(axis=0), 1e-3)
    scale = float(np.min(LARGEST / reach))
    half = scale * reach + RIM
    middle = np.array([WIDTH / 2.0, half[1] + ROOM])
    height = 2.0 * middle[1] + CHIP
    corner = 0.5 * float(half.min())
    hull = (
        f'<rect class="hull" style="--lit:{0.5 * lit.get("vehicle", 0.0):.2f}" x="{middle[0] - half[0]:.1f}" '
        f'y="{middle[1] - half[1]:.1f}" width="{2 * half[0]:.1f}" height="{2 * half[1]:.1f}" rx="{corner:.1f}"/>'
    )
    marks: dict[tuple[float, float], list[str]] = {}
    for name, place in places:
        at = middle + scale * np.asarray(place[:2])
        key = next((k for k in marks if np.hypot(*(at - k)) < NEAR), (float(at[0]), float(at[1])))
        marks.setdefault(key, []).append(name)
    arrows = []
    for thruster in vehicle.thrusters:
        x, y = middle + scale * np.asarray(vehicle.sites[thruster.site][:2])
        dx, dy = ARROW * np.asarray(thruster.direction[:2])
        arrows.append(f'<path class="axis" d="M{x:.1f} {y:.1f}l{dx:.1f} {dy:.1f}"/>')
    chips = "".join(_chip(k, height - CHIP, name, lit.get(name, 0.0)) for k, name in enumerate(CHIPS))
    drawing = "\n".join((hull, *arrows, _marks(marks, lit), chips))
    return drawn("vehicle", WIDTH, height, drawing, f"The vehicle from above; places and their probability: {said}.")


def _chip(k: int, y: float, name: str, filled: float) -> str:
    width = WIDTH / len(CHIPS)
    x, middle = k * width + 3.0, (k + 0.5) * width
    return (
        f'<rect class="place" style="--lit:{0.5 * filled:.2f}" x="{x:.1f}" y="{y:.1f}" width="{width - 6.0:.1f}" '
        f'height="{CHIP - 3.0}" rx="5"/><text class="middle" x="{middle:.1f}" y="{y + 16.0:.1f}">{name}</text>'
    )


def _marks(marks: Mapping[tuple[float, float], list[str]], lit: Mapping[str, float]) -> str:
    """Round marks with their names where there is room for them."""
    taken: list[Box] = [(x - 7.0, y - 7.0, x + 7.0, y + 7.0) for x, y in marks]
    parts = []
    for (x, y), names in marks.items():
        filled = max(lit.get(name, 0.0) for name in names)
        told = "; ".join(f"{name}: {percent(lit.get(name, 0.0))}" for name in names)
        parts.append(
            f'<circle class="place" style="--lit:{filled:.2f}" cx="{x:.1f}" cy="{y:.1f}" r="{6.0 + 3.0 * filled:.1f}">'
            f"<title>{escape(told)}</title></circle>"
        )
        parts.append(_label(x, y, ", ".join(names).replace("_", " "), taken))
    return "".join(parts)


def _label(x: float, y: float, text: str, taken: list[Box]) -> str:
    """A name beside its mark, outside first, on the first side where it lies on nothing else."""
    long = LETTER * len(text)
    beside = [(x + 13.0, y + 4.5), (x - 13.0 - long, y + 4.5)]
    above = [(x - 0.5 * long, y + down) for down in (-13.0, 22.0, -29.0, 38.0, -45.0, 54.0)]

    def box(corner: tuple[float, float]) -> Box:
        return corner[0], corner[1] - LINE + 4.0, corner[0] + long, corner[1] + 4.0

    def free(corner: tuple[float, float]) -> bool:
        a, b, c, d = box(corner)
        return a >= 0.0 and c <= WIDTH and not any(a < r and p < c and b < s and q < d for p, q, r, s in taken)

    corners = [*(beside if x >= WIDTH / 2 else beside[::-1]), *above]
    corner = next(filter(free, corners), corners[0])
    taken.append(box(corner))
    return f'<text class="middle name" x="{corner[0] + long / 2:.1f}" y="{corner[1]:.1f}">{escape(text)}</text>'
