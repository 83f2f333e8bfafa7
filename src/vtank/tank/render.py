"""Pictures of the tank: MuJoCo's renderer where OpenGL works, a drawing by matplotlib where it does not.

MuJoCo binds to one OpenGL library when it is imported, and a broken driver can end the process. So each library is
tried in a process of its own: EGL first (libegl1 and libgl1-mesa-dri on Debian), then OSMesa (libosmesa6).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from .drawing import draw_tank, echo, write_png

BACKENDS = ("egl", "osmesa")
BEAM_RGBA = (0.15, 0.85, 1.0, 1.0)
SHADOWLESS = mujoco.mjtGeom.mjGEOM_LINE  # the only shape that throws no shadow


class RenderUnavailable(Exception):
    """No OpenGL library could draw; the message says what each one answered."""


def picture(path: str | Path, model: mujoco.MjModel) -> str:
    """Write a PNG by the best means there are; returns a line that says which, for the user."""
    try:
        render_png(path, model)
    except RenderUnavailable as reason:
        draw_tank(path, model)
        return f"drawn without OpenGL ({reason})"
    return "rendered by MuJoCo"


def render_png(
    path: str | Path, model: mujoco.MjModel, camera: str = "overview", width: int = 1200, height: int = 800
) -> None:
    """Render the tank at its start to a PNG of width x height [pixels], with the beam of the first sonar to its echo.

    Cameras of basin.xml: overview, side, ahead, chase, plan. Raises RenderUnavailable where no OpenGL library works.
    """
    job: dict[str, Any] = {"path": str(path), "camera": camera, "width": width, "height": height}
    answers = []
    with tempfile.TemporaryDirectory() as folder:
        job["model"] = str(Path(folder) / "tank.mjb")
        mujoco.mj_saveModel(model, job["model"])
        for backend in BACKENDS:
            answer = in_child(__name__, backend, job)
            if answer is None:
                return
            answers.append(f"{backend}: {answer}")
    raise RenderUnavailable("; ".join(answers))


def in_child(module: str, backend: str, job: dict[str, Any], wait_s: float = 120.0) -> str | None:
    """Run a module, of tank, in a process bound to one OpenGL library; None, or the last line of its complaint."""
    source = str(Path(__file__).resolve().parents[2])
    search = os.pathsep.join(filter(None, (source, os.environ.get("PYTHONPATH"))))
    environment = {key: value for key, value in os.environ.items() if key != "PYOPENGL_PLATFORM"}
    environment |= {"MUJOCO_GL": backend, "PYTHONPATH": search}
    try:
        done = subprocess.run(
            [sys.executable, "-m", module],
            input=json.dumps(job),
            env=environment,
            capture_output=True,
            text=True,
            timeout=wait_s,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return type(error).__name__
    if done.returncode == 0:
        return None
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else f"ended with code {done.returncode}"


def _render(job: dict[str, Any]) -> None:
    """The child's part: draw one frame with the OpenGL library this process is bound to."""
    model = mujoco.MjModel.from_binary_path(job["model"])
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    options = mujoco.MjvOption()
    options.geomgroup[:] = 1
    options.sitegroup[:] = 0
    with mujoco.Renderer(model, job["height"], job["width"]) as renderer:
        renderer.update_scene(data, job["camera"], options)
        under_water = data.cam_xpos[model.camera(job["camera"]).id][2] < 0.0
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = int(under_water)
        _add_beam(renderer.scene, *echo(model, data))
        image = renderer.render()
    write_png(job["path"], image)


def _add_beam(scene: mujoco.MjvScene, start: np.ndarray, end: np.ndarray) -> None:
    line = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(line, SHADOWLESS, np.zeros(3), np.zeros(3), np.zeros(9), np.array(BEAM_RGBA, np.float32))
    mujoco.mjv_connector(line, SHADOWLESS, 3.0, start, end)
    line.emission = 1.0
    scene.ngeom += 1


if __name__ == "__main__":
    _render(json.loads(sys.stdin.read()))
