"""What MuJoCo derives from the mass of a model, for the wet mass; and refusals of what cannot see it."""

from __future__ import annotations

import mujoco
import numpy as np

from ..errors import InputError
from .installation import forces
from .record import MAGIC, SIZE, field

ENABLE = mujoco.mjtEnableBit
STARTS = {int(mujoco.mjtJoint.mjJNT_BALL): (0,), int(mujoco.mjtJoint.mjJNT_FREE): (0, 3)}  # of each three alike


def set_const(model: mujoco.MjModel) -> None:
    """Derive constants from the wet mass at qpos0, as mj_setConst does from the dry one: call it after that.

    They are body_invweight0, dof_invweight0, tendon_invweight0 and stat.meaninertia, on which the softness of contacts,
    limits and friction depends. Raises InputError for settings that would use the dry mass: the PGS solver, noslip
    iterations, the flags sleep, diagexact and ipc, MuJoCo's own fluid; and for mass that is not positive definite.
    """
    wet = [i for i in range(1, model.nbody) if model.nuser_body >= SIZE and model.body_user[i, 0] == MAGIC]
    _check_settings(model)
    for i in wet:
        _check_mass(model, i)
        _check_room(model, i)
    data = mujoco.MjData(model)
    with forces():
        mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    inverse = np.linalg.inv(full)
    model.stat.meaninertia = max(np.trace(full) / max(model.nv, 1), mujoco.mjMINVAL)
    _set_bodies(model, data, inverse)
    _set_joints(model, inverse)
    for i in range(model.ntendon):
        jacobian = _tendon_jacobian(model, data, i)
        model.tendon_invweight0[i] = max(jacobian @ inverse @ jacobian, 0.0)


def _check_settings(model: mujoco.MjModel) -> None:
    option = model.opt
    wrong = {
        "the solver PGS": option.solver == mujoco.mjtSolver.mjSOL_PGS,
        "noslip_iterations": option.noslip_iterations > 0,
        "the flag sleep": option.enableflags & ENABLE.mjENBL_SLEEP,
        "the flag diagexact": option.enableflags & ENABLE.mjENBL_DIAGEXACT,
        "the flag ipc": option.enableflags & ENABLE.mjENBL_IPC,
        "density or viscosity": option.density or option.viscosity,
    }
    for name, found in wrong.items():
        if found:
            raise InputError(f"{name}: expected none, with the solver Newton or CG: it would not see the added mass")


def _check_mass(model: mujoco.MjModel, body: int) -> None:
    """Added mass may be negative in some direction only as far as the body's own mass makes up for it."""
    turn, (x, y, z) = np.zeros(9), model.body_ipos[body]
    mujoco.mju_quat2Mat(turn, model.body_iquat[body])
    axes, lever = turn.reshape(3, 3), np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    mass = model.body_mass[body]
    inertia = axes @ np.diag(model.body_inertia[body]) @ axes.T - mass * lever @ lever
    rigid = np.block([[mass * np.eye(3), -mass * lever], [mass * lever, inertia]])
    added = field(model.body_user[body], "added_mass")
    smallest = np.linalg.eigvalsh(added)[0]
    if smallest < -1e-12 * np.abs(added).max() and np.linalg.eigvalsh(rigid + added)[0] <= 0.0:
        raise InputError(f"body '{model.body(body).name}': mass plus added mass is not positive definite")


def _check_room(model: mujoco.MjModel, body: int) -> None:
    """MuJoCo keeps only the diagonal of the mass matrix where a body's inertia lies along its own axes."""
    carrier = int(model.body_weldid[body])
    if model.body_simple[carrier]:
        raise InputError(
            f"body '{model.body(body).name}': no room for added mass in MuJoCo's mass matrix; expected the model's "
            "MjSpec, which vtank.water.add compiles with that room"
        )


def _set_bodies(model: mujoco.MjModel, data: mujoco.MjData, inverse: np.ndarray) -> None:
    moving, turning = np.zeros((2, 3, model.nv))
    for i in np.flatnonzero(model.body_weldid > 0).tolist():
        mujoco.mj_jacBodyCom(model, data, moving, turning, i)
        means = [np.trace(jacobian @ inverse @ jacobian.T) / 3.0 for jacobian in (moving, turning)]
        model.body_invweight0[i] = np.maximum(means, mujoco.mjMINVAL)


def _set_joints(model: mujoco.MjModel, inverse: np.ndarray) -> None:
    """Of each degree of freedom; ball and free joints have one mean for every three."""
    weights = np.diagonal(inverse).copy()
    for joint in range(model.njnt):
        start = model.jnt_dofadr[joint]
        for at in STARTS.get(int(model.jnt_type[joint]), ()):
            at += start
            weights[at : at + 3] = weights[at : at + 3].mean()
    model.dof_invweight0[:] = weights


def _tendon_jacobian(model: mujoco.MjModel, data: mujoco.MjData, tendon: int) -> np.ndarray:
    jacobian = np.zeros(model.nv)
    start, size = model.ten_J_rowadr[tendon], model.ten_J_rownnz[tendon]
    jacobian[model.ten_J_colind[start : start + size]] = data.ten_J[start : start + size]
    return jacobian
