"""The callback belongs to the whole process: installed on demand, removed always, harmless to other models."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import pytest
from bodies import awkward_model, awkward_vehicle, phoenix, without_drag

from vtank.compiled import FOLDER
from vtank.errors import InputError
from vtank.tank import Tank, forces
from vtank.tank import callbacks as surge
from vtank.water import control
from vtank.water.control import callback
from vtank.water.offsets import AT

PENDULUM = """
<mujoco>
  <size nuser_body="{room}" nuser_actuator="{room}"/>
  <worldbody>
    <body>
      <joint name="hinge" axis="0 1 0" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0.5 0 0.1" size="0.02"/>
      <body pos="0.5 0 0.1"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/></body>
    </body>
    <body pos="0 1 0"><freejoint/><geom size="0.1" pos="0.02 0.01 0"/></body>
  </worldbody>
  <actuator><motor joint="hinge"/><general joint="hinge" dyntype="integrator"/></actuator>
</mujoco>
"""


def present() -> list[object]:
    """MuJoCo's callbacks of the three kinds."""
    return [mujoco.get_mjcb_control(), mujoco.get_mjcb_act_dyn(), mujoco.get_mjcb_act_bias()]


@pytest.fixture(autouse=True)
def nothing_installed() -> Iterator[None]:
    assert present() == [None, None, None]
    yield
    left = present()
    for remove in (mujoco.set_mjcb_control, mujoco.set_mjcb_act_dyn, mujoco.set_mjcb_act_bias):
        remove(None)
    assert left == [None, None, None]


def small_tank() -> Tank:
    return Tank(awkward_model(), awkward_vehicle(), without_drag())


def test_installed_inside_the_context_only() -> None:
    with small_tank():
        assert mujoco.get_mjcb_control() is callback()
    assert mujoco.get_mjcb_control() is None


def test_contexts_nest_and_may_end_in_any_order() -> None:
    first, second = small_tank(), small_tank()
    with forces(), first, first, second:
        assert mujoco.get_mjcb_control() is callback()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    second.step()
    second.__exit__(None, None, None)
    assert mujoco.get_mjcb_control() is None


def test_removed_when_an_exception_leaves_the_context() -> None:
    with pytest.raises(ZeroDivisionError), small_tank():
        raise ZeroDivisionError
    assert mujoco.get_mjcb_control() is None


def test_stepping_outside_the_context_is_refused() -> None:
    tank = small_tank()
    with pytest.raises(RuntimeError, match="step inside `with tank:`"):
        tank.step()


def test_somebody_elses_callback_is_neither_replaced_nor_removed() -> None:

    def foreign(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """A control law in Python."""

    tank = small_tank()
    mujoco.set_mjcb_control(foreign)
    with pytest.raises(InputError, match="control callback is taken by <function.*foreign.*expected none"):
        tank.__enter__()
    assert mujoco.get_mjcb_control() is foreign
    mujoco.set_mjcb_control(None)

    with tank:
        mujoco.set_mjcb_control(foreign)
        with pytest.raises(RuntimeError, match="not installed"):
            tank.step()
    assert mujoco.get_mjcb_control() is foreign
    mujoco.set_mjcb_control(None)


def test_mujocos_own_profile_stands_still_in_the_tank_and_nowhere_else() -> None:
    """Its clock, asked many times a step, is put away while the tank is stepped, and is back afterwards."""
    model, _ = phoenix()

    def profiled() -> float:
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, 20)
        return float(data.timer.duration.sum())

    with forces():
        assert profiled() == 0.0
    assert profiled() > 0.0


@pytest.mark.parametrize("room", [0, 512])
def test_other_models_step_untouched(room: int) -> None:
    """To the byte, also those with room for user data and with the fields that the callback would write."""

    def end() -> bytes:
        model = mujoco.MjModel.from_xml_string(PENDULUM.format(room=room))
        data = mujoco.MjData(model)
        data.ctrl[:], data.qfrc_applied[:], data.qvel[:] = 0.3, 0.01, 0.2
        mujoco.mj_step(model, data, 200)
        return b"".join(a.tobytes() for a in (data.qpos, data.qvel, data.act, data.ctrl, data.qfrc_applied))

    alone = end()
    with forces():
        assert end() == alone


def test_a_reset_leaves_the_vehicle_in_its_water() -> None:
    """Parameters stand in the model: what mj_resetData clears is state alone."""
    model, vehicle = phoenix()
    data = mujoco.MjData(model)
    with forces():
        mujoco.mj_step(model, data, 5)
        mujoco.mj_resetData(model, data)
        data.xfrc_applied[model.body("phoenix").id, 0] = 10.0
        mujoco.mj_forward(model, data)
    assert data.qacc[0] == pytest.approx(10.0 / vehicle.moving_mass_kg, rel=0.01)


COMPILED = [control.compiled(), *surge.compiled().values()]


@pytest.mark.parametrize("compiled", COMPILED)
def test_offsets_are_part_of_the_compile_caches_key(compiled: Any) -> None:
    """Numba keys a cached function by its free variables: another MuJoCo must never load this one's machine code."""
    assert AT in {cell.cell_contents for cell in compiled.__wrapped__.__closure__}


@pytest.mark.parametrize("compiled", COMPILED)
def test_its_machine_code_lies_in_the_folder_of_its_sources(compiled: Any) -> None:
    """Where a changed law is never met by the callback of yesterday, and nothing is written into the package."""
    assert Path(compiled._cache.cache_path).is_relative_to(FOLDER)
