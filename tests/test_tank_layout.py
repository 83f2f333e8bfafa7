"""The numbers of the surge equation in their places, and clear refusals of models, vehicles and parameters."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from bodies import GRAVITY_CENTRE, MJCF, awkward_model, awkward_vehicle, phoenix, rigid_mass, without_drag

from vtank.errors import InputError
from vtank.plant.vehicle import Thruster
from vtank.tank import prepare
from vtank.tank.layout import FIELDS, SIZE, field
from vtank.tank.model import centre_of_gravity, sonar_and_wall, vehicle_body
from vtank.tank.model import rigid_mass as compiled_mass
from vtank.water import record

XML = MJCF.format(timestep=0.01, gravity=-9.81)


@pytest.mark.parametrize(
    ("fields", "size", "view"), [(FIELDS, SIZE, field), (record.FIELDS, record.SIZE, record.field)]
)
def test_fields_cover_a_row_without_gap_or_overlap_and_are_views(fields, size: int, view) -> None:
    state = np.zeros((3, size + 5))
    for name, shape in fields.items():
        part = view(state, name)
        part += 1.0
        assert part.shape == (3, *shape) and np.shares_memory(part, state)
    assert np.all(state[:, :size] == 1.0) and np.all(state[:, size:] == 0.0)
    assert view(state[0], "magic").shape == ()


def test_the_mass_is_that_of_the_compiled_model() -> None:
    model = awkward_model()
    assert compiled_mass(model, 1) == pytest.approx(rigid_mass(), abs=1e-12)
    assert centre_of_gravity(model, 1) == pytest.approx(GRAVITY_CENTRE)
    model.body_mass[1] *= 1.5
    assert compiled_mass(model, 1)[0, 0] == pytest.approx(30.0)


def test_gear_holds_force_and_moment_of_each_thruster() -> None:
    gear = prepare(awkward_model(), awkward_vehicle(), without_drag()).actuator_gear
    direction = np.array([0.36, -0.48, 0.8])
    assert gear[2] == pytest.approx(np.concatenate([direction, np.cross([-0.3, 0.2, 0.1], direction)]))
    assert gear[[0, 3]] == pytest.approx(np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.1, 0.0]]))


def test_the_thrusts_moment_needs_an_actuator_only_off_the_axis() -> None:
    model, vehicle = phoenix()
    assert model.nu == 1 + len(vehicle.steering)
    with pytest.raises(InputError, match="made for propellers on the vehicle's axis; the vehicle's are off it"):
        off = replace(vehicle, propeller_sites=("sonar_st1000",), thrusters=vehicle.steering)
        prepare(model, off, without_drag())


def test_preparing_leaves_the_model_as_it_was() -> None:
    model = awkward_model()
    before = model.actuator_user.copy(), model.body_user.copy(), model.dof_armature.copy()
    prepare(model, awkward_vehicle(drag=True), without_drag(alpha=-1.0), held=("sway",))
    assert all(map(np.array_equal, before, (model.actuator_user, model.body_user, model.dof_armature)))


def test_wall_stands_ten_feet_from_the_sonar() -> None:
    model, _ = phoenix()
    sonar, wall = sonar_and_wall(model, vehicle_body(model))
    assert wall - sonar[0] == pytest.approx(3.048, abs=1e-6)
    assert sonar_and_wall(awkward_model(), 1)[1] == np.inf


def test_a_model_that_was_not_made_for_the_tank_is_refused() -> None:
    with pytest.raises(InputError, match="not made for the tank; expected one that load_world or submerge made"):
        prepare(mujoco.MjModel.from_xml_string(XML), awkward_vehicle(), without_drag())
    model = awkward_model()
    model.opt.solver = mujoco.mjtSolver.mjSOL_PGS
    with pytest.raises(InputError, match="vehicle 'awkward': the solver PGS: expected none"):
        prepare(model, awkward_vehicle(), without_drag())


def test_vehicles_and_parameters_that_do_not_fit_are_refused() -> None:
    model, vehicle, p = awkward_model(), awkward_vehicle(), without_drag()
    with pytest.raises(InputError, match="the model has 2 thrusters; expected the vehicle's 9"):
        prepare(model, replace(vehicle, thrusters=9 * (Thruster("side", (0.0, 1.0, 0.0), 1.0),)), p)
    with pytest.raises(InputError, match="mass plus added mass"):
        prepare(model, replace(vehicle, added_mass=-10.0 * vehicle.added_mass), p)
    with pytest.raises(InputError, match="no site 'screw'; there are: propeller, side, oblique"):
        prepare(model, replace(vehicle, propeller_sites=("screw",)), p)
    with pytest.raises(InputError, match=r"expected \d+ surge parameters, found .* shape \(\d+,\)"):
        prepare(model, vehicle, p[:-1])
    with pytest.raises(InputError, match="'alpha' is NaN"):
        prepare(model, vehicle, np.full_like(p, np.nan))
    with pytest.raises(InputError, match="shorter than the time step"):
        prepare(model, vehicle, without_drag(thrust_lag__tau=0.005))
    with pytest.raises(InputError, match="no axis 'swing' to hold; .*there are: surge, sway"):
        prepare(model, vehicle, p, held=("swing",))
