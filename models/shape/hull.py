"""The Phoenix's hull: box-like sections at the published stations, pierced by four tunnels."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from mesh import FINE, INCH_M, Mesh, circle, rounded
from parts import propeller
from scipy.interpolate import PchipInterpolator

ARC = 6  # segments per rounded edge
EDGE_IN = 1.4  # radius of the long edges: a guess
JOINT_IN = 26.8  # station where the nose fairing begins: the end of the parallel mid-body
NOSE_IN = (26.8, 28.5, 30.2, 32, 34, 36, 37.8, 39.4, 40.8, 41.6, 42.3, 42.9, 43.3, 43.5, 43.6, 43.66, 43.69)


class Hull:
    """Height and width [in] along x [in], and the tunnels by name."""

    def __init__(self, numbers: dict) -> None:
        hull, sites = numbers["hull"], numbers["sites"]
        keys = ("station_x_in", "station_height_in", "station_width_in")
        self.x, self.height, self.width = (np.array(hull[key]["value"]) for key in keys)
        self.bore = hull["tunnel_bore_in"]["value"] / 2.0
        tunnels = [key for key in sites if key.startswith("tunnel_")]
        self.tunnels = {key: sites[key]["value"][0] / INCH_M for key in tunnels}

    def section(self, x: float) -> tuple[float, float]:
        """Height and width at x, linear between stations."""
        return float(np.interp(x, self.x, self.height)), float(np.interp(x, self.x, self.width))

    def fairing(self, x: float) -> tuple[float, float]:
        """Height and width of the nose: a smooth curve through the stations, blunt at the tip."""
        last, tip = self.x[-2:]
        if x > last:
            share = np.sqrt((tip - x) / (tip - last))
            return self.height[-2] * share, self.width[-2] * share
        height, width = (float(PchipInterpolator(self.x[:-1], v[:-1])(x)) for v in (self.height, self.width))
        return height, width

    def draw(self, meshes: dict[str, Mesh]) -> None:
        """Add hull, nose, tunnels and what turns in them."""
        reach = self.bore + 0.6
        edges = {x + side * reach for x in self.tunnels.values() for side in (-1, 1)}
        stations = sorted({round(float(x), 4) for x in (*self.x, *edges) if x <= JOINT_IN})
        rings = [ring(x, *self.section(x)) for x in stations]
        openings = set()
        for name, x in self.tunnels.items():
            rows = [row for row, (a, b) in enumerate(pairwise(stations)) if x - reach < (a + b) / 2.0 < x + reach]
            openings |= {(row, flat * (ARC + 1) + ARC) for row in rows for flat, _ in faces_of(name)}
            self.pierce(name, x, rings[rows[0] : rows[-1] + 2], meshes)
        meshes["hull"].loft(rings, openings=openings)
        meshes["nose"].loft([ring(x, *self.fairing(x)) for x in NOSE_IN])

    def pierce(self, name: str, x: float, rings: list[np.ndarray], meshes: dict[str, Mesh]) -> None:
        """One tunnel: plates with a hole, lips, the bore and a propeller behind either mouth."""
        axis, centre = (2 if "vertical" in name else 1), np.array([x, 0.0, 0.0])
        half = self.section(x)[0 if axis == 2 else 1] / 2.0
        for flat, side in faces_of(name):
            mouth = circle(centre, axis, side * half, self.bore, FINE)
            meshes["hull"].washer(surround(rings, flat, mouth, axis), mouth, centre)
            lip = [circle(centre, axis, side * (half + 0.1), radius, FINE) for radius in (self.bore + 0.3, self.bore)]
            meshes["dark"].washer(*lip, centre)
            propeller(meshes["bronze"], centre + side * 0.72 * half * np.eye(3)[axis], axis, 0.94 * self.bore, blades=3)
        meshes["tunnel"].bore([circle(centre, axis, end, self.bore, FINE) for end in (-half, half)])


def ring(x: float, height: float, width: float) -> np.ndarray:
    """Rounded rectangle at station x, shape (4 (ARC + 1), 3); edges grow rounder where the section is small."""
    a, b = max(width, 0.2) / 2.0, max(height, 0.2) / 2.0
    radius = min(EDGE_IN + 0.12 * (8.25 - a) * b, 0.98 * b, 0.98 * a)
    outline = rounded(a, b, radius, ARC)
    return np.column_stack([np.full(len(outline), x), outline])


def faces_of(tunnel: str) -> tuple[tuple[int, int], tuple[int, int]]:
    """The two flats a tunnel opens in, by the arc of `ring` they follow, and their side of the body axis."""
    return ((0, 1), (2, -1)) if "vertical" in tunnel else ((3, 1), (1, -1))


def surround(rings: list[np.ndarray], flat: int, mouth: np.ndarray, axis: int) -> np.ndarray:
    """Points on the edge of a flat between rings, one for each point of the mouth, on about the same bearing."""
    across = 3 - axis
    edges = np.array([ring[[flat * (ARC + 1) + ARC, (flat + 1) * (ARC + 1) % (4 * (ARC + 1))]] for ring in rings])
    low, high = edges[:, :, across].min(axis=1), edges[:, :, across].max(axis=1)
    offset = (mouth - mouth.mean(axis=0))[:, [0, across]]
    share = 0.5 + 0.5 * offset / np.abs(offset).max(axis=1, keepdims=True)
    points, stations = mouth.copy(), edges[:, 0, 0]
    points[:, 0] = stations[0] + share[:, 0] * (stations[-1] - stations[0])
    bottom, top = (np.interp(points[:, 0], stations, edge) for edge in (low, high))
    points[:, across] = bottom + share[:, 1] * (top - bottom)
    return points
