"""Flights to look at: poses from scenarios and recordings, set in a model, filmed."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import fly_vehicle
from vtank.plant.vehicle import load_vehicle
from vtank.record import Run, write_run
from vtank.tank.film import Stage, film, show
from vtank.tank.poses import Poses, set_pose
from vtank.tank.whole import load_whole
from vtank.tank.world import load_model
from vtank.viewed import _watched, of_run, view

T = np.arange(0.0, 2.0, 0.1)


def poses(place: tuple[float, ...], attitude: tuple[float, ...]) -> Poses:
    return Poses(T, np.outer(np.ones(T.size), place), np.outer(np.ones(T.size), attitude))


@pytest.mark.parametrize("name", ["phoenix", "bluerov2"])
def test_a_pose_is_set_where_it_was(name: str) -> None:
    """A site of the body goes where place, heading, pitch and roll take it, by hand."""
    model = load_whole(load_vehicle(name)).model
    data, start = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_forward(model, start)
    set_pose(model, data, poses((2.0, 1.0, 0.5), (0.0, 0.0, np.pi / 2)), 1.0)  # heading east
    (x, y, z), origin = load_vehicle(name).sites["hull_bow"], start.site("hull_bow").xpos - [0, 0, 0]
    moved = data.site("hull_bow").xpos - origin
    assert np.allclose(moved, [2.0 - x - y, -1.0 - x + y, -0.5], atol=1e-6)  # world: x north, y west, z up
    set_pose(model, data, poses((0.0, 0.0, 0.0), (0.0, 0.2, 0.0)), 1.0)  # bow up
    assert (data.site("hull_bow").xpos - origin)[2] == pytest.approx(x * np.sin(0.2) + z - z * np.cos(0.2), abs=1e-6)
    set_pose(model, data, poses((0.0, 0.0, 0.0), (0.3, 0.0, 0.0)), 1.0)  # starboard side down
    side = load_vehicle(name).thrusters[0].site
    sx, sy, sz = load_vehicle(name).sites[side]
    lower = start.site(side).xpos[2] - data.site(side).xpos[2]
    assert lower == pytest.approx(sy * np.sin(0.3) + sz * (np.cos(0.3) - 1.0), abs=1e-6)


def test_poses_of_a_flight_are_those_that_its_eye_saw() -> None:
    table = {"time_s": [0.0], "port_command": [0.6], "starboard_command": [0.2]}
    run = fly_vehicle(_watched(load_vehicle("kingfisher")), table, 6.0, seed=1)
    seen = of_run(run)
    assert seen.place_m[-1, 0] > 1.0 and seen.attitude_rad[-1, 2] > 0.2  # ahead, and to starboard
    assert np.allclose(seen.place_m[:, 0], run.samples("eye.north_m")[1] - run.samples("eye.north_m")[1][0])


@pytest.mark.parametrize(
    "column, values", [("position_m", 3.0 + 0.5 * T), ("range_m", 8.0 - 0.5 * T), ("surge_m_s", 0.5 + 0.0 * T)]
)
def test_a_run_along_one_axis_goes_straight_ahead(column: str, values: np.ndarray) -> None:
    seen = of_run(Run("run", T, {"n_rev_s": T, column: values}))
    assert np.allclose(seen.place_m[:, 0], 0.5 * T) and not seen.place_m[:, 1:].any() and not seen.attitude_rad.any()


def test_a_run_that_tells_no_place_is_refused() -> None:
    with pytest.raises(InputError, match="run run: tells nothing of a place"):
        of_run(Run("run", T, {"heading_rad": T}))


def test_a_recording_is_a_ghost_beside_the_simulation_of_its_commands(tmp_path: Path) -> None:
    table = {"time_s": [0.0, 2.0], "port_command": [0.6, 0.0], "starboard_command": [0.6, 0.0]}
    run = fly_vehicle("kingfisher", table, 6.0, seed=1)
    write_run(tmp_path / "run.csv", run)
    seen = view(tmp_path / "run.csv", vehicle="kingfisher")
    assert seen.ghost is not None
    assert np.abs(seen.flown.at(5.0)[0][0] - seen.ghost.at(5.0)[0][0]) < 2.5  # the GPS's noise is 0.5 m, twice
    with pytest.raises(InputError, match="of which vehicle"):
        view(tmp_path / "run.csv")


def test_a_recorded_surge_run_stands_beside_the_nominal(tmp_path: Path) -> None:
    t = np.arange(0.0, 20.0, 0.1)
    write_run(tmp_path / "run.csv", Run("run", t, {"n_rev_s": 8.0 + 0.0 * t, "range_m": 9.0 - 0.1 * t}))
    seen = view(tmp_path / "run.csv")
    assert seen.ghost is not None and seen.ghost.place_m[-1, 0] == pytest.approx(1.99, abs=1e-6)
    assert seen.flown.place_m[-1, 0] > 1.0 and np.array_equal(seen.flown.time_s, seen.ghost.time_s)


def test_the_ghost_is_drawn_where_it_was() -> None:
    stage = Stage(load_model(), poses((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), poses((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    stage.set(1.0)
    assert np.allclose(stage.other.qpos[:3] - stage.data.qpos[:3], [1.0, 0.0, 0.0])


def test_a_film_is_written_whole(tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    model = load_whole(load_vehicle("kingfisher")).model
    ahead = Poses(T, np.outer(T, [0.5, 0.0, 0.0]), np.zeros((T.size, 3)))
    try:
        said = film(tmp_path / "out.mp4", model, ahead, poses((0.0, 0.5, 0.0), (0.0, 0.0, 0.3)), (160, 112))
    except InputError as reason:
        pytest.skip(str(reason))
    assert "1 times the true speed" in said
    import imageio_ffmpeg

    frames = imageio_ffmpeg.read_frames(str(tmp_path / "out.mp4"))
    about = next(frames)
    pictures = [np.frombuffer(frame, np.uint8) for frame in frames]
    assert about["size"] == (160, 112) and len(pictures) == pytest.approx(1.9 * 25, abs=3)
    assert pictures[0].std() > 5.0 and not np.array_equal(pictures[0], pictures[-1])


def test_the_corrected_simulator_may_stand_beside_a_run(tmp_path: Path) -> None:
    t = np.arange(0.0, 20.0, 0.1)
    write_run(tmp_path / "run.csv", Run("run", t, {"n_rev_s": 8.0 + 0.0 * t, "range_m": 9.0 - 0.1 * t}))
    slow, fast = (view(tmp_path / "run.csv", truth=truth).flown.place_m[-1, 0] for truth in ("paper-ii", "physical"))
    assert fast > 1.5 * slow  # a twenty-eighth of the drag
    with pytest.raises(InputError, match="truth paper-ii: goes with experiments of one axis"):
        view("whole/zigzag", truth="paper-ii")


def test_a_folder_is_told_from_a_run_and_from_a_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "dives").mkdir()
    write_run(tmp_path / "dives" / "a.csv", Run("a", T, {"n_rev_s": T, "range_m": T}))
    with pytest.raises(InputError, match="dives: is a folder; expected one run of it, such as a.csv"):
        view(tmp_path / "dives")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "paper-ds1").mkdir()  # of the user's, with the name of a scenario
    assert view("paper-ds1", settings=["duration_s=2"]).flown.time_s[-1] == pytest.approx(2.0)


def test_a_name_is_asked_for_before_a_display(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("vtank.tank.film.refuse_window", None)  # would fail
    assert main(["view", "paper-ds"]) == 2
    assert (
        "no scenario named 'paper-ds'; did you mean 'paper-ds4'? there are: paper-ds1, paper-ds2, "
        in capsys.readouterr().err
    )


def test_what_cannot_be_filmed_is_refused_before_anything_is_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("vtank.viewed.view", None)  # would fail
    assert main(["view", "paper-ds1", "--film", str(tmp_path / "out.avi")]) == 2
    assert "out.avi: films are MP4, expected a name that ends in .mp4" in capsys.readouterr().err


def test_without_opengl_there_is_no_film_and_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("imageio_ffmpeg")
    monkeypatch.setattr("vtank.tank.film.BACKENDS", ("no-such-library",))
    still = poses((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="no film, no OpenGL library works here .no-such-library: "):
        film(tmp_path / "out.mp4", load_model(), still)
    assert not list(tmp_path.iterdir())


def test_without_a_display_or_the_library_it_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(0.0, 20.0, 0.1)
    write_run(tmp_path / "run.csv", Run("run", t, {"n_rev_s": 8.0 + 0.0 * t, "position_m": 0.1 * t}))
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert main(["view", str(tmp_path / "run.csv")]) == 2
    assert "--film OUT.mp4 needs none" in capsys.readouterr().err
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    assert main(["view", str(tmp_path / "run.csv"), "--film", str(tmp_path / "out.mp4")]) == 2
    assert "pip install 'vtank[film]'" in capsys.readouterr().err


def test_the_viewer_plays_until_it_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    import contextlib

    import mujoco.viewer

    class Window(contextlib.AbstractContextManager):  # type: ignore[type-arg]
        """A stand-in for MuJoCo's window that is closed after three pictures."""

        def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
            self.user_scn, self.data, self.pictures = mujoco.MjvScene(model, 2000), data, []

        def __exit__(self, *error: object) -> None:
            seen.extend(self.pictures)

        def is_running(self) -> bool:
            return len(self.pictures) < 3

        def lock(self) -> contextlib.AbstractContextManager[None]:
            return contextlib.nullcontext()

        def sync(self) -> None:
            self.pictures.append((self.user_scn.ngeom, float(self.data.qpos[0])))

    seen: list[tuple[int, float]] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(mujoco.viewer, "launch_passive", Window)
    ahead = Poses(T, np.outer(T, [2.0, 0.0, 0.0]), np.zeros((T.size, 3)))
    show(load_model(), ahead, ahead)
    assert len(seen) == 3 and seen[0][0] > 5 and seen[2][1] > seen[0][1]
