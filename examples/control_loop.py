"""A control loop of one's own on MuJoCo's own arrays: the Phoenix dives 0.5 m and stays there, in a current."""

import mujoco

import vtank as vt

vehicle = vt.load_vehicle("phoenix")
spec = mujoco.MjSpec.from_file(str(vehicle.mjcf))
for site in ("tunnel_bow_vertical", "tunnel_stern_vertical"):  # each pushes down its z axis, at most 8.9 N
    spec.add_actuator(target=site, trntype=mujoco.mjtTrn.mjTRN_SITE, gear=(0, 0, 1, 0, 0, 0), ctrlrange=(-8.9, 8.9))
model = vt.water.add(spec, vehicle, current_m_s=(0.0, -0.05, 0.0))
data = mujoco.MjData(model)
start = -data.qpos[2]

with vt.water.forces():
    while data.time < 60.0:
        depth, sinking = -data.qpos[2], -data.qvel[2]
        data.ctrl[:] = 40.0 * (start + 0.5 - depth) - 240.0 * sinking
        mujoco.mj_step(model, data, 10)
print(f"dived {-data.qpos[2] - start:.3f} m, carried {-data.qpos[1]:.1f} m to starboard by the current")
