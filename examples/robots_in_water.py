"""Drop three robots of robot_descriptions into water as they are: a biped, a dog, and an arm carried by the Phoenix."""

from importlib import import_module

import mujoco

import vtank as vt


def robot(name: str) -> mujoco.MjSpec:
    """A robot's MJCF; robot_descriptions clones it when it is first asked for."""
    return mujoco.MjSpec.from_file(import_module(f"robot_descriptions.{name}_mj_description").MJCF_PATH)


def carried(arm: mujoco.MjSpec) -> mujoco.MjSpec:
    """The Phoenix with the arm below its nose."""
    hull = mujoco.MjSpec.from_file(str(vt.load_vehicle("phoenix").mjcf))
    hull.option.integrator = arm.option.integrator
    hull.attach(arm, prefix="arm/", frame=hull.body("phoenix").add_frame(pos=(0.6, 0.0, 0.15)))
    return hull


for name in ("cassie", "anymal_c", "panda"):
    try:
        spec = carried(robot(name)) if name == "panda" else robot(name)
    except Exception as reason:  # not installed, or no network to clone it
        print(f"{name}: skipped, robot_descriptions cannot bring it ({type(reason).__name__})")
        continue
    bodies = vt.water.ellipsoids(spec)  # a first guess from mass and inertia; better numbers are yours to give
    if name == "panda":
        bodies["phoenix"] = vt.load_vehicle("phoenix")
    model = vt.water.add(spec, bodies, current_m_s=(0.1, 0.0, 0.0))
    data = mujoco.MjData(model)
    with vt.water.forces():
        mujoco.mj_step(model, data, round(5.0 / model.opt.timestep))
    print(f"{name}: {len(bodies)} wet bodies, {model.nv} degrees of freedom, after 5 s at z = {data.qpos[2]:.2f} m")
