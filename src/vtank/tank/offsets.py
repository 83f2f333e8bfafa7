"""Where the fields that the compiled callback reads and writes lie in MuJoCo's structs.

A C callback gets the raw addresses of mjModel and mjData. MuJoCo ships a machine-readable copy of its headers;
the byte offsets follow from it by the C layout rules that ctypes implements. They are checked when this module is
imported: on two probe models of different sizes every offset must lead to the memory that the Python bindings show
under that name, in both directions. A MuJoCo with another layout is refused here and never writes elsewhere.
"""

from __future__ import annotations

import ctypes
import math

import mujoco
from mujoco.introspect import ast_nodes, structs

from ..errors import InputError

# Fields that the callback needs; the pointers lead to arrays of float64
POINTERS = (
    "qvel",
    "ctrl",
    "act",
    "userdata",
    "qfrc_applied",
    "qfrc_passive",
    "qfrc_bias",
    "xfrc_applied",
    "xpos",
    "xmat",
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
PROBE = """<mujoco><size nuserdata="{nuserdata}"/>
<worldbody>{bodies}</worldbody> <actuator>{actuators}</actuator></mujoco>"""
BODY = '<body pos="{k} 0 1"><freejoint/><geom size="0.1"/><site name="s{k}"/></body>'
ACTUATOR = '<general site="s{k}" dyntype="integrator" gainprm="0"/>'


def _refusal(what: str) -> InputError:
    return InputError(
        f"MuJoCo {mujoco.mj_versionString()}: {what}; the compiled callback cannot be used with this version, "
        "install mujoco 4.0"
    )


def _c_type(node: ast_nodes.ValueType | ast_nodes.PointerType | ast_nodes.ArrayType) -> type:
    if isinstance(node, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(node, ast_nodes.ArrayType):
        return _c_type(node.inner_type) * math.prod(node.extents)
    return SCALARS[node.name] if node.name in SCALARS else _c_struct(node.name)


def _c_struct(name: str, last: str | None = None) -> type[ctypes.Structure]:
    """The C struct as a ctypes type, up to and including the field `last` (None: the whole)."""
    fields = []
    for field in structs.STRUCTS[name].fields:
        fields.append((field.name, _c_type(field.type)))
        if field.name == last:
            break
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def derive() -> dict[str, int]:
    """Byte offset of each field: "nuserdata" in mjModel; "time" and POINTERS in mjData."""
    try:
        offsets = {"nuserdata": _c_struct("mjModel", "nuserdata").nuserdata.offset}
        data = _c_struct("mjData")
        offsets |= {name: getattr(data, name).offset for name in ("time", *POINTERS)}
    except (AttributeError, KeyError) as missing:
        raise _refusal(f"its headers do not describe {missing} as expected") from None
    return offsets


def probe(size: int) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A model in which no two of the arrays in question share an address, with `size` free bodies."""
    bodies = "\n".join(BODY.format(k=k) for k in range(size))
    actuators = "\n".join(ACTUATOR.format(k=k) for k in range(size))
    model = mujoco.MjModel.from_xml_string(PROBE.format(nuserdata=100 + 7 * size, bodies=bodies, actuators=actuators))
    return model, mujoco.MjData(model)


def verify(offsets: dict[str, int], model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Raise InputError, naming the MuJoCo version, unless every offset leads to the field of its name."""
    if ctypes.c_int64.from_address(model._address + offsets["nuserdata"]).value != model.nuserdata:
        raise _refusal("mjModel.nuserdata is not where its headers say")
    data.time = 1.0 / 3.0
    time = ctypes.c_double.from_address(data._address + offsets["time"])
    if time.value != data.time:
        raise _refusal("mjData.time is not where its headers say")
    data.time = 0.0
    for name in POINTERS:
        array = getattr(data, name)
        address = ctypes.c_size_t.from_address(data._address + offsets[name]).value
        if array.dtype != float or address != array.ctypes.data:
            raise _refusal(f"mjData.{name} is not where its headers say")
        last = ctypes.c_double.from_address(address + 8 * (array.size - 1))
        kept, last.value = last.value, 1.0 / 3.0
        if array.flat[array.size - 1] != 1.0 / 3.0:
            raise _refusal(f"mjData.{name} cannot be written through its address")
        last.value = kept


OFFSETS = derive()
for _size in (2, 5):
    verify(OFFSETS, *probe(_size))
