"""MuJoCo's own C functions, for compiled callbacks."""

from __future__ import annotations

from pathlib import Path

import llvmlite.binding
import mujoco
from numba import types

llvmlite.binding.load_library_permanently(str(next(Path(mujoco.__file__).parent.glob("*mujoco.*[0-9dl]"))))

# void mj_factorM(const mjModel* m, mjData* d): sparse L'DL factorization of the mass matrix in mjData.M
factor_mass = types.ExternalFunction("mj_factorM", types.void(types.intp, types.intp))

# mjtNum mj_ray(const mjModel* m, const mjData* d, const mjtNum pnt[3], const mjtNum vec[3], const mjtByte* geomgroup,
#               mjtBool flg_static, int bodyexclude, int geomid[1], mjtNum normal[3]): distance, -1 where nothing is
ray = types.ExternalFunction("mj_ray", types.float64(*[types.intp] * 5, types.boolean, types.int32, *[types.intp] * 2))
