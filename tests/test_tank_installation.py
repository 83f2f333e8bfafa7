"""The callback belongs to the whole process: installed on demand, removed always, harmless to other models."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest
from bodies import awkward_model, awkward_vehicle, phoenix, without_drag

from vtank.compiled import FOLDER
from vtank.tank import Tank, forces
from vtank.tank.callbacks import callback, compiled
from vtank.tank.layout import MAGIC
from vtank.tank.offsets import OFFSETS

PENDULUM = """
<mujoco>
  <size nuserdata="{nuserdata}"/>
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


@pytest.fixture(autouse=True)
def nothing_installed() -> Iterator[None]:
    assert mujoco.get_mjcb_control() is None
    yield
    left = mujoco.get_mjcb_control()
    mujoco.set_mjcb_control(None)
    assert left is None


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
    with pytest.raises(RuntimeError, match="callback is taken by <function.*foreign"):
        tank.__enter__()
    assert mujoco.get_mjcb_control() is foreign
    mujoco.set_mjcb_control(None)

    with tank:
        mujoco.set_mjcb_control(foreign)
        with pytest.raises(RuntimeError, match="not installed"):
            tank.step()
    assert mujoco.get_mjcb_control() is foreign
    mujoco.set_mjcb_control(None)


@pytest.mark.parametrize("nuserdata", [0, 512])
def test_other_models_step_untouched(nuserdata: int) -> None:
    """To the byte, also those with room in userdata and with the fields that the callback would write."""

    def end() -> bytes:
        model = mujoco.MjModel.from_xml_string(PENDULUM.format(nuserdata=nuserdata))
        data = mujoco.MjData(model)
        data.ctrl[:], data.qfrc_applied[:], data.qvel[:] = 0.3, 0.01, 0.2
        mujoco.mj_step(model, data, 200)
        return b"".join(a.tobytes() for a in (data.qpos, data.qvel, data.act, data.ctrl, data.qfrc_applied))

    alone = end()
    with forces():
        assert end() == alone


def test_unprepared_vehicle_is_a_bare_rigid_body() -> None:
    """Our own model without the mark in userdata is left alone: it falls as in a vacuum."""
    model, _ = phoenix()
    data = mujoco.MjData(model)
    with forces():
        mujoco.mj_step(model, data)
    assert data.qacc[2] == pytest.approx(-9.80665)
    assert MAGIC not in data.userdata


def test_offsets_are_part_of_the_compile_caches_key() -> None:
    """Numba keys a cached function by its free variables: another MuJoCo must never load this one's machine code."""
    key = {cell.cell_contents for cell in compiled().__wrapped__.__closure__}
    assert set(OFFSETS.values()) <= key


def test_its_machine_code_lies_in_the_folder_of_its_sources() -> None:
    """Where a changed law is never met by the callback of yesterday, and nothing is written into the package."""
    assert Path(compiled()._cache.cache_path).is_relative_to(FOLDER)
