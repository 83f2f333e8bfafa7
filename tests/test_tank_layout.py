"""Userdata: every field in its own place, and clear refusals of models, vehicles and parameters that do not fit."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from bodies import (
    BUOYANCY_CENTRE,
    GRAVITY_CENTRE,
    MJCF,
    awkward_model,
    awkward_vehicle,
    phoenix,
    rigid_mass,
    without_drag,
)

from vtank.errors import InputError
from vtank.plant.vehicle import Thruster
from vtank.tank.layout import AT, FIELDS, MAGIC, SIZE, field
from vtank.tank.model import sonar_and_wall, vehicle_body
from vtank.tank.pack import pack

XML = MJCF.format(timestep=0.01, gravity=-9.81)


def test_fields_cover_userdata_without_gap_or_overlap() -> None:
    userdata = np.zeros((3, SIZE + 5))
    for name in FIELDS:
        field(userdata, name)[...] += 1.0
    assert np.all(userdata[:, :SIZE] == 1.0) and np.all(userdata[:, SIZE:] == 0.0)


def test_fields_of_a_batch_row_are_views() -> None:
    state = np.zeros((4, SIZE + 30))
    userdata = state[:, 10 : 10 + SIZE]
    for name, shape in FIELDS.items():
        view = field(userdata, name)
        assert view.shape == (4, *shape)
        assert np.shares_memory(view, state)
    assert field(userdata[0], "magic").shape == ()


def test_pack_takes_the_mass_of_the_compiled_model() -> None:
    model = awkward_model()
    userdata = pack(model, awkward_vehicle(), without_drag())
    assert userdata[AT.magic] == MAGIC
    assert field(userdata, "rigid_mass") == pytest.approx(rigid_mass(), abs=1e-12)
    assert field(userdata, "centre_of_gravity_m") == pytest.approx(GRAVITY_CENTRE)
    assert field(userdata, "centre_of_buoyancy_m") == pytest.approx(BUOYANCY_CENTRE)
    model.body_mass[1] *= 1.5
    assert field(pack(model, awkward_vehicle(), without_drag()), "rigid_mass")[0, 0] == pytest.approx(30.0)


def test_thruster_wrenches_hold_force_and_moment() -> None:
    wrench = field(pack(awkward_model(), awkward_vehicle(), without_drag()), "thruster_wrench")
    direction = np.array([0.36, -0.48, 0.8])
    assert wrench[1] == pytest.approx(np.concatenate([direction, np.cross([-0.3, 0.2, 0.1], direction)]))
    assert np.all(wrench[2:] == 0.0)


def test_wall_stands_ten_feet_from_the_sonar() -> None:
    model, _ = phoenix()
    sonar, wall = sonar_and_wall(model, vehicle_body(model))
    assert wall - sonar[0] == pytest.approx(3.048, abs=1e-6)
    assert sonar_and_wall(awkward_model(), 1)[1] == np.inf


def test_a_model_that_was_not_made_for_the_tank_is_refused() -> None:
    with pytest.raises(InputError, match="not made for the tank; expected one that load_world or submerge made"):
        pack(mujoco.MjModel.from_xml_string(XML), awkward_vehicle(), without_drag())
    model = awkward_model()
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    with pytest.raises(InputError, match="expected the integrator RK4 or Euler"):
        pack(model, awkward_vehicle(), without_drag())


def test_vehicles_and_parameters_that_do_not_fit_are_refused() -> None:
    model, vehicle, p = awkward_model(), awkward_vehicle(), without_drag()
    with pytest.raises(InputError, match="9 thrusters; up to 8"):
        pack(model, replace(vehicle, thrusters=9 * (Thruster("side", (0.0, 1.0, 0.0), 1.0),)), p)
    with pytest.raises(InputError, match="mass plus added mass"):
        pack(model, replace(vehicle, added_mass=-10.0 * vehicle.added_mass), p)
    with pytest.raises(InputError, match="no site 'screw'; there are: propeller, side, oblique"):
        pack(model, replace(vehicle, propeller_sites=("screw",)), p)
    with pytest.raises(InputError, match=r"expected \d+ surge parameters, found .* shape \(\d+,\)"):
        pack(model, vehicle, p[:-1])
    with pytest.raises(InputError, match="'alpha' is NaN"):
        pack(model, vehicle, np.full_like(p, np.nan))
    with pytest.raises(InputError, match="shorter than the time step"):
        pack(model, vehicle, without_drag(thrust_lag__tau=0.005))
    with pytest.raises(InputError, match="no axis 'swing' to hold; there are: surge, sway"):
        pack(model, vehicle, p, held=("swing",))
