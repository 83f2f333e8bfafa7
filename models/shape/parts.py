"""What is fitted to the hull: propellers, fins, sonar heads, deck fittings, the name."""

from __future__ import annotations

import numpy as np
from mesh import Mesh, rounded

FONT = {  # 5 x 7 block letters, one number per row
    "P": (30, 17, 17, 30, 16, 16, 16),
    "H": (17, 17, 17, 31, 17, 17, 17),
    "O": (14, 17, 17, 17, 17, 17, 14),
    "E": (31, 16, 16, 30, 16, 16, 31),
    "N": (17, 25, 25, 21, 19, 19, 17),
    "I": (14, 4, 4, 4, 4, 4, 14),
    "X": (17, 17, 10, 4, 10, 17, 17),
}


def propeller(mesh: Mesh, centre: np.ndarray, axis: int, radius: float, blades: int, hand: float = 1.0) -> None:
    """Twisted blades on a hub, about a body axis."""
    frame = np.eye(3)[[axis, (axis + 1) % 3, (axis + 2) % 3]]
    for bearing in 2.0 * np.pi * np.arange(blades) / blades:
        radial = np.array([0.0, np.cos(bearing), np.sin(bearing)]) @ frame
        around = np.array([0.0, -np.sin(bearing), np.cos(bearing)]) @ frame
        mesh.loft([centre + radius * blade_section(share, hand, radial, around, frame[0]) for share in BLADE])
    hub = 0.24 * radius
    profile = [(-1.6 * hub, 0.2 * hub), (-1.1 * hub, 0.75 * hub), (-0.5 * hub, hub), (1.4 * hub, hub)]
    mesh.turned(centre, axis, profile, count=8 * (blades // 2))


BLADE = (0.2, 0.45, 0.75, 0.95, 1.0)  # sections of a blade, share of the radius


def blade_section(share: float, hand: float, radial: np.ndarray, around: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Section at a share of the radius, for a propeller of radius 1: a flat lozenge at the local pitch."""
    pitch, chord = hand * (1.15 - 0.75 * share), 0.34 + 0.75 * share * np.sqrt(1.02 - share)
    lead = np.cos(pitch) * around + np.sin(pitch) * along
    thick = 0.035 * (np.cos(pitch) * along - np.sin(pitch) * around)
    return share * radial + np.array([-0.5 * chord * lead, thick, 0.5 * chord * lead, -thick])


def stern_drive(meshes: dict[str, Mesh], at: np.ndarray, radius: float, hand: float) -> None:
    """A stern propeller in its shroud, with shaft tube and strut."""
    propeller(meshes["bronze"], at, 0, radius, blades=4, hand=hand)
    shroud = [(-1.1, radius + 0.18), (-0.7, radius + 0.3), (0.6, radius + 0.36), (1.2, radius + 0.3)]
    meshes["dark"].tube(at, 0, shroud, inner=radius + 0.1)
    meshes["steel"].turned(at, 0, [(0.8, 0.45), (1.4, 0.75), (9.0, 0.95)])
    meshes["steel"].box(at + (0.75, -0.12, -radius - 0.2), at + (1.6, 0.12, radius + 0.2))


def fin(mesh: Mesh, root: np.ndarray, out: np.ndarray, hull: dict) -> None:
    """A tapered fin from `root` in direction `out`, with a lens-shaped section."""
    keys = ("fin_span_in", "fin_root_chord_in", "fin_tip_chord_in", "fin_thickness_in")
    span, root_chord, tip_chord, thickness = (hull[key]["value"] for key in keys)
    half = ((0.5, 0.0), (0.42, 0.55), (0.25, 0.9), (0.05, 1.0), (-0.25, 0.62), (-0.5, 0.06))
    outline = np.array([*half, *((along, -across) for along, across in half[:0:-1])])
    ahead, side = np.array([1.0, 0.0, 0.0]), np.cross(out, [1.0, 0.0, 0.0])
    rings = []
    for share, fullness in ((-0.06, 1.0), (0.0, 1.0), (0.97, 1.0), (1.0, 0.55)):
        chord = root_chord + (tip_chord - root_chord) * share
        breadth = fullness * thickness * chord / root_chord / 2.0
        base = root + out * span * share - ahead * 0.12 * (root_chord - chord)
        rings.append(base + np.outer(outline[:, 0] * chord, ahead) + np.outer(outline[:, 1] * breadth, side))
    mesh.loft(rings)


def sonar_head(meshes: dict[str, Mesh], at: np.ndarray) -> None:
    """A head on a stalk; the bronze band is the transducer, at the sonar's site."""
    out = float(np.sign(at[2]))
    meshes["dark"].turned(at, 2, [(-out * 3.4, 1.15), (-out * 0.75, 1.15)])
    meshes["bronze"].turned(at, 2, [(-out * 0.75, 1.05), (out * 0.55, 1.05)])
    meshes["dark"].turned(at, 2, [(out * 0.55, 1.15), (out * 1.0, 1.1), (out * 1.3, 0.8), (out * 1.42, 0.35)])


def deck(meshes: dict[str, Mesh], top: float) -> None:
    """Hatch and two lifting eyes: as on any such vehicle, not from a source."""
    rings = []
    for height, inset in ((-0.1, 0.0), (0.22, 0.0), (0.3, 0.1)):
        outline = rounded(13.0 - inset, 6.0 - inset, 1.5)
        rings.append(np.column_stack([outline + (-2.5, 0.0), np.full(len(outline), top - height)]))
    meshes["nose"].loft(rings)
    for x in (17.5, -25.0):
        for low, high, foot, head in ((-1.0, -0.6, -0.2, 1.4), (0.6, 1.0, -0.2, 1.4), (-1.0, 1.0, 1.4, 1.8)):
            meshes["steel"].box((x + low, -0.25, top - head), (x + high, 0.25, top - foot))


def letters(mesh: Mesh, text: str, centre_x: float, y: float, pixel: float) -> None:
    """Block letters just outside the side at y, to be read from outside."""
    ahead = np.sign(y)  # reading leads towards the bow on the starboard side, towards the stern on the other
    left = centre_x - ahead * pixel * (6 * len(text) - 1) / 2.0
    for place, letter in enumerate(text):
        for row, column, rows, columns in strokes(FONT[letter]):
            x = left + ahead * pixel * (6 * place + np.array([column, column + columns]))
            z = pixel * (np.array([row, row + rows]) - 3.5)
            corners = np.array([(x[0], y, z[0]), (x[1], y, z[0]), (x[1], y, z[1]), (x[0], y, z[1])])
            mesh.add(corners, np.array([(0, 1, 2), (0, 2, 3)]), np.array([x[0], 0.0, z[0]]))


def strokes(letter: tuple[int, ...]) -> list[tuple[int, int, int, int]]:
    """Rectangles (row, column, rows, columns) that cover a letter: long uprights first, then runs along a row."""
    grid = np.array([[bits >> (4 - column) & 1 for column in range(5)] for bits in letter], dtype=bool)
    found = []
    for upright in (True, False):
        for row, column in np.argwhere(grid):
            line = grid[row:, column] if upright else grid[row, column:]
            length = len(line) if line.all() else int(np.argmin(line))
            if length > 2 or (length and not upright):
                found.append((row, column, length, 1) if upright else (row, column, 1, length))
                line[:length] = False
    return found
