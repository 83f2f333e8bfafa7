"""The surge equation as a MuJoCo actuator: compiled callbacks of its dynamics and its force; and the force of fins.

MuJoCo calls mjcb_act_dyn and mjcb_act_bias, in every Runge-Kutta stage, for actuators with user dynamics and user bias.
The first finds the rates of the two states, lagged thrust and wake; the second the force along the hull, the equation's
acceleration (plant/surge.py) times the moving mass m - X_udot. Propeller speed is the control. Of a whole vehicle's
fins (fins.py) the second finds the force, and the angle is the control.

The clock of MuJoCo's own profile (mjData.timer), which nobody here reads, stands still meanwhile: asked many times
a step, it takes a quarter of the step's time.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any

import numba
import numpy as np
from numba import types

from ..compiled import cache_folder, term
from ..plant.sixdof import to_body, to_world
from ..plant.surge import memory_rate, surge_acceleration, thrust_now, thrust_rate, thrust_target
from ..water import offsets
from ..water.control import callback
from ..water.forces import flow
from ..water.pointers import array_at, numbers, triple, whole, word_at
from .fins import fin_force
from .layout import AT, FIELDS, FINNING, SIZE, SURGING, TRIMMING

OFFSETS = offsets.AT
PARAMETERS = FIELDS["parameters"][0]


@term
def row(model: int, actuator: int) -> np.ndarray:
    """The numbers of an actuator, shape (SIZE,)."""
    return numbers(model + OFFSETS.actuator_user, word_at(model + OFFSETS.nuser_actuator) * actuator, SIZE)


@term
def states(model: int, data: int, actuator: int) -> tuple[float, float, float]:
    """Lagged thrust [m/s2], wake [m/s], and propeller speed [rev/s]."""
    start = whole(model + OFFSETS.actuator_actadr, actuator + 1)[actuator]
    act = numbers(data + OFFSETS.act, start, 2)
    return act[0], act[1], numbers(data + OFFSETS.ctrl, actuator, 1)[0]


@term
def along(model: int, data: int, user: np.ndarray) -> tuple[float, float, float]:
    """Place of the vehicle along x [m], its surge speed through the water [m/s], and the gap before its sonar [m]."""
    body = int(user[AT.body])
    width, time = word_at(model + OFFSETS.nuser_body), array_at(data + OFFSETS.time, 1)[0]
    wet, sea = numbers(model + OFFSETS.body_user, width * body, width), numbers(model + OFFSETS.body_user, 0, width)
    position, rotation = numbers(data + OFFSETS.xpos, 3 * body, 3), numbers(data + OFFSETS.xmat, 9 * body, (3, 3))
    velocity = numbers(data + OFFSETS.qvel, whole(model + OFFSETS.body_dofadr, body + 1)[body], 3)
    u = to_body(rotation, triple(velocity, 0))[0] - to_body(rotation, flow(wet, sea, time, position, rotation)[0])[0]
    return position[0], u, user[AT.wall_m] - position[0] - to_world(rotation, triple(user, AT.sonar_m))[0]


@functools.cache
def compiled() -> dict[str, Any]:
    """The two callbacks, compiled at the first call (seconds) and cached on disk by offsets, among others."""
    o = OFFSETS

    def mjcb_act_dyn(model, data, actuator):  # type: ignore[no-untyped-def]
        if word_at(model + o.nuser_actuator) < SIZE or row(model, actuator)[0] != SURGING:
            return 0.0
        user, time = row(model, actuator), array_at(data + o.time, 1)[0]
        p = user[AT.parameters : AT.parameters + PARAMETERS]
        lag, wake, n = states(model, data, actuator)
        x, u, _ = along(model, data, user)
        rate = numbers(data + o.act_dot, whole(model + o.actuator_actadr, actuator + 1)[actuator], 2)
        target = thrust_target(time, n, p)
        rate[0] = thrust_rate(lag, target, p)
        rate[1] = memory_rate(time, x, u, thrust_now(lag, target, p), wake, n, p)
        return 0.0

    def mjcb_act_bias(model, data, actuator):  # type: ignore[no-untyped-def]
        if word_at(model + o.nuser_actuator) < SIZE:
            return 0.0
        kind, time = row(model, actuator)[0], array_at(data + o.time, 1)[0]
        if kind == FINNING:
            return fin_force(model, data, row(model, actuator), numbers(data + o.ctrl, actuator, 1)[0])
        if kind != SURGING and kind != TRIMMING:
            return 0.0
        surge = actuator if kind == SURGING else int(row(model, actuator)[1])
        user = row(model, surge)
        p = user[AT.parameters : AT.parameters + PARAMETERS]
        lag, wake, n = states(model, data, surge)
        z = thrust_now(lag, thrust_target(time, n, p), p)
        if kind == TRIMMING:
            return user[AT.moving_mass_kg] * z
        x, u, gap = along(model, data, user)
        force = surge_acceleration(time, x, u, z, wake, n, gap, user[AT.disturbance_m_s2], p)
        return user[AT.moving_mass_kg] * force

    signature = types.float64(types.intp, types.intp, types.int32)
    with cache_folder():
        make = numba.cfunc(signature, cache=True, error_model="numpy")
        return {"act_dyn": make(mjcb_act_dyn), "act_bias": make(mjcb_act_bias)}


@functools.cache
def still_clock() -> Any:
    """mjcb_time that costs nothing, as the C function that MuJoCo takes."""

    def mjcb_time():  # type: ignore[no-untyped-def]
        return 0.0

    with cache_folder():
        made = numba.cfunc(types.float64(), cache=True)(mjcb_time)
    return ctypes.cast(made.address, ctypes.CFUNCTYPE(ctypes.c_double))


@functools.cache
def callbacks() -> dict[str, Any]:
    """All compiled callbacks that a vehicle in the tank needs, by kind, as the C functions that MuJoCo takes."""
    kind = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int)
    law = {name: ctypes.cast(made.address, kind) for name, made in compiled().items()}
    return {"control": callback(), "time": still_clock(), **law}
