"""The MJCF against the numbers it was written from, and the tank against its stated size."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
import tomllib

import mujoco
import numpy as np
import pytest

from vtank.plant.vehicle import load_vehicle
from vtank.resources import models_dir
from vtank.tank import forces, load_model
from vtank.tank.model import HEARD
from vtank.units import FOOT_M, INCH_M, LBF_N, SLUG_KG

MODELS = models_dir()
NUMBERS = tomllib.loads((MODELS / "phoenix.toml").read_text(encoding="utf-8"))
UNITS = {
    "slug": SLUG_KG,
    "slug ft": SLUG_KG * FOOT_M,
    "slug ft2": SLUG_KG * FOOT_M**2,
    "in": INCH_M,
    "ft": FOOT_M,
    "lbf": LBF_N,
    "lbf/(ft/s)2": LBF_N / FOOT_M**2,
    "lbf ft/(rad/s)2": LBF_N * FOOT_M,
    "lbf ft/(rad/s)": LBF_N * FOOT_M,
}


def entries(content: object = NUMBERS, name: str = "phoenix") -> dict[str, dict]:
    """Every number of phoenix.toml that states an origin, by table and key."""
    if isinstance(content, dict) and "value" in content:
        return {name: content}
    parts = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    return {key: entry for part, inside in parts for key, entry in entries(inside, f"{name}.{part}").items()}


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return load_model()


@pytest.fixture(scope="module")
def data(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def distance(model: mujoco.MjModel, data: mujoco.MjData, site: str, direction: tuple[float, float, float]) -> float:
    """From a site along a world direction to the tank [m]; -1 where there is nothing."""
    start = data.site(site).xpos
    return mujoco.mj_ray(model, data, start, np.array(direction), HEARD, 1, -1, np.zeros(1, dtype=np.int32))


@pytest.mark.parametrize("key", entries())
def test_every_number_has_source_and_confidence_and_agrees_with_its_imperial_value(key: str) -> None:
    entry = entries()[key]
    assert re.fullmatch(r"(S\d(, S\d)*|-)", entry["source"])
    assert entry["confidence"] in ("H", "M", "L", "U", "guess")
    if "imperial" in entry:
        numbers, unit = re.fullmatch(r"([-\d., ]+?) ([a-z].*)", entry["imperial"]).groups()
        imperial = UNITS[unit] * np.array([float(number) for number in numbers.split(", ")])
        assert np.atleast_1d(entry["value"]) == pytest.approx(imperial, rel=3e-3, abs=1e-9)


def test_the_rigid_body_is_the_one_of_the_vehicle_file(model: mujoco.MjModel) -> None:
    body, numbers = model.body("phoenix"), NUMBERS["body"]
    assert body.mass[0] == numbers["mass_kg"]["value"] == load_vehicle().mass_kg
    assert body.inertia == pytest.approx(numbers["inertia_kg_m2"]["value"], rel=1e-12)
    assert body.iquat == pytest.approx([1.0, 0.0, 0.0, 0.0])
    assert body.ipos == pytest.approx(numbers["centre_of_gravity_m"]["value"], rel=1e-12)
    assert model.opt.gravity == pytest.approx([0.0, 0.0, -load_vehicle().buoyancy_N / body.mass[0]], rel=1e-12)


def test_no_shape_weighs_or_touches_anything(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    assert model.body_mass.sum() == NUMBERS["body"]["mass_kg"]["value"]
    hull = model.geom_bodyid > 0
    assert not model.geom_contype[hull].any() and not model.geom_conaffinity[hull].any()
    data = mujoco.MjData(model)
    data.qpos[0] = 3.0  # the bow in the wall
    mujoco.mj_forward(model, data)
    assert data.ncon == 0


def test_sites_stand_where_the_vehicle_file_says(model: mujoco.MjModel) -> None:
    for key, entry in NUMBERS["sites"].items():
        assert model.site(key.removesuffix("_m")).pos == pytest.approx(entry["value"], abs=1e-12), key
    vehicle = load_vehicle()
    used = {thruster.site for thruster in vehicle.steering} | set(vehicle.propeller_sites)
    assert {f"{site}_m" for site in used} <= set(NUMBERS["sites"])
    assert model.site("centre_of_buoyancy").pos == pytest.approx(vehicle.centre_of_buoyancy_m, abs=1e-12)


def test_body_axes_are_the_sources(data: mujoco.MjData) -> None:
    """Body x towards the wall ahead, y to starboard (world -y), z down."""
    assert data.body("phoenix").xmat.reshape(3, 3) == pytest.approx(np.diag([1.0, -1.0, -1.0]))


def test_stand_off_and_depth_are_the_papers(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    ahead, astern, port, starboard = (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)
    assert distance(model, data, "sonar_st1000", ahead) == pytest.approx(10.0 * FOOT_M, abs=1e-9)
    assert -data.body("phoenix").xpos[2] == pytest.approx(3.0 * FOOT_M, abs=1e-9)
    assert distance(model, data, "propeller_port", astern) / FOOT_M == pytest.approx(2.7, abs=0.05)
    length = distance(model, data, "hull_bow", ahead) + distance(model, data, "hull_bow", astern)
    width = distance(model, data, "hull_bow", port) + distance(model, data, "hull_bow", starboard)
    assert (length, width) == pytest.approx((20.0 * FOOT_M, 20.0 * FOOT_M), abs=1e-9)
    assert distance(model, data, "hull_bow", (0, 0, -1)) == pytest.approx(4.0 * FOOT_M, abs=1e-9)
    assert distance(model, data, "hull_bow", (0, 0, 1)) == -1.0


def test_the_surge_equation_exerts_no_force_before_it_has_parameters(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    data.act[:] = (3.0, -2.0)
    data.ctrl[0] = 1.0
    with forces():
        mujoco.mj_forward(model, data)
    assert not data.qfrc_actuator.any() and not data.act_dot.any()


@pytest.fixture(scope="module")
def outer_skin(model: mujoco.MjModel) -> np.ndarray:
    """Triangles that bound the hull, body axes, shape (F, 3, 3) [m]."""
    return np.concatenate([triangles(model, name) for name in ("hull", "nose", "tunnel")])


def triangles(model: mujoco.MjModel, name: str) -> np.ndarray:
    """Triangles of a mesh as it lies on the body, shape (F, 3, 3) [m]."""
    mesh = model.mesh(name).id
    geom = int(np.flatnonzero((model.geom_dataid == mesh) & (model.geom_type == mujoco.mjtGeom.mjGEOM_MESH))[0])
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return (model.geom_pos[geom] + vertices @ turn.reshape(3, 3).T)[faces]


def test_the_drawn_hull_displaces_what_the_stations_say(outer_skin: np.ndarray) -> None:
    """Volume by the divergence theorem; as rectangles the stations hold 7.06 ft3, less edges and tunnels."""
    x, height, width = (
        np.array(NUMBERS["hull"][key]["value"]) * INCH_M
        for key in ("station_x_in", "station_height_in", "station_width_in")
    )
    boxes = np.trapezoid(height * width, x)
    assert boxes / FOOT_M**3 == pytest.approx(7.06, rel=0.02)
    volume = np.einsum("fi,fi->", outer_skin[:, 0], np.cross(outer_skin[:, 1], outer_skin[:, 2])) / 6.0
    tunnels = np.pi * (1.5 * INCH_M) ** 2 * 2.0 * (10.1 + 16.5) * INCH_M
    edges = (4.0 - np.pi) * (1.4 * INCH_M) ** 2 * np.ptp(x)
    assert volume == pytest.approx(boxes - tunnels - edges, rel=0.03)


def test_the_drawn_hull_is_closed(outer_skin: np.ndarray) -> None:
    """The vector areas of a closed surface add up to nothing."""
    areas = np.cross(outer_skin[:, 1] - outer_skin[:, 0], outer_skin[:, 2] - outer_skin[:, 0]) / 2.0
    assert np.linalg.norm(areas.sum(axis=0)) < 2e-3 * np.linalg.norm(areas, axis=1).sum()


def test_the_drawn_hull_has_the_published_extent(model: mujoco.MjModel) -> None:
    hull = np.concatenate([triangles(model, name) for name in ("hull", "nose")]).reshape(-1, 3)
    assert np.ptp(hull, axis=0)[:2] / INCH_M == pytest.approx([87.6, 16.5], abs=0.05)
    assert 2.0 * hull[:, 2].max() / INCH_M == pytest.approx(10.1, abs=0.01)


def test_the_shape_is_the_one_the_script_draws(tmp_path) -> None:
    target = tmp_path / "shape.xml"
    subprocess.run([sys.executable, str(MODELS / "shape" / "phoenix.py"), str(target)], check=True)
    numbers = (
        [[float(value) for value in re.findall(r"-?\.?\d+\.?\d*", part)] for part in path.read_text().split('"')]
        for path in (target, MODELS / "phoenix_shape.xml")
    )
    for new, old in zip(*numbers, strict=True):
        assert new == pytest.approx(old, abs=2e-4)  # the last digit may round differently elsewhere


def test_the_tables_in_the_readme_are_current() -> None:
    readme = (MODELS / "README.md").read_text(encoding="utf-8")
    assert runpy.run_path(str(MODELS / "tables.py"))["refreshed"](readme) == readme, (
        "run: python models/tables.py models/README.md"
    )
