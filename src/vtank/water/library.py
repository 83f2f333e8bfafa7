"""MuJoCo's own C functions, for compiled callbacks."""

from __future__ import annotations

from pathlib import Path

import llvmlite.binding
import mujoco
from numba import types

llvmlite.binding.load_library_permanently(str(next(Path(mujoco.__file__).parent.glob("*mujoco.*[0-9dl]"))))

# void mj_factorM(const mjModel* m, mjData* d): sparse L'DL factorization of the mass matrix in mjData.M
factor_mass = types.ExternalFunction("mj_factorM", types.void(types.intp, types.intp))
