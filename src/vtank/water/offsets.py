"""Where the fields that compiled callbacks read and write lie in MuJoCo's structs.

A C callback gets the raw addresses of mjModel and mjData. MuJoCo ships a machine-readable copy of its headers;
the byte offsets follow from it by the C layout rules that ctypes implements. They are checked when this module is
imported: on two probe models of different sizes every offset must lead to the memory that the Python bindings show
under that name, in both directions. A MuJoCo of another series or layout is refused here, and nothing is written.
"""

from __future__ import annotations

import ctypes
import math
from collections import namedtuple
from typing import Any

import mujoco
import numpy as np
from mujoco.introspect import ast_nodes, structs

from ..errors import InputError

SERIES = "4.0."  # in which mjcb_control comes between the factorization of mjData.M and its use
COUNTS = ("nv", "nbody", "nuser_body", "nuser_actuator")  # of mjModel
CHOICES = ("solver", "noslip_iterations")  # of mjModel.opt, int32
INDICES = (  # of mjModel, int32
    "body_parentid",
    "body_rootid",
    "body_dofnum",
    "body_dofadr",
    "body_jntnum",
    "dof_parentid",
    "M_rowadr",
    "M_rownnz",
    "actuator_actadr",
)
SETTINGS = ("body_user", "actuator_user")  # of mjModel, float64
POINTERS = (  # of mjData, float64
    "qvel",
    "ctrl",
    "act",
    "act_dot",
    "xpos",
    "xmat",
    "subtree_com",
    "cdof",
    "cdof_dot",
    "cvel",
    "crb",
    "M",
    "qLD",
    "qLDiagInv",
    "qfrc_passive",
    "qfrc_fluid",
)
SCALARS = {
    "mjtNum": ctypes.c_double,
    "mjtSize": ctypes.c_int64,
    "mjtBool": ctypes.c_bool,
    "size_t": ctypes.c_size_t,
    "uintptr_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
    "int": ctypes.c_int,
    "float": ctypes.c_float,
}
UNUSUAL = 12345  # what no option of a model is
PROBE = """<mujoco><size nuser_body="{wide}" nuser_actuator="{wide}"/>
<worldbody>{bodies}</worldbody> <actuator>{actuators}</actuator></mujoco>"""
BODY = """<body pos="{k} 0 1"><freejoint/><geom size="0.1"/><site name="s{k}"/>
<body><joint axis="0 1 0"/><geom size="0.1" pos="0.2 0 0"/></body></body>"""
ACTUATOR = '<general site="s{k}" dyntype="integrator" gainprm="0"/>'


def _refusal(what: str) -> InputError:
    return InputError(
        f"MuJoCo {mujoco.mj_versionString()}: {what}; the compiled callback cannot be used with this version, "
        "install mujoco 4.0"
    )


def check_series(version: str) -> None:
    """Raise InputError unless MuJoCo calls mjcb_control between making the mass matrix and using it."""
    if not version.startswith(SERIES):
        raise _refusal(f"expected the series {SERIES}x")


def _c_type(node: Any) -> type:
    if isinstance(node, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(node, ast_nodes.ArrayType):
        return _c_type(node.inner_type) * math.prod(node.extents)
    if isinstance(node, ast_nodes.AnonymousStructDecl):
        return _c_struct(node)
    return SCALARS[node.name] if node.name in SCALARS else _c_struct(structs.STRUCTS[node.name])


def _c_struct(declared: Any) -> type[ctypes.Structure]:
    """The C struct as a ctypes type."""
    fields = [(field.name, _c_type(field.type)) for field in declared.fields]
    return type("Struct", (ctypes.Structure,), {"_fields_": fields})


def derive() -> dict[str, int]:
    """Byte offset of each field of mjModel and mjData that callbacks need; CHOICES and "gravity" are of mjModel.opt."""
    try:
        model, data = (_c_struct(structs.STRUCTS[name]) for name in ("mjModel", "mjData"))
        option = _c_struct(structs.STRUCTS["mjOption"])
        offsets = {name: model.opt.offset + getattr(option, name).offset for name in ("gravity", *CHOICES)}
        offsets |= {name: getattr(model, name).offset for name in (*COUNTS, *INDICES, *SETTINGS)}
        return offsets | {name: getattr(data, name).offset for name in ("time", *POINTERS)}
    except (AttributeError, KeyError) as missing:
        raise _refusal(f"its headers do not describe {missing} as expected") from None


def probe(size: int) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A model in which no two of the arrays in question share an address: `size` free bodies, a joint on each."""
    bodies = "\n".join(BODY.format(k=k) for k in range(size))
    actuators = "\n".join(ACTUATOR.format(k=k) for k in range(size))
    model = mujoco.MjModel.from_xml_string(PROBE.format(wide=3 + size, bodies=bodies, actuators=actuators))
    return model, mujoco.MjData(model)


def verify(offsets: dict[str, int], model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise InputError, naming the MuJoCo version, unless every offset leads to the field of its name."""
    for name in COUNTS:
        if ctypes.c_int64.from_address(model._address + offsets[name]).value != getattr(model, name):
            raise _refusal(f"mjModel.{name} is not where its headers say")
    if model._address + offsets["gravity"] != model.opt.gravity.ctypes.data:
        raise _refusal("mjModel.opt.gravity is not where its headers say")
    kept = {name: getattr(model.opt, name) for name in CHOICES}
    for number, name in enumerate(CHOICES, UNUSUAL):
        setattr(model.opt, name, number)
        if ctypes.c_int32.from_address(model._address + offsets[name]).value != number:
            raise _refusal(f"mjModel.opt.{name} is not where its headers say")
    for name, value in kept.items():
        setattr(model.opt, name, value)
    data.time = 1.0 / 3.0
    if ctypes.c_double.from_address(data._address + offsets["time"]).value != data.time:
        raise _refusal("mjData.time is not where its headers say")
    data.time = 0.0
    kinds = ((model, INDICES, np.int32), (model, SETTINGS, np.float64), (data, POINTERS, np.float64))
    for struct, name, kind in ((struct, name, kind) for struct, names, kind in kinds for name in names):
        array = getattr(struct, name)
        address = ctypes.c_size_t.from_address(struct._address + offsets[name]).value
        if array.dtype != kind or address != array.ctypes.data:
            raise _refusal(f"{type(struct).__name__}.{name} is not where its headers say")


check_series(mujoco.mj_versionString())
OFFSETS = derive()
for _size in (2, 5):
    verify(OFFSETS, *probe(_size))
Offsets = namedtuple("Offsets", OFFSETS)  # type: ignore[misc]  # names that are not written out
AT: Any = Offsets(**OFFSETS)
