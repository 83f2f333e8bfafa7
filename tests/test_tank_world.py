"""A user's own MJCF in the tank: it need not know of it, and what cannot work is refused by file and reason."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from bodies import MJCF, afloat, awkward_vehicle, set_velocity, without_drag

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import Result, plan_run, simulate_tank
from vtank.experiment.scenario import load_scenario
from vtank.plant.vehicle import load_vehicle
from vtank.resources import models_dir
from vtank.tank import Tank, load_world
from vtank.tank.layout import SIZE
from vtank.tank.model import centre_of_gravity, rigid_mass, site, sonars, vehicle_body

XML = MJCF.format(timestep=0.01, gravity=-9.81)
BASIN = models_dir() / "basin.xml"

# Made for another purpose: own solver, step, fluid, contacts, names of the basin's, a crane with its motor, a floor.
FOREIGN = """
<mujoco model="foreign">
  <compiler angle="degree" autolimits="true"/>
  <option integrator="implicitfast" timestep="0.003" solver="CG" cone="elliptic" density="1000" viscosity="0.001"/>
  <size memory="2M"/>
  <visual><global offwidth="700"/><map zfar="99"/></visual>
  <asset>
    <texture name="tiles" type="2d" builtin="checker" width="32" height="32"/>
    <material name="tiles" texture="tiles"/>
    <material name="water" rgba="0 0 1 1"/>
  </asset>
  <default><default class="echo"><geom group="3" rgba="1 0 0 1"/></default></default>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" material="tiles" group="3" pos="0 0 -1.2"/>
    <body name="crane" pos="5 5 0">
      <joint name="lift" type="slide" range="0 1"/>
      <geom size="0.1"/>
    </body>
    <frame pos="2 3 0">
      <body name="box" pos="0 0 {z}" {pose}>
        <freejoint/>
        <geom class="echo" type="box" size="0.3 0.2 0.1" mass="39" material="water"/>
        <site name="propeller" pos="-0.3 0 0"/>
        <body name="keel" pos="0 0 {down}">
          <geom size="0.03" mass="1"/>
          <site name="sonar" pos="0.35 0 {up}"/>
        </body>
      </body>
    </frame>
  </worldbody>
  <actuator><motor name="winch" joint="lift"/></actuator>
  <sensor><accelerometer name="imu" site="sonar"/></sensor>
  <keyframe><key name="up" qpos="0 0 0 0 1 0 0 0"/></keyframe>
</mujoco>
"""
FORWARD_RIGHT_DOWN = {"z": -1, "pose": 'euler="180 0 0"', "down": 0.08, "up": -0.04}
FORWARD_LEFT_UP = {"z": 4, "pose": "", "down": -0.08, "up": 0.04}
NUMBERS = """
name = "foreign"
mjcf = "foreign.xml"
body = {{ mass_kg = 40.0, centre_of_buoyancy_m = [0.0, 0.0, 0.0], buoyancy_N = 392.4 }}
propeller = {{ sites = ["propeller"], diameter_m = 0.15 }}
thruster = []
[added_mass]
{added}
[quadratic_drag]
{drag}
"""
TRUTH = 'name = "t"\nsource = "none"\nn_limit_rev_s = 15.0\n[lumped]\nalpha_per_m = -0.5\nbeta_m_per_rev2 = 0.001\n'


def folder(path: Path, xml: str) -> Path:
    """A folder with the files of a vehicle of one's own; returns its scenario."""
    axes = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    added = "\n".join(f"{axis}_{'kg' if i < 3 else 'kg_m2'} = 4.0" for i, axis in enumerate(axes))
    drag = "\n".join(f"{axis}_{'N_s2_per_m2' if i < 3 else 'N_m_s2_per_rad2'} = 9.0" for i, axis in enumerate(axes))
    (path / "foreign.xml").write_text(xml)
    (path / "foreign.toml").write_text(NUMBERS.format(added=added, drag=drag))
    return path / "foreign.toml"


def fly(vehicle: Path, *settings: str) -> Result:
    scenario = load_scenario("open-loop-sine", [f"vehicle={vehicle}", "duration_s=10", "hold=rigid", *settings])
    return simulate_tank([plan_run(scenario)])[0]
