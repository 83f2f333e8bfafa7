"""A flight as a film or in MuJoCo's viewer, with a recording as a ghost beside it.

A film is rendered in a process of its own, as a picture is (render.py): EGL first, then OSMesa.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from ..errors import InputError
from .model import vehicle_body
from .poses import UP, Poses, set_pose
from .render import BACKENDS, in_child

GHOST_RGBA, WAY_RGBA, WATER_RGBA = (0.2, 0.75, 1.0, 0.35), (0.98, 0.72, 0.08, 1.0), (0.45, 0.68, 0.74, 1.0)
FRAMES_PER_S = 25
SIZE = (960, 640)  # [px] width and height of a film, multiples of 16; a choice
LONGEST_S = 12.0  # [s] of film, by which long flights are sped up; a choice
WAIT_S = 600.0  # [s] for a film to be rendered, on a slow machine without a graphics card; a choice
FAR = 6.0  # times the vehicle's radius, from where it is watched in open water; a choice
SEEN = 50.0  # times the radius, to where the ground reaches around a vehicle in open water; a choice
MARKS = 60  # along the way of a flight; a choice
OVERVIEW = "overview"  # the camera of a basin that sees all of it


def film(
    path: str | Path,
    model: mujoco.MjModel,
    flown: Poses,
    ghost: Poses | None = None,
    size: tuple[int, int] = SIZE,
    longest_s: float = LONGEST_S,
) -> str:
    """Write an MP4 of that size [px], at most so long [s], and return a line that says how.

    InputError without imageio-ffmpeg (extra `film`), and where no OpenGL library works.
    """
    from ..record import write_bytes

    refuse_film(path)
    speed = max(1.0, float(np.ptp(flown.time_s)) / longest_s)
    answers = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mujoco.mj_saveModel(model, str(folder / "tank.mjb"))
        for each, poses in {"flown": flown, "ghost": ghost}.items():
            if poses:
                np.savez(folder / f"{each}.npz", **vars(poses))
        job = {"folder": name, "size": size, "speed": speed}
        for backend in BACKENDS:
            answer = in_child(__name__, backend, job, WAIT_S)
            if answer is None:
                write_bytes(path, (folder / "film.mp4").read_bytes())
                return f"rendered by MuJoCo at {speed:.3g} times the true speed"
            answers.append(f"{backend}: {answer}")
    raise InputError(f"{path}: no film, no OpenGL library works here ({'; '.join(answers)})")


def refuse_film(path: str | Path) -> None:
    """InputError for a file that is no MP4 by its name, and without imageio-ffmpeg."""
    if Path(path).suffix.lower() != ".mp4":
        raise InputError(f"{path}: films are MP4, expected a name that ends in .mp4")
    if not find_spec("imageio_ffmpeg"):
        raise InputError(f"{path}: a film is written with imageio-ffmpeg, which is not here; pip install 'vtank[film]'")


def refuse_window() -> None:
    """InputError where no window can be opened."""
    if sys.platform == "linux" and not {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys():
        raise InputError("no window can be opened here, expected a display; --film OUT.mp4 needs none")


def show(model: mujoco.MjModel, flown: Poses, ghost: Poses | None = None) -> None:
    """Play a flight over and over in MuJoCo's viewer until it is closed; InputError where there is no window."""
    refuse_window()
    import mujoco.viewer

    stage = Stage(model, flown, ghost)
    try:
        window = mujoco.viewer.launch_passive(model, stage.data)
    except RuntimeError as error:  # macOS without mjpython, among others
        raise InputError(f"MuJoCo's viewer cannot be opened ({error})") from None
    with window as viewer:
        started = time.monotonic()
        while viewer.is_running():
            span = float(np.ptp(flown.time_s)) or 1.0
            with viewer.lock():
                now = float(flown.time_s[0]) + (time.monotonic() - started) % span
                stage.set(now)
                viewer.user_scn.ngeom = 0
                stage.dress(viewer.user_scn, now)
            viewer.sync()
            time.sleep(1.0 / FRAMES_PER_S)


class Stage:
    """A vehicle and its ghost at one moment."""

    def __init__(self, model: mujoco.MjModel, flown: Poses, ghost: Poses | None) -> None:
        """Both at their start."""
        self.model, self.flown, self.ghost = model, flown, ghost
        self.data, self.other = mujoco.MjData(model), mujoco.MjData(model)
        self.options = mujoco.MjvOption()
        self.options.geomgroup[:] = 1
        self.options.sitegroup[:] = 0
        body = vehicle_body(model)
        own = model.geom_bodyid == body
        self.radius_m = float(
            np.linalg.norm(np.abs(model.geom_pos[own]) + model.geom_rbound[own, None], axis=1).max(initial=0.5)
        )
        first = model.jnt_qposadr[model.body_jntadr[body]]
        self.start_m = model.qpos0[first : first + 3].copy()
        self.open = OVERVIEW not in {model.camera(k).name for k in range(model.ncam)}
        deepest = max(float(poses.place_m[:, 2].max()) for poses in (flown, ghost) if poses)
        self.ground_m = self.start_m[2] - deepest - 2.0 * self.radius_m

    def set(self, time_s: float) -> None:
        """Set both where they were at a time."""
        set_pose(self.model, self.data, self.flown, time_s)
        if self.ghost:
            set_pose(self.model, self.other, self.ghost, time_s)

    def add_ghost(self, scene: mujoco.MjvScene) -> None:
        """Add the vehicle's shapes at the ghost's place to a scene, to be seen through."""
        if self.ghost is None:
            return
        first, moving = scene.ngeom, mujoco.mjtCatBit.mjCAT_DYNAMIC
        mujoco.mjv_addGeoms(self.model, self.other, self.options, mujoco.MjvPerturb(), moving, scene)
        for geom in scene.geoms[first : scene.ngeom]:
            geom.rgba[:], geom.matid = GHOST_RGBA, -1

    def dress(self, scene: mujoco.MjvScene, time_s: float) -> None:
        """Add the ghost, the way that each has come, and in open water a ground, to a scene."""
        scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0  # three times as fast without a graphics card
        self.add_ghost(scene)
        if self.open:
            under = self.start_m + UP @ self.flown.at(time_s)[0]
            _add(
                scene,
                mujoco.mjtGeom.mjGEOM_BOX,
                (*under[:2], self.ground_m),
                (*2 * (SEEN * self.radius_m,), 0.01),
                WATER_RGBA,
            )
        for poses, rgba in ((self.flown, WAY_RGBA), (self.ghost, GHOST_RGBA)):
            if poses is None:
                continue
            steps = np.linspace(poses.time_s[0], poses.time_s[-1], MARKS)
            for at_s in steps[steps <= time_s]:
                place = self.start_m + UP @ poses.at(float(at_s))[0]
                _add(scene, mujoco.mjtGeom.mjGEOM_SPHERE, place, (self.radius_m / 40.0,) * 3, (*rgba[:3], 1.0))

    def camera(self) -> mujoco.MjvCamera:
        """The tank's overview; in open water, abeam of the vehicle and going with it."""
        camera = mujoco.MjvCamera()
        if not self.open:
            camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, self.model.camera(OVERVIEW).id
            return camera
        camera.type, camera.trackbodyid = mujoco.mjtCamera.mjCAMERA_TRACKING, vehicle_body(self.model)
        camera.distance, camera.azimuth, camera.elevation = FAR * self.radius_m, 120.0, -35.0
        return camera


def _add(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, place: Any, size: tuple[float, ...], rgba: tuple[float, ...]
) -> None:
    """A geom that is there for the eye only, where the scene has room for it."""
    if scene.ngeom < scene.maxgeom:
        turn = np.eye(3).ravel()
        geom = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(geom, kind, np.array(size), np.asarray(place), turn, np.array(rgba, np.float32))
        scene.ngeom += 1


def _render(job: dict[str, Any]) -> None:
    """The child's part: render all frames and write the film."""
    import imageio_ffmpeg

    folder = Path(job["folder"])
    model = mujoco.MjModel.from_binary_path(str(folder / "tank.mjb"))
    width, height = model.vis.global_.offwidth, model.vis.global_.offheight = job["size"]
    flown, ghost = (_poses(folder / f"{name}.npz") for name in ("flown", "ghost"))
    assert flown is not None
    stage = Stage(model, flown, ghost)
    model.vis.quality.offsamples = 0  # edges are smoothed by the film itself; twice as fast without a graphics card
    if stage.open:
        model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.5, 0.6
    camera = stage.camera()
    writer = imageio_ffmpeg.write_frames(
        str(folder / "film.mp4"), (width, height), fps=FRAMES_PER_S, ffmpeg_log_level="error"
    )
    writer.send(None)
    with mujoco.Renderer(model, height, width) as renderer:
        for at_s in np.arange(flown.time_s[0], flown.time_s[-1], job["speed"] / FRAMES_PER_S):
            stage.set(float(at_s))
            renderer.update_scene(stage.data, camera, stage.options)
            stage.dress(renderer.scene, float(at_s))
            writer.send(np.ascontiguousarray(renderer.render()))
    writer.close()


def _poses(path: Path) -> Poses | None:
    if not path.exists():
        return None
    with np.load(path) as found:
        return Poses(**found)


if __name__ == "__main__":
    _render(json.loads(sys.stdin.read()))
