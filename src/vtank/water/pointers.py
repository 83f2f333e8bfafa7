"""MuJoCo's memory as arrays, for compiled callbacks, which get addresses and nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import carray, types
from numba.extending import intrinsic

from ..compiled import term
from ..plant.sixdof import Vector, Wrench

NUMBER = 8  # [bytes] of a float64


@intrinsic
def memory(typing_context: Any, address: Any) -> Any:
    """The memory at an address, as a C pointer to float64."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> ir.Value:
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return types.CPointer(types.float64)(types.intp), generate


@term
def array_at(address: int, shape: Any) -> np.ndarray:
    """The float64 array of that shape at an address."""
    return carray(memory(address), shape)


@term
def word_at(address: int) -> int:
    """The 64-bit integer at an address."""
    return array_at(address, 1).view(np.int64)[0]


@term
def numbers(field: int, row: int, shape: Any) -> np.ndarray:
    """Float64 numbers of the array whose address stands at `field`, from its element `row` on."""
    return array_at(word_at(field) + NUMBER * row, shape)


@term
def whole(field: int, size: int) -> np.ndarray:
    """The int32 array whose address stands at `field`."""
    return array_at(word_at(field), size).view(np.int32)


@term
def choice(address: int) -> int:
    """The int32 number at an address."""
    return array_at(address, 1).view(np.int32)[0]


@term
def triple(array: np.ndarray, start: int) -> Vector:
    """Three consecutive numbers."""
    return array[start], array[start + 1], array[start + 2]


@term
def six(array: np.ndarray, start: int) -> Wrench:
    """Six consecutive numbers."""
    return *triple(array, start), *triple(array, start + 3)


@term
def matrix(array: np.ndarray, start: int) -> np.ndarray:
    """The (6, 6) matrix that begins at an index."""
    return array_at(array.ctypes.data + NUMBER * start, (6, 6))


@term
def block(array: np.ndarray, start: int) -> np.ndarray:
    """The (3, 3) matrix that begins at an index."""
    return array_at(array.ctypes.data + NUMBER * start, (3, 3))
