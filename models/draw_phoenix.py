"""Draw the Phoenix: write phoenix_shape.xml (meshes) from the hull stations and sizes in phoenix.toml.

    python models/draw_phoenix.py

A picture only: no mesh has mass, touches anything or is heard by the sonar. Body axes x forward, y starboard, z down;
lengths in inches while drawing, as the sources print them, metres in the file.
"""

from __future__ import annotations

import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

HERE = Path(__file__).resolve().parent
INCH_M = 0.0254
ARC = 6  # segments per rounded hull edge
ROUND = 16  # segments per circle, a multiple of 8
FINE = 32  # segments per large circle

FONT = {  # 5 x 7 block letters, one number per row
    "P": (30, 17, 17, 30, 16, 16, 16),
    "H": (17, 17, 17, 31, 17, 17, 17),
    "O": (14, 17, 17, 17, 17, 17, 14),
    "E": (31, 16, 16, 30, 16, 16, 31),
    "N": (17, 25, 25, 21, 19, 19, 17),
    "I": (14, 4, 4, 4, 4, 4, 14),
    "X": (17, 17, 10, 4, 10, 17, 17),
}


Point = tuple[float, float, float] | np.ndarray
Profile = list[tuple[float, float]]  # (station along an axis, radius)


class Mesh:
    """Triangles under construction: vertices [in] and faces."""

    def __init__(self) -> None:
        self.vertices: list[np.ndarray] = []
        self.faces: list[tuple[int, int, int]] = []

    def add(self, points: np.ndarray, faces: np.ndarray, inside: np.ndarray) -> None:
        """Add a part, each face wound so that its normal points away from `inside`, shape (3,) or (F, 3)."""
        start = len(self.vertices)
        corners = points[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inward = np.einsum("fi,fi->f", normals, corners.mean(axis=1) - inside) < 0.0
        faces = np.where(inward[:, None], faces[:, ::-1], faces)
        keep = np.linalg.norm(normals, axis=1) > 1e-9
        self.vertices.extend(points)
        self.faces.extend((start + a, start + b, start + c) for a, b, c in faces[keep])

    def loft(
        self, rings: list[np.ndarray], capped: bool = True, skip: frozenset[tuple[int, int]] = frozenset()
    ) -> None:
        """Skin closed rings, each shape (K, 3); `skip` names the (ring, segment) quads to leave open."""
        count = len(rings[0])
        faces, inside = [], []
        for row, (near, far) in enumerate(pairwise(rings)):
            for k in range(count):
                a, b = row * count + k, row * count + (k + 1) % count
                if (row, k) not in skip:
                    faces += [(a, b, a + count), (b, b + count, a + count)]
                    inside += [(near.mean(axis=0) + far.mean(axis=0)) / 2.0] * 2
        self.add(np.concatenate(rings), np.array(faces), np.array(inside))
        if capped:
            for end, next_ring in ((rings[0], rings[1]), (rings[-1], rings[-2])):
                fan = np.array([(k, (k + 1) % count, count) for k in range(count)])
                self.add(np.vstack([end, end.mean(axis=0)]), fan, next_ring.mean(axis=0))

    def box(self, low: Point, high: Point) -> None:
        """A box along the axes."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        rings = [np.array([(x, y0, z0), (x, y1, z0), (x, y1, z1), (x, y0, z1)]) for x in (x0, x1)]
        self.loft(rings)

    def turned(self, centre: Point, axis: int, profile: Profile, inner: float = 0.0, count: int = ROUND) -> None:
        """A body of revolution about a body axis: profile of (station along the axis, radius); `inner` makes a tube."""
        rings = [circle(centre, axis, station, radius, count) for station, radius in profile]
        self.loft(rings, capped=inner == 0.0)
        if inner > 0.0:
            holes = [circle(centre, axis, profile[k][0], inner, count) for k in (0, -1)]
            self.bore(holes)
            self.washer(rings[0], holes[0], holes[1].mean(axis=0))
            self.washer(rings[-1], holes[1], holes[0].mean(axis=0))

    def bore(self, rings: list[np.ndarray]) -> None:
        """The inner wall of a tube, seen from inside."""
        tube = Mesh()
        tube.loft(rings, capped=False)
        start = len(self.vertices)
        self.vertices.extend(tube.vertices)
        self.faces.extend((start + c, start + b, start + a) for a, b, c in tube.faces)

    def washer(self, outer: np.ndarray, inner: np.ndarray, inside: np.ndarray) -> None:
        """A flat face between two rings of equal count."""
        count = len(outer)
        k = np.arange(count)
        following = (k + 1) % count
        faces = np.vstack(
            [np.column_stack([k, following, count + k]), np.column_stack([following, count + following, count + k])]
        )
        self.add(np.vstack([outer, inner]), faces, inside)

    def xml(self, name: str) -> str:
        """The mesh as an MJCF asset."""
        vertices = " ".join(short(value) for point in self.vertices for value in point * INCH_M)
        faces = " ".join(str(index) for face in self.faces for index in face)
        return f'    <mesh name="{name}" inertia="shell"\n      vertex="{vertices}"\n      face="{faces}"/>\n'


def short(metres: float) -> str:
    """A coordinate to 0.1 mm in as few characters as possible."""
    text = f"{metres:.4f}".rstrip("0").rstrip(".").replace("0.", ".", 1) if abs(metres) < 1.0 else f"{metres:.4f}"
    return text if text not in ("", "-", "-0") else "0"


def circle(centre: Point, axis: int, station: float, radius: float, count: int = ROUND) -> np.ndarray:
    """Ring about a body axis, shape (count, 3)."""
    angle = 2.0 * np.pi * np.arange(count) / count + np.pi / 4.0
    ring = np.tile(np.array(centre, dtype=float), (count, 1))
    ring[:, axis] += station
    ring[:, (axis + 1) % 3] += radius * np.cos(angle)
    ring[:, (axis + 2) % 3] += radius * np.sin(angle)
    return ring


def hull_ring(x: float, height: float, width: float) -> np.ndarray:
    """Rounded rectangle at station x: four arcs of ARC + 1 points; edges grow rounder where the section is small."""
    a, b = max(width, 0.2) / 2.0, max(height, 0.2) / 2.0
    radius = min(1.4 + 0.12 * (8.25 - a) * b, 0.98 * b, 0.98 * a)
    points = []
    for quarter, (sy, sz) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angle = np.pi / 2.0 * (quarter + np.arange(ARC + 1) / ARC)
        points.append(
            np.column_stack(
                [
                    np.full(ARC + 1, x),
                    sy * (a - radius) + radius * np.cos(angle),
                    sz * (b - radius) + radius * np.sin(angle),
                ]
            )
        )
    return np.concatenate(points)


class Hull:
    """The published stations, with the sections the tunnels need in between."""

    def __init__(self, numbers: dict) -> None:
        hull = numbers["hull"]
        self.x, self.height, self.width = (
            np.array(hull[key]["value"]) for key in ("station_x_in", "station_height_in", "station_width_in")
        )
        self.bore = hull["tunnel_bore_in"]["value"] / 2.0
        self.tunnels = {
            name: numbers["sites"][f"tunnel_{name}_m"]["value"][0] / INCH_M
            for name in ("bow_vertical", "stern_vertical", "bow_lateral", "stern_lateral")
        }

    def section(self, x: float) -> tuple[float, float]:
        """Height and width [in] at x, linear between stations."""
        return float(np.interp(x, self.x, self.height)), float(np.interp(x, self.x, self.width))

    def fairing(self, x: float) -> tuple[float, float]:
        """Height and width [in] of the nose: a smooth curve through the stations, blunt at the tip."""
        tip = self.x[-2:]
        if x > tip[0]:
            share = np.sqrt((tip[1] - x) / (tip[1] - tip[0]))
            return self.height[-2] * share, self.width[-2] * share
        curves = (PchipInterpolator(self.x[:-1], values[:-1]) for values in (self.height, self.width))
        height, width = (float(curve(x)) for curve in curves)
        return height, width

    def ring(self, x: float) -> np.ndarray:
        return hull_ring(x, *self.section(x))

    def draw(self, body: Mesh, nose: Mesh, tunnel: Mesh, lip: Mesh, bronze: Mesh) -> None:
        """Hull and nose fairing, pierced by the four tunnels."""
        split = 26.8
        patch = self.bore + 0.6
        edges = {round(x + side * patch, 4) for x in self.tunnels.values() for side in (-1, 1)}
        stations = sorted({round(float(x), 4) for x in self.x} | edges)
        aft = [x for x in stations if x <= split]
        rings = [self.ring(x) for x in aft]
        skip = set()
        for name, x in self.tunnels.items():
            row = next(i for i, (a, b) in enumerate(pairwise(aft)) if a <= x <= b)
            while aft[row] > x - patch + 1e-6:
                row -= 1
            rows = [i for i, (a, b) in enumerate(pairwise(aft)) if a >= x - patch - 1e-6 and b <= x + patch + 1e-6]
            # the flats follow the arcs: after arc 0 the bottom (+z), 1 port, 2 top, 3 starboard
            flats = (0, 2) if "vertical" in name else (1, 3)
            skip |= {(i, flat * (ARC + 1) + ARC) for i in rows for flat in flats}
            self.pierce(name, x, rings[rows[0]], rings[rows[-1] + 1], body, tunnel, lip, bronze)
        body.loft(rings, skip=frozenset(skip))
        nose.loft(
            [
                hull_ring(x, *self.fairing(x))
                for x in (
                    26.8,
                    28.5,
                    30.2,
                    32,
                    34,
                    36,
                    37.8,
                    39.4,
                    40.8,
                    41.6,
                    42.3,
                    42.9,
                    43.3,
                    43.5,
                    43.6,
                    43.66,
                    43.69,
                )
            ]
        )

    def pierce(
        self, name: str, x: float, near: np.ndarray, far: np.ndarray, body: Mesh, tunnel: Mesh, lip: Mesh, bronze: Mesh
    ) -> None:
        axis = 2 if "vertical" in name else 1
        height, width = self.section(x)
        half = (height if axis == 2 else width) / 2.0
        for flat, sign in ((0, 1), (2, -1)) if axis == 2 else ((3, 1), (1, -1)):
            a, b = flat * (ARC + 1) + ARC, (flat + 1) * (ARC + 1) % (4 * (ARC + 1))
            corners = np.array([near[a], near[b], far[b], far[a]])
            hole = circle((x, 0.0, 0.0), axis, sign * half, self.bore, FINE)
            body.washer(frame(corners, hole, axis), hole, np.array([x, 0.0, 0.0]))
            edge = circle((x, 0.0, 0.0), axis, sign * (half + 0.1), self.bore + 0.3, FINE)
            lip.washer(edge, circle((x, 0.0, 0.0), axis, sign * (half + 0.1), self.bore, FINE), np.array([x, 0.0, 0.0]))
        tunnel.bore([circle((x, 0.0, 0.0), axis, end, self.bore, FINE) for end in (-half, half)])
        for station in (-0.72 * half, 0.72 * half):
            centre = np.array([x, 0.0, 0.0])
            centre[axis] += station
            propeller(bronze, centre, axis, 0.94 * self.bore, blades=3)


def frame(corners: np.ndarray, hole: np.ndarray, axis: int) -> np.ndarray:
    """Points on the rectangle `corners`, one for each point of the hole, on the same bearing from its centre."""
    centre = corners.mean(axis=0)
    plane = [k for k in range(3) if k != axis]
    offset = (hole - hole.mean(axis=0))[:, plane]
    reach = np.abs(corners - centre).max(axis=0)[plane]
    points = np.tile(hole.mean(axis=0), (len(hole), 1))
    points[:, axis] = hole[:, axis]
    points[:, plane] = centre[plane] + offset / np.abs(offset).max(axis=1, keepdims=True) * reach
    return points


def propeller(mesh: Mesh, centre: np.ndarray, axis: int, radius: float, blades: int, hand: float = 1.0) -> None:
    """Twisted blades on a hub."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for blade in range(blades):
        rings = []
        for share in (0.2, 0.45, 0.75, 0.95, 1.0):
            pitch = hand * (1.15 - 0.75 * share)
            chord = radius * (0.34 + 0.75 * share * (1.02 - share) ** 0.5)
            bearing = 2.0 * np.pi * blade / blades
            radial, across = (np.cos(bearing), np.sin(bearing)), (-np.sin(bearing), np.cos(bearing))
            ring = []
            for along, thick in ((-0.5, 0.0), (0.0, 0.035), (0.5, 0.0), (0.0, -0.035)):
                swing, advance = (
                    chord * along * np.cos(pitch) - thick * radius * np.sin(pitch),
                    chord * along * np.sin(pitch) + thick * radius * np.cos(pitch),
                )
                point = np.array(centre, dtype=float)
                point[axis] += advance
                point[u] += share * radius * radial[0] + swing * across[0]
                point[v] += share * radius * radial[1] + swing * across[1]
                ring.append(point)
            rings.append(np.array(ring))
        mesh.loft(rings)
    hub = 0.24 * radius
    mesh.turned(
        centre,
        axis,
        [(-1.6 * hub, 0.2 * hub), (-1.1 * hub, 0.75 * hub), (-0.5 * hub, hub), (1.4 * hub, hub)],
        count=8 * (blades // 2),
    )


def fin(mesh: Mesh, x: float, root: np.ndarray, out: np.ndarray, hull: dict) -> None:
    """A tapered fin from `root` in direction `out`, with a lens-shaped section."""
    span, chord, tip, thick = (
        hull[key]["value"] for key in ("fin_span_in", "fin_root_chord_in", "fin_tip_chord_in", "fin_thickness_in")
    )
    side = np.cross(out, [1.0, 0.0, 0.0])
    rings = []
    for share in (-0.06, 0.0, 0.97, 1.0):
        c = chord + (tip - chord) * share
        t = thick * c / chord / 2.0 * (0.55 if share == 1.0 else 1.0)
        section = ((0.5, 0.0), (0.42, 0.55), (0.25, 0.9), (0.05, 1.0), (-0.25, 0.62), (-0.5, 0.06))
        outline = [*section, *((s, -w) for s, w in section[:0:-1])]
        base = root + out * span * share + np.array([x - 0.12 * (chord - c), 0.0, 0.0])
        rings.append(np.array([base + np.array([s * c, 0.0, 0.0]) + side * (w * t) for s, w in outline]))
    mesh.loft(rings)


def letters(mesh: Mesh, text: str, centre_x: float, y: float, pixel: float) -> None:
    """Block letters just outside the side at y, to be read from outside."""
    ahead = np.sign(y)  # reading leads towards the bow on the starboard side, towards the stern on the other
    left = centre_x - ahead * pixel * (6 * len(text) - 1) / 2.0
    for place, letter in enumerate(text):
        for row, height, first, last in strokes(FONT[letter]):
            x0, x1 = (left + ahead * pixel * (6 * place + column) for column in (first, last))
            z0, z1 = pixel * (row - 3.5), pixel * (row + height - 3.5)
            corners = np.array([(x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1)])
            mesh.add(corners, np.array([(0, 1, 2), (0, 2, 3)]), np.array([x0, 0.0, z0]))


def strokes(rows: tuple[int, ...]) -> list[tuple[int, int, int, int]]:
    """Rectangles (row, height, first column, end column) that cover a letter: uprights first, then runs in a row."""
    grid = np.array([[bits >> (4 - column) & 1 for column in range(5)] for bits in rows], dtype=bool)
    found = []
    for down in (True, False):
        for row, column in np.argwhere(grid):
            line = grid[row:, column] if down else grid[row, column:]
            length = int(np.argmin(line)) if not line.all() else len(line)
            if grid[row, column] and (length > 2 or not down):
                found.append(
                    (int(row), length, int(column), int(column) + 1)
                    if down
                    else (int(row), 1, int(column), int(column) + length)
                )
                line[:length] = False
    return found


def meshes(numbers: dict) -> dict[str, Mesh]:
    """All meshes by name, one per colour."""
    names = ("hull", "nose", "tunnel", "dark", "bronze", "marks", "steel")
    parts = {name: Mesh() for name in names}
    hull, sites = Hull(numbers), numbers["sites"]
    hull.draw(parts["hull"], parts["nose"], parts["tunnel"], parts["dark"], parts["bronze"])
    for x_m in numbers["hull"]["fin_axis_m"]["value"]:
        x = x_m / INCH_M
        height, width = hull.section(x)
        for out in np.eye(3)[[1, 1, 2, 2]] * np.array([[1], [-1], [1], [-1]]):
            fin(parts["dark"], x, out * np.array([0.0, width, height]) / 2.0, out, numbers["hull"])
    for hand, name in ((1.0, "propeller_port_m"), (-1.0, "propeller_starboard_m")):
        x, y, z = np.array(sites[name]["value"]) / INCH_M
        radius = numbers["propeller"]["diameter_m"]["value"] / INCH_M / 2.0
        propeller(parts["bronze"], np.array([x, y, z]), 0, radius, 4, hand)
        parts["dark"].turned(
            (x, y, z),
            0,
            [(-1.1, radius + 0.18), (-0.7, radius + 0.3), (0.6, radius + 0.36), (1.2, radius + 0.3)],
            inner=radius + 0.1,
            count=FINE,
        )
        parts["steel"].turned((x, y, z), 0, [(0.8, 0.45), (1.4, 0.75), (9.0, 0.95)])
        parts["steel"].box((x + 0.75, y - 0.12, z - radius - 0.2), (x + 1.6, y + 0.12, z + radius + 0.2))
    sonar_heads(parts, sites, hull)
    deck(parts, hull)
    for y in (-8.27, 8.27):
        letters(parts["marks"], "PHOENIX", -3.0, y, 0.72)
    return parts


def sonar_heads(parts: dict[str, Mesh], sites: dict, hull: Hull) -> None:
    """Two heads on stalks; the pale band is the transducer window, at the sonar's site."""
    for name in ("sonar_st1000_m", "sonar_st725_m"):
        x, y, z = np.array(sites[name]["value"]) / INCH_M
        out = np.sign(z)
        parts["dark"].turned((x, y, z), 2, [(-out * 3.4, 1.15), (-out * 0.75, 1.15)])
        parts["bronze"].turned((x, y, z), 2, [(-out * 0.75, 1.05), (out * 0.55, 1.05)])
        parts["dark"].turned((x, y, z), 2, [(out * 0.55, 1.15), (out * 1.0, 1.1), (out * 1.3, 0.8), (out * 1.42, 0.35)])


def deck(parts: dict[str, Mesh], hull: Hull) -> None:
    """Hatch and two lifting eyes: as on any such vehicle, not from a source."""
    top = -hull.section(0.0)[0] / 2.0
    parts["nose"].loft(
        [
            np.array([(x, y, z) for x, y in rounded(-2.5, 0.0, 13.0, 6.0 - inset, 1.5)])
            for z, inset in ((top + 0.1, 0.0), (top - 0.22, 0.0), (top - 0.3, 0.1))
        ]
    )
    for x in (17.5, -25.0):
        for low, high in (
            ((-1.0, -0.25, -1.4), (-0.6, 0.25, 0.2)),
            ((0.6, -0.25, -1.4), (1.0, 0.25, 0.2)),
            ((-1.0, -0.25, -1.8), (1.0, 0.25, -1.4)),
        ):
            parts["steel"].box((x + low[0], low[1], top + low[2]), (x + high[0], high[1], top + high[2]))


def rounded(cx: float, cy: float, a: float, b: float, radius: float) -> list[tuple[float, float]]:
    points = []
    for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        for k in range(ARC + 1):
            angle = np.pi / 2.0 * (quarter + k / ARC)
            points.append(
                (cx + sx * (a - radius) + radius * np.cos(angle), cy + sy * (b - radius) + radius * np.sin(angle))
            )
    return points


def shape_xml() -> str:
    """The whole of phoenix_shape.xml."""
    numbers = tomllib.loads((HERE / "phoenix.toml").read_text(encoding="utf-8"))
    body = "".join(mesh.xml(name) for name, mesh in meshes(numbers).items())
    return f"<!-- Written by draw_phoenix.py from phoenix.toml: change those, not this. -->\n<mujoco>\n  <asset>\n{body}  </asset>\n</mujoco>\n"


if __name__ == "__main__":
    (HERE / "phoenix_shape.xml").write_text(shape_xml(), encoding="utf-8")
