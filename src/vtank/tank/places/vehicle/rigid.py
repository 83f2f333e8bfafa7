"""The body of a vehicle in MuJoCo's specification."""

from __future__ import annotations

import mujoco


def free(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """The body with the free joint."""
    return next(joint.parent for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE)
