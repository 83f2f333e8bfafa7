"""Triangle meshes for pictures, in inches as the sources print them, written to MJCF in metres."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

INCH_M = 0.0254
ROUND = 16  # segments per circle, a multiple of 8
FINE = 32  # segments per large circle

Point = tuple[float, float, float] | np.ndarray
Profile = list[tuple[float, float]]  # (station along an axis, radius)


class Mesh:
    """Triangles under construction: vertices [in] and faces, wound so that normals point out of the solid."""

    def __init__(self) -> None:
        self.vertices: list[np.ndarray] = []
        self.faces: list[tuple[int, int, int]] = []

    def add(self, points: np.ndarray, faces: np.ndarray, inside: np.ndarray) -> None:
        """Add a part, each face turned so that its normal points away from `inside`, shape (3,) or (F, 3)."""
        start = len(self.vertices)
        corners = points[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inward = np.einsum("fi,fi->f", normals, corners.mean(axis=1) - inside) < 0.0
        faces = np.where(inward[:, None], faces[:, ::-1], faces)
        faces = faces[np.linalg.norm(normals, axis=1) > 1e-9]
        self.vertices.extend(points)
        self.faces.extend((start + a, start + b, start + c) for a, b, c in faces)

    def loft(self, rings: list[np.ndarray], capped: bool = True, openings: set[tuple[int, int]] | None = None) -> None:
        """Skin closed rings, each shape (K, 3), leaving the quads (ring, segment) of `openings` out."""
        count = len(rings[0])
        faces, inside = [], []
        for row, (near, far) in enumerate(pairwise(rings)):
            for k in range(count):
                if (row, k) not in (openings or ()):
                    a, b = row * count + k, row * count + (k + 1) % count
                    faces += [(a, b, a + count), (b, b + count, a + count)]
                    inside += [(near.mean(axis=0) + far.mean(axis=0)) / 2.0] * 2
        self.add(np.concatenate(rings), np.array(faces), np.array(inside))
        if capped:
            self.cap(rings[0], rings[1])
            self.cap(rings[-1], rings[-2])

    def cap(self, ring: np.ndarray, following: np.ndarray) -> None:
        """Close the end of a loft."""
        count = len(ring)
        fan = np.array([(k, (k + 1) % count, count) for k in range(count)])
        self.add(np.vstack([ring, ring.mean(axis=0)]), fan, following.mean(axis=0))

    def box(self, low: Point, high: Point) -> None:
        """A box along the axes."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        self.loft([np.array([(x, y0, z0), (x, y1, z0), (x, y1, z1), (x, y0, z1)]) for x in (x0, x1)])

    def turned(self, centre: Point, axis: int, profile: Profile, count: int = ROUND) -> None:
        """A solid of revolution about a body axis through `centre`."""
        self.loft([circle(centre, axis, station, radius, count) for station, radius in profile])

    def tube(self, centre: Point, axis: int, profile: Profile, inner: float) -> None:
        """A solid of revolution with a bore of radius `inner`."""
        rings = [circle(centre, axis, station, radius, FINE) for station, radius in profile]
        holes = [circle(centre, axis, profile[k][0], inner, FINE) for k in (0, -1)]
        self.loft(rings, capped=False)
        self.bore(holes)
        self.washer(rings[0], holes[0], holes[1].mean(axis=0))
        self.washer(rings[-1], holes[1], holes[0].mean(axis=0))

    def bore(self, rings: list[np.ndarray]) -> None:
        """The wall of a hole."""
        wall = Mesh()
        wall.loft(rings, capped=False)
        start = len(self.vertices)
        self.vertices.extend(wall.vertices)
        self.faces.extend((start + c, start + b, start + a) for a, b, c in wall.faces)

    def washer(self, outer: np.ndarray, inner: np.ndarray, inside: np.ndarray) -> None:
        """A flat face between two rings of equal count."""
        k = np.arange(len(outer))
        j, hole = np.roll(k, -1), len(outer)
        faces = np.vstack([np.column_stack([k, j, hole + k]), np.column_stack([j, hole + j, hole + k])])
        self.add(np.vstack([outer, inner]), faces, inside)

    def xml(self, name: str) -> str:
        """The mesh as an MJCF asset."""
        vertices = " ".join(_short(value) for point in self.vertices for value in point * INCH_M)
        faces = " ".join(str(index) for face in self.faces for index in face)
        return f'    <mesh name="{name}" inertia="shell"\n      vertex="{vertices}"\n      face="{faces}"/>\n'


def circle(centre: Point, axis: int, station: float, radius: float, count: int) -> np.ndarray:
    """Ring about a body axis, shape (count, 3)."""
    angle = 2.0 * np.pi * np.arange(count) / count + np.pi / 4.0
    ring = np.tile(np.array(centre, dtype=float), (count, 1))
    ring[:, axis] += station
    ring[:, (axis + 1) % 3] += radius * np.cos(angle)
    ring[:, (axis + 2) % 3] += radius * np.sin(angle)
    return ring


def rounded(a: float, b: float, radius: float, segments: int = 6) -> np.ndarray:
    """Rectangle 2a x 2b with rounded corners, shape (4 (segments + 1), 2), from the corner (+, +) on."""
    arcs = []
    for quarter, signs in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angle = np.pi / 2.0 * (quarter + np.arange(segments + 1) / segments)
        centre = np.array(signs) * (a - radius, b - radius)
        arcs.append(centre + radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    return np.concatenate(arcs)


def _short(metres: float) -> str:
    """A coordinate to 0.1 mm in as few characters as possible."""
    text = f"{metres:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text.replace("0.", ".", 1) if abs(metres) < 1.0 else text
