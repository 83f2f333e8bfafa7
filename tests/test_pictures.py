"""Pictures of the tank, with OpenGL and without."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from vtank.errors import InputError
from vtank.tank import load_model, render
from vtank.tank.drawing import draw_tank, echo, write_png


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return load_model()


def yellow(path: Path) -> np.ndarray:
    """Share of each column of the picture that has the colour of the hull, shape (width,)."""
    from matplotlib.image import imread

    red, green, blue = np.moveaxis(imread(path)[:, :, :3], -1, 0)
    return np.mean((red > 0.5) & (green > 0.35) & (blue < 0.35) & (red > green), axis=0)


def test_png_holds_the_image(tmp_path: Path) -> None:
    from matplotlib.image import imread

    image = np.random.default_rng(1).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    write_png(tmp_path / "noise.png", image)
    assert np.array_equal(np.rint(255.0 * imread(tmp_path / "noise.png")[:, :, :3]), image)


def test_mujoco_renders_the_vehicle(model: mujoco.MjModel, tmp_path: Path) -> None:
    path = tmp_path / "side.png"
    try:
        render.render_png(path, model, camera="side", width=300, height=200)
    except render.RenderUnavailable as reason:
        pytest.skip(f"no OpenGL here: {reason}")
    assert 0.01 < yellow(path).mean() < 0.2


def test_without_opengl_the_tank_is_drawn(
    model: mujoco.MjModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(render, "BACKENDS", ("no-such-library",))
    path = tmp_path / "tank.png"
    assert "no-such-library" in render.picture(path, model)
    assert 0.005 < yellow(path).mean() < 0.2


def test_the_vehicle_is_drawn_where_it_is(model: mujoco.MjModel, tmp_path: Path) -> None:
    """The hull moves across the picture in proportion to the vehicle's way ahead."""
    columns = []
    for ahead in (0.0, 0.5, 1.0):
        draw_tank(tmp_path / "tank.png", model, model.qpos0 + np.array([ahead, 0, 0, 0, 0, 0, 0]))
        columns.append(np.flatnonzero(yellow(tmp_path / "tank.png"))[0])
    assert columns[2] - columns[0] > 50
    assert columns[2] - columns[1] == pytest.approx(columns[1] - columns[0], abs=2)


def test_the_beam_ends_at_the_nearest_wall(model: mujoco.MjModel) -> None:
    """A hull yawed by psi about its origin hears the wall at (d - x cos psi + y sin psi) / cos psi."""
    data, yaw, offset = mujoco.MjData(model), 0.15, model.site("sonar_st1000").pos
    mujoco.mju_mulQuat(data.qpos[3:7], model.qpos0[3:7], np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]))
    mujoco.mj_forward(model, data)
    start, end = echo(model, data, "sonar_st1000")
    wall = model.geom("wall_ahead").pos[0]
    expected = (wall - offset[0] * np.cos(yaw) + offset[1] * np.sin(yaw)) / np.cos(yaw)
    assert np.linalg.norm(end - start) == pytest.approx(expected, abs=1e-9)


def test_a_beam_needs_its_sonar(model: mujoco.MjModel, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="sonar_x"):
        draw_tank(tmp_path / "tank.png", model, sonar="sonar_x")
