"""The tank drawn from its MJCF geometry by matplotlib, in plan and side view: needs no OpenGL."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from ..units import FOOT_M
from .model import HEARD, TANK_GROUP, site, sonars

LAMP = np.array([-0.25, -0.45, 0.86])  # direction towards the light, world axes
CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # corners of CUBE, outward
CUBE_FACES = np.array([face for a, b, c, d in SIDES for face in ((a, b, c), (a, c, d))])


def write_png(path: str | Path, image: np.ndarray) -> None:
    """Write an image, shape (height, width, 3), 8 bits, as a PNG file."""
    from matplotlib.image import imsave

    imsave(path, image, format="png")


def draw_tank(path: str | Path, model: mujoco.MjModel, qpos: np.ndarray | None = None, sonar: str = "") -> None:
    """Write a drawing (PNG, PDF or SVG by the ending of `path`) of the tank with the vehicle at qpos, shape (7,)."""
    from matplotlib.figure import Figure

    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0 if qpos is None else qpos
    mujoco.mj_forward(model, data)
    beam = np.array(echo(model, data, sonar))
    figure = Figure(figsize=(9.0, 12.6), layout="constrained")
    plan, side = figure.subplots(2, 1, height_ratios=(6.6, 2.7))
    for axes, across, sight in ((plan, 1, np.array([0.0, 0.0, 1.0])), (side, 2, np.array([0.0, -1.0, 0.0]))):
        _draw_walls(axes, model, data, across)
        axes.plot(beam[:, 0], beam[:, across], color="#18a0c8", lw=1.5, zorder=4)
        _draw_vehicle(axes, model, data, across, sight)
        axes.set_aspect("equal")
        axes.margins(0.02)
    _label(plan, side, data, beam)
    figure.savefig(path, dpi=110)


def echo(model: mujoco.MjModel, data: mujoco.MjData, sonar: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Where a pencil beam along the bow starts, at the sonar's site, and where it meets a wall; shape (3,) [m] each.

    sonar: name of the site, by default the vehicle's first.

    A beam that meets nothing is drawn 5 m long.
    """
    sonar = sonar or next(iter(sonars(model)), "sonar")
    site(model, sonar)  # InputError where there is none
    start, body = data.site(sonar).xpos.copy(), model.site(sonar).bodyid[0]
    direction = data.xmat[body].reshape(3, 3)[:, 0].copy()
    distance = mujoco.mj_ray(model, data, start, direction, HEARD, 1, -1, np.zeros(1, dtype=np.int32))
    return start, start + direction * (distance if distance >= 0.0 else 5.0)


def _draw_walls(axes: Any, model: mujoco.MjModel, data: mujoco.MjData, across: int) -> None:
    """Everything a sonar hears: surfaces across the line of sight as fills, those along it as thick lines."""
    for geom in np.flatnonzero(model.geom_group == TANK_GROUP).tolist():
        corners = CUBE[[0, 2, 6, 4]] * (*model.geom_size[geom][:2], 0.0)
        points = _world(data, geom, corners)[:, [0, across]]
        thin = np.ptp(points, axis=0).min() < 1e-9
        axes.fill(*points.T, facecolor="#dcebee", edgecolor="#4a5a60", lw=3.0 if thin else 0.0, zorder=2 if thin else 1)


def _draw_vehicle(axes: Any, model: mujoco.MjModel, data: mujoco.MjData, across: int, sight: np.ndarray) -> None:
    """Shaded triangles of the vehicle's geoms, the far ones first."""
    from matplotlib.collections import PolyCollection

    triangles, colours = [], []
    for geom in np.flatnonzero(model.geom_bodyid > 0).tolist():
        corners = _triangles(model, data, geom)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-300
        facing = normals @ sight > 0.0
        shade = 0.55 + 0.45 * np.clip(normals @ LAMP, 0.0, 1.0)
        triangles.append(corners[facing])
        colours.append(np.clip(shade[facing, None] * _colour(model, geom), 0.0, 1.0))
    corners, colour = np.concatenate(triangles), np.concatenate(colours)
    order = np.argsort((corners @ sight).mean(axis=1))
    faces: Any = corners[order][:, :, [0, across]]
    axes.add_collection(PolyCollection(faces, facecolors=colour[order], edgecolors=colour[order], lw=0.6, zorder=5))


def _triangles(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> np.ndarray:
    """Triangles of a geom in world axes, shape (F, 3, 3); anything but a mesh is drawn as its bounding box."""
    mesh = model.geom_dataid[geom]
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        centre, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
        return _world(data, geom, centre + CUBE * half)[CUBE_FACES]
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return _world(data, geom, vertices)[faces]


def _world(data: mujoco.MjData, geom: int, points: np.ndarray) -> np.ndarray:
    return data.geom_xpos[geom] + points @ data.geom_xmat[geom].reshape(3, 3).T


def _colour(model: mujoco.MjModel, geom: int) -> np.ndarray:
    material = model.geom_matid[geom]
    return (model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])[:3]


def _label(plan: Any, side: Any, data: mujoco.MjData, beam: np.ndarray) -> None:
    """Titles, the water line and the distances that matter, in feet as in the paper and in metres."""
    side.axhline(0.0, color="#18a0c8", lw=1.0, ls="--", zorder=3)
    gap = beam[1, 0] - beam[0, 0]
    _dimension(plan, beam[0], beam[1], 1, f"sonar to wall {gap / FOOT_M:.1f} ft ({gap:.2f} m)")
    depth = -float(data.qpos[2])
    middle = np.array(data.qpos[:3])
    _dimension(side, middle * (1, 1, 0), middle, 2, f"{depth / FOOT_M:.1f} ft ({depth:.2f} m)")
    plan.set(title="Plan: the wall ahead is to the right", ylabel="to port [m]")
    side.set(title="Side, from starboard", xlabel="ahead of the start [m]", ylabel="height [m]")


def _dimension(axes: Any, start: np.ndarray, end: np.ndarray, across: int, text: str) -> None:
    """A dimension line, set off from what it measures."""
    upright = across == 2
    a, b = start[[0, across]].copy(), end[[0, across]].copy()
    if not upright:
        a[1] = b[1] = max(a[1], b[1]) + 0.25
    axes.annotate("", a, b, arrowprops={"arrowstyle": "<->", "color": "#303030", "lw": 0.9}, zorder=6)
    spot = (a + b) / 2.0 + ((0.08, 0.0) if upright else (0.0, 0.06))
    axes.text(
        *spot, text, ha="left" if upright else "center", va="center" if upright else "bottom", fontsize=9, zorder=6
    )
