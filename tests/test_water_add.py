"""Putting bodies into water: room is made, nothing is asked of the MJCF, and what cannot work is refused."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from chains import random_links, specification

import vtank as vt
from vtank import water
from vtank.errors import InputError
from vtank.plant.vehicle import load_vehicle
from vtank.resources import models_dir
from vtank.water import Body, ellipsoid, ellipsoids
from vtank.waves import Waves

FULL = np.diag([3.0, 4.0, 5.0, 0.1, 0.2, 0.3]) + 0.01
XML = """<mujoco><worldbody><body name="hull"><freejoint/><geom name="shell" size="0.2" mass="8"/>
<body name="arm" pos="0.2 0 0"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03"/></body>
</body><body name="crate" pos="0 2 0"><freejoint/><geom type="box" size="0.1 0.2 0.3" mass="9"/></body>
</worldbody></mujoco>"""


def spec(xml: str = XML) -> mujoco.MjSpec:
    return mujoco.MjSpec.from_string(xml)


def test_inertia_along_the_axes_is_no_hindrance() -> None:
    """MuJoCo keeps a diagonal for such a body: room is made for a full mass, and nothing else of the body changes."""
    dry = spec().compile()
    wet = water.add(spec(), {"crate": Body(FULL)})
    assert dry.body_simple[dry.body("crate").id] and not wet.body_simple[wet.body("crate").id]
    for name in ("body_mass", "body_ipos", "body_inertia"):
        assert getattr(wet, name) == pytest.approx(getattr(dry, name))
    data, full = mujoco.MjData(wet), np.zeros((wet.nv, wet.nv))
    with water.forces():
        mujoco.mj_forward(wet, data)
    mujoco.mj_fullM(wet, data, full)
    inertia = dry.body("crate").inertia
    assert full[-6:, -6:] == pytest.approx(np.diag([9.0, 9.0, 9.0, *inertia]) + FULL, abs=1e-12)


def test_a_reset_and_a_copy_keep_the_water() -> None:
    model = water.add(spec(), {"crate": Body(FULL, displaced_kg=9.0)})
    data = mujoco.MjData(model)
    with water.forces():
        mujoco.mj_step(model, data, 10)
        mujoco.mj_resetData(model, data)
        mujoco.mj_forward(model, data)
    assert data.qfrc_fluid[-4] == pytest.approx(9.0 * 9.81)


def test_the_water_travels_when_a_specification_is_attached() -> None:
    """Into another world, twice, under other names."""
    child, parent = spec(), mujoco.MjSpec()
    single = water.add(child, {"hull": Body(FULL), "arm": Body(0.1 * FULL)})
    parent.nuser_body = child.nuser_body
    for k in range(2):
        parent.attach(child.copy(), prefix=f"{k}/", frame=parent.worldbody.add_frame(pos=(0.0, 5.0 * k, 0.0)))
    model = parent.compile()
    water.set_const(model)
    assert model.body("1/arm").user == pytest.approx(single.body("arm").user)
    assert model.body("1/hull").invweight0 == pytest.approx(single.body("hull").invweight0)


def test_water_of_a_compiled_model_can_be_changed() -> None:
    model = water.add(spec(), {"crate": Body(FULL)})
    soft = model.body("crate").invweight0.copy()
    assert water.add(model, {"crate": Body(2.0 * FULL)}) is model
    assert (model.body("crate").invweight0 < soft).all()


def test_a_vehicle_goes_to_the_one_free_body() -> None:
    vehicle = load_vehicle("phoenix")
    model = water.add(mujoco.MjSpec.from_file(str(models_dir() / "phoenix.xml")), vehicle)
    data = mujoco.MjData(model)
    data.xfrc_applied[model.body("phoenix").id, 0] = 10.0
    with water.forces():
        mujoco.mj_forward(model, data)
    assert data.qacc[0] == pytest.approx(10.0 / vehicle.moving_mass_kg, rel=0.01)


def test_what_stood_for_water_is_switched_off() -> None:
    other = spec(XML.replace("<worldbody>", '<option density="1000" viscosity="0.1"/><worldbody>'))
    other.body("crate").gravcomp = 1.0
    model = water.add(other, {"crate": Body(FULL)})
    assert (model.opt.density, model.opt.viscosity, model.body_gravcomp.any()) == (0.0, 0.0, False)


PGS = mujoco.mjtSolver.mjSOL_PGS
SLEEP, EXACT = mujoco.mjtEnableBit.mjENBL_SLEEP, mujoco.mjtEnableBit.mjENBL_DIAGEXACT


def with_option(**options: object) -> mujoco.MjSpec:
    changed = spec()
    for name, value in options.items():
        setattr(changed.option, name, value)
    return changed


def owned() -> mujoco.MjSpec:
    changed = spec()
    changed.nuser_body, changed.body("crate").userdata = 2, [1.0, 2.0]
    return changed


CRATE = {"crate": Body(FULL)}
FORCED = '<compiler inertiafromgeom="true"/><worldbody>'
LOPSIDED = FULL + np.eye(6, k=1)
REFUSED: list[tuple[Callable[[], mujoco.MjSpec], object, dict[str, object], str]] = [
    (lambda: with_option(solver=PGS), CRATE, {}, "the solver PGS: expected none, with the solver Newton or CG"),
    (lambda: with_option(noslip_iterations=3), CRATE, {}, "noslip_iterations: expected none"),
    (lambda: with_option(enableflags=int(SLEEP)), CRATE, {}, "the flag sleep: expected none"),
    (lambda: with_option(enableflags=int(EXACT)), CRATE, {}, "the flag diagexact: expected none"),
    (spec, {"crat": Body(FULL)}, {}, "no body 'crat' to put into water; did you mean 'crate'. there are: hull"),
    (spec, Body(FULL), {}, "2 bodies with a free joint: expected one, or hydrodynamics by the names"),
    (spec, {"crate": Body(-10.0 * FULL)}, {}, "body 'crate': mass plus added mass is not positive definite"),
    (spec, {"crate": Body(LOPSIDED)}, {}, "body 'crate': added_mass is not symmetric"),
    (spec, {"crate": Body(np.eye(5))}, {}, r"body 'crate': added_mass has the shape \(5, 5\); expected \(6, 6\)"),
    (spec, {"crate": Body(np.nan * FULL)}, {}, "body 'crate': added_mass has a number that is not finite"),
    (spec, {"crate": Body(FULL, drag_linear=(-1.0,) * 6)}, {}, "body 'crate': drag_linear is negative"),
    (spec, {"crate": "phoenix"}, {}, "body 'crate': found 'phoenix'; expected a Vehicle .* or a water.Body"),
    (spec, CRATE, {"current_m_s": (1.0, 2.0)}, r"current_m_s: found \(1.0, 2.0\); expected three finite numbers"),
    (spec, CRATE, {"current_m_s": (1.0, np.nan, 0.0)}, "current_m_s: .* expected three finite numbers"),
    (spec, CRATE, {"waves": Waves("regular", 0.1, reflection=0.5)}, "waves that a wall reflects"),
    (owned, CRATE, {}, "body 'crate' has user data of its own; expected none"),
    (lambda: spec(XML.replace('mass="9"', 'mass="-9"')), CRATE, {}, "MuJoCo cannot compile the model"),
]


@pytest.mark.parametrize(("made", "wet", "sea", "message"), REFUSED)
def test_what_cannot_work_is_refused(made, wet, sea, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=message):
        water.add(made(), wet, **sea)


def test_inertias_that_the_compiler_takes_from_shapes_are_kept() -> None:
    dry, wet = (
        spec(XML.replace("<worldbody>", FORCED)).compile(),
        water.add(spec(XML.replace("<worldbody>", FORCED)), CRATE),
    )
    for name in ("body_mass", "body_ipos", "body_inertia"):
        assert getattr(wet, name) == pytest.approx(getattr(dry, name), abs=1e-15)


@pytest.mark.parametrize("setting", [{"solver": int(PGS)}, {"noslip_iterations": 3}])
def test_a_solver_that_cannot_see_the_water_does_not_step_silently(setting: dict[str, int]) -> None:
    """It was switched on after the model was put into water."""
    model = water.add(spec(), CRATE)
    (name, value), data = next(iter(setting.items())), mujoco.MjData(model)
    setattr(model.opt, name, value)
    with water.forces():
        mujoco.mj_step(model, data)
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number


def test_a_compiled_model_without_room_is_refused() -> None:
    """The first message says all that is missing, and how to go about it: room for numbers is not enough."""
    with pytest.raises(InputError, match=r"room for 0 numbers .* takes (\d+); expected its MjSpec") as caught:
        water.add(spec().compile(), CRATE)
    assert "room for added mass in its mass matrix: nuser_body gives the first alone" in str(caught.value)
    roomy = spec()
    roomy.nuser_body = 100
    with pytest.raises(InputError, match="no room for added mass .* MjSpec, which vtank.water.add compiles"):
        water.add(roomy.compile(), CRATE)


def test_negative_added_mass_is_allowed_as_far_as_the_body_makes_up_for_it() -> None:
    water.add(spec(), {"crate": Body(-0.1 * np.diag([1.0, 1.0, 1.0, 0.1, 0.1, 0.1]))})


def test_a_dry_model_beside_it_steps_as_ever_and_nothing_is_left_behind() -> None:
    """Also when an exception ends the context in the middle."""
    dry, wet = spec().compile(), water.add(spec(), CRATE)

    def end() -> bytes:
        data = mujoco.MjData(dry)
        data.qvel[:] = 0.3
        mujoco.mj_step(dry, data, 50)
        return data.qpos.tobytes() + data.qvel.tobytes()

    alone = end()
    with pytest.raises(ZeroDivisionError), water.forces():
        mujoco.mj_step(wet, mujoco.MjData(wet), 3)
        assert end() == alone
        raise ZeroDivisionError
    assert mujoco.get_mjcb_control() is None


def test_a_callback_that_is_there_is_refused() -> None:
    wet = water.add(spec(), CRATE)

    def theirs(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Somebody's control law."""

    mujoco.set_mjcb_control(theirs)
    try:
        with pytest.raises(InputError, match="control callback is taken by .*theirs.*expected none"), water.forces():
            mujoco.mj_step(wet, mujoco.MjData(wet))
        assert mujoco.get_mjcb_control() is theirs
    finally:
        mujoco.set_mjcb_control(None)


def test_water_is_loaded_when_it_is_first_used() -> None:
    code = "import sys, vtank as vt; assert 'mujoco' not in sys.modules; print(vt.water.add.__name__)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "add\n"
    assert vt.water is water


def test_a_sphere_and_a_spheroid_have_their_textbook_added_mass() -> None:
    """Half the displaced mass; and Lamb's article 114 for a prolate spheroid, in terms of its eccentricity."""
    sphere = ellipsoid((0.2, 0.2, 0.2))
    assert np.diagonal(sphere.added_mass)[:3] == pytest.approx(0.5 * sphere.displaced_kg)
    assert np.diagonal(sphere.added_mass)[3:] == pytest.approx(0.0, abs=1e-15)
    a, b = 1.2, 0.15
    e = np.sqrt(1.0 - (b / a) ** 2)
    growth = np.log((1.0 + e) / (1.0 - e))
    alpha = 2.0 * (1.0 - e**2) / e**3 * (0.5 * growth - e)
    beta = 1.0 / e**2 - (1.0 - e**2) / (2.0 * e**3) * growth
    k1, k2 = alpha / (2.0 - alpha), beta / (2.0 - beta)
    k3 = e**4 * (beta - alpha) / ((2.0 - e**2) * (2.0 * e**2 - (2.0 - e**2) * (beta - alpha)))
    spheroid = ellipsoid((a, b, b))
    inertia = spheroid.displaced_kg * (a**2 + b**2) / 5.0
    mass = spheroid.displaced_kg
    assert np.diagonal(spheroid.added_mass) == pytest.approx(
        [k1 * mass, k2 * mass, k2 * mass, 0.0, k3 * inertia, k3 * inertia], rel=1e-9, abs=1e-12
    )


def test_a_body_that_is_moved_keeps_its_energy_and_its_forces() -> None:
    """Hydrodynamics given at another place and turned move a body as those of a body drawn there do."""
    link = next(link for link in random_links() if link.name == "vehicle")
    turn, place = random_links()[3].turn, np.array([0.3, -0.2, 0.1])
    inner = replace(link.water, cross_flow=(0.0,) * 4)
    ends = []
    for moved in (False, True):
        spec = specification([link])
        if not moved:  # a massless body, fixed to the first, carries the water
            quat = np.zeros(4)
            mujoco.mju_mat2Quat(quat, turn.ravel())
            spec.body("vehicle").add_body(name="skin", pos=place, quat=quat)
        model = water.add(spec, {"vehicle": inner.moved(place, turn)} if moved else {"skin": inner})
        data = mujoco.MjData(model)
        data.qvel[:] = (0.3, -0.2, 0.4, 0.5, -0.3, 0.2)
        with water.forces():
            mujoco.mj_forward(model, data)
        ends.append(data.qacc.copy())
    assert ends[1] == pytest.approx(ends[0], rel=1e-11)


def test_any_model_can_be_begun_with_the_ellipsoids_of_its_inertia() -> None:
    bodies = ellipsoids(spec())
    assert {name: body.displaced_kg for name, body in bodies.items()} == pytest.approx(
        {name: spec().compile().body(name).mass[0] / 1.5 for name in ("hull", "arm", "crate")}
    )
    model = water.add(spec(), bodies)
    data = mujoco.MjData(model)
    with water.forces():
        mujoco.mj_step(model, data, 200)
    assert np.isfinite(data.qpos).all() and np.abs(data.qvel).max() < 20.0


def test_the_water_travels_in_xml_to_the_digits_that_mujoco_writes() -> None:
    child = spec()
    model = water.add(child, {"crate": Body(FULL, displaced_kg=9.0)})
    again = mujoco.MjModel.from_xml_string(child.to_xml())
    water.set_const(again)
    assert again.body("crate").user == pytest.approx(model.body("crate").user, rel=1e-5)
    data = mujoco.MjData(again)
    with water.forces():
        mujoco.mj_forward(again, data)
    assert data.qfrc_fluid[-4] == pytest.approx(9.0 * 9.81, rel=1e-5)
