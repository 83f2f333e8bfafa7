"""Numbers side by side: a numba type that lets one law serve one parameter set or WIDTH of them at once.

A law written for floats is compiled as it stands for `Lanes`, WIDTH doubles in one vector, and then moves WIDTH
parameter sets for about the price of one. Within a law

- arithmetic, powers, comparisons, abs, min, max, math.exp, log, sin, cos, tanh, sqrt and copysign work
  on lanes, plain numbers mix in;
- `x if c else y` and `if c:` ask whether *any* lane fulfils c. They serve to skip work that would change nothing, as in
  `if f != 0.0: force = force - f * math.tanh(u / w)`, which is nothing where f is null;
- a choice that differs from lane to lane is written `where(c, x, y)`.

Rows of a C-contiguous array of shape (N, W), W = WIDTH, are read and written by `load` and `store`; `rows` makes such
an array look like a vector of N lanes that nobody changes, which is how a law sees its parameters. On plain arrays of
shape (N,) the same three work on plain numbers.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import literal_unroll
from numba.core import cgutils, types
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_jitable, register_model
from numba.np.arrayobj import make_array

# [-] doubles in a vector: two registers of AVX-512, whose waiting times overlap; two of AVX2, four of NEON
WIDTH = 16 if get_host_cpu_features().get("avx512f") else 8
VECTOR, BITS = ir.VectorType(ir.DoubleType(), WIDTH), ir.VectorType(ir.IntType(1), WIDTH)
INDEX = ir.IntType(32)


class Lanes(types.Type):
    """WIDTH doubles."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")

    def can_convert_from(self, typingctx: Any, other: types.Type) -> Any:
        """Plain numbers become equal ones."""
        return Conversion.safe if isinstance(other, types.Number) else None


class Mask(types.Type):
    """WIDTH answers to a comparison; as a condition it asks whether any is true."""

    def __init__(self) -> None:
        super().__init__(name="Mask")


class Rows(types.Type):
    """The rows of an array of shape (N, W), as a vector of N lanes."""

    def __init__(self) -> None:
        super().__init__(name="Rows")


LANES, MASK, ROWS = Lanes(), Mask(), Rows()


def _primitive(value: ir.Type) -> Any:
    """A data model that holds one LLVM value."""

    class Model(models.PrimitiveModel):
        def __init__(self, manager: Any, kind: types.Type) -> None:
            super().__init__(manager, kind, value)

    return Model


register_model(Lanes)(_primitive(VECTOR))
register_model(Mask)(_primitive(BITS))
register_model(Rows)(_primitive(VECTOR.as_pointer()))


# --- plain numbers, conditions ---------------------------------------------------------------------------------------
@lower_cast(types.Number, Lanes)
def _spread(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    """Equal lanes."""
    number, empty = context.cast(builder, value, source, types.float64), ir.Constant(VECTOR, ir.Undefined)
    first = builder.insert_element(empty, number, ir.Constant(INDEX, 0))
    return builder.shuffle_vector(first, empty, ir.Constant(ir.VectorType(INDEX, WIDTH), [0] * WIDTH))


@lower_cast(Mask, types.Boolean)
def _any(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    bits = builder.bitcast(value, ir.IntType(WIDTH))
    return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))


def _register(function: Any, result: types.Type, takes: tuple[types.Type, ...], build: Callable[..., Any]) -> None:
    """Make a Python function or operator work on these types; where lanes are taken, plain numbers mix in."""

    class Template(AbstractTemplate):
        key = function

        def generic(self, args: Any, kws: Any) -> Any:
            fits = len(args) == len(takes) and any(a in (LANES, MASK, ROWS) for a in args)
            if fits and all(_takes(t, a) for t, a in zip(takes, args, strict=True)):
                return signature(result, *takes)
            return None

    infer_global(function)(Template)
    lower_builtin(function, *takes)(lambda context, builder, sig, args: build(builder, *args))


def _takes(wanted: types.Type, given: types.Type) -> bool:
    if wanted == types.intp:
        return isinstance(given, types.Integer)
    return given == wanted or (wanted == LANES and isinstance(given, types.Number))


def _compare(sign: str) -> Callable[..., Any]:
    ordered = sign != "!="  # NaN is unequal to everything, and neither above nor below it
    return lambda b, x, y: b.fcmp_ordered(sign, x, y) if ordered else b.fcmp_unordered(sign, x, y)


def _absolute(builder: Any, x: Any) -> Any:
    kind = ir.FunctionType(VECTOR, [VECTOR])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.fabs.v{WIDTH}f64"), [x])


def _of_two(builder: Any, name: str, x: Any, y: Any) -> Any:
    kind = ir.FunctionType(VECTOR, [VECTOR, VECTOR])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), [x, y])


def _row(builder: Any, pointer: Any, index: Any, constant: bool = True) -> Any:
    value = builder.load(builder.gep(pointer, [index]))
    value.align = 8  # numpy promises no more
    if constant:  # nobody writes to what `rows` shows, so that questions about it need be asked only once in a loop
        value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value


PAIR = (LANES, LANES)
for _sign, _operator in zip(("add", "sub", "mul", "div"), ("add", "sub", "mul", "truediv"), strict=True):
    _register(getattr(operator, _operator), LANES, PAIR, lambda b, x, y, name=f"f{_sign}": getattr(b, name)(x, y))
for _sign, _operator in zip(("<", "<=", ">", ">=", "==", "!="), ("lt", "le", "gt", "ge", "eq", "ne"), strict=True):
    _register(getattr(operator, _operator), MASK, PAIR, _compare(_sign))
_register(min, LANES, PAIR, lambda b, x, y: b.select(b.fcmp_ordered("<", y, x), y, x))
_register(max, LANES, PAIR, lambda b, x, y: b.select(b.fcmp_ordered(">", y, x), y, x))
for _function, _name in ((operator.pow, "pow"), (math.pow, "pow"), (math.copysign, "copysign")):
    _register(_function, LANES, PAIR, lambda b, x, y, name=_name: _of_two(b, name, x, y))
_register(abs, LANES, (LANES,), _absolute)
_register(operator.neg, LANES, (LANES,), lambda b, x: b.fneg(x))
_register(operator.and_, MASK, (MASK, MASK), lambda b, x, y: b.and_(x, y))
_register(bool, types.boolean, (MASK,), lambda b, x: _any(None, b, MASK, types.boolean, x))
_register(operator.getitem, LANES, (ROWS, types.intp), _row)


@intrinsic
def lane(typing: Any, x: Any, i: Any) -> Any:
    """Number i of lanes."""
    return types.float64(LANES, types.intp), lambda context, builder, sig, args: builder.extract_element(
        args[0], builder.trunc(args[1], INDEX)
    )


# --- choices, rows ---------------------------------------------------------------------------------------------------
@intrinsic
def _widened(typing: Any, x: Any) -> Any:
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return args[0] if sig.args[0] == LANES else _spread(context, builder, sig.args[0], LANES, args[0])

    return LANES(x), build


@intrinsic
def _chosen(typing: Any, condition: Any, x: Any, y: Any) -> Any:
    return LANES(MASK, LANES, LANES), lambda context, builder, sig, args: builder.select(*args)


def where(condition: Any, x: Any, y: Any) -> Any:
    """x where the condition is true, else y, lane by lane; both are worked out."""
    return np.where(condition, x, y)


@overload(where, strict=False)
def _where(condition: Any, x: Any, y: Any) -> Any:
    if condition == MASK:
        return lambda condition, x, y: _chosen(condition, _widened(x), _widened(y))
    return lambda condition, x, y: x if condition else y


def _pointer(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """Pointer to the first row of an array of shape (N, W)."""
    return builder.bitcast(make_array(kind)(context, builder, array).data, VECTOR.as_pointer())


@intrinsic
def _rows(typing: Any, array: Any) -> Any:
    return ROWS(array), lambda context, builder, sig, args: _pointer(context, builder, sig.args[0], args[0])


@intrinsic
def _loaded(typing: Any, array: Any, i: Any) -> Any:
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _row(builder, _pointer(context, builder, sig.args[0], args[0]), args[1], constant=False)

    return LANES(array, types.intp), build


@intrinsic
def _stored(typing: Any, array: Any, i: Any, value: Any) -> Any:
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = builder.gep(_pointer(context, builder, sig.args[0], args[0]), [args[1]])
        builder.store(args[2], place).align = 8
        return context.get_dummy_value()

    return types.none(array, types.intp, LANES), build


def rows(array: np.ndarray) -> Any:
    """The rows of an array of shape (N, W) as a vector of lanes; an array of shape (N,) as it is."""
    return array


def load(array: np.ndarray, i: int) -> Any:
    """Row i of an array of shape (N, W) as lanes; number i of an array of shape (N,)."""
    return array[i]


def store(array: np.ndarray, i: int, value: Any) -> None:
    """Write lanes into row i of an array of shape (N, W), or a number into an array of shape (N,)."""
    array[i] = value


@overload(rows, strict=False)
def _rows_of(array: Any) -> Any:
    return (lambda array: _rows(array)) if array.ndim == 2 else (lambda array: array)


@overload(load, strict=False)
def _load(array: Any, i: Any) -> Any:
    return (lambda array, i: _loaded(array, i)) if array.ndim == 2 else (lambda array, i: array[i])


@overload(store, strict=False)
def _store(array: Any, i: Any, value: Any) -> Any:
    if array.ndim == 2:
        return lambda array, i, value: _stored(array, i, _widened(value))

    def plain(array: Any, i: Any, value: Any) -> None:
        array[i] = value

    return plain


# --- functions of math: series on all lanes at once, except where an argument is too far out for them
WHOLE = 1.5 * 2.0**52  # added to a number and taken off again, leaves the nearest whole one
FAR: dict[Any, float] = {math.sin: 1e6, math.cos: 1e6, math.exp: 700.0}  # [-] from here on lane by lane
LN2 = float.fromhex("0x1.62e42fefa38p-1"), float.fromhex("0x1.ef35793c7673p-45")  # ln 2 in two parts: k times the
QUARTER = tuple(map(float.fromhex, ("0x1.921fb544p+0", "0x1.0b4611a6p-34", "0x1.3198a2e037073p-69")))  # first is exact
EXP = tuple(1.0 / math.factorial(n) for n in range(13, -1, -1))  # Taylor series, to the last bit within +-ln(2)/2 and
SIN = tuple((-1.0) ** n / math.factorial(2 * n + 1) for n in range(7, -1, -1))  # +-pi/4
COS = tuple((-1.0) ** n / math.factorial(2 * n) for n in range(8, -1, -1))
SATURATED = 20.0  # [-] from where on tanh is one to the last bit


def _native(name: str) -> Any:
    """A function of LLVM on lanes; one that the processor does not have is called lane by lane."""

    @intrinsic
    def called(typing: Any, x: Any) -> Any:
        def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            kind = ir.FunctionType(VECTOR, [VECTOR])
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), args)

        return LANES(LANES), build

    return called


@intrinsic
def _two_to_the(typing: Any, k: Any) -> Any:
    """2^k of whole numbers, given as k + WHOLE: the last bits of that become the exponent."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        whole = ir.VectorType(ir.IntType(64), WIDTH)
        shift, one = (ir.Constant(whole, [bits] * WIDTH) for bits in (52, 1023 << 52))
        return builder.bitcast(builder.add(builder.shl(builder.bitcast(args[0], whole), shift), one), VECTOR)

    return LANES(LANES), build


@register_jitable
def _series(x: Any, coefficients: Any) -> Any:
    """Polynomial in x, the highest power first."""
    y = 0.0 * x
    for c in literal_unroll(coefficients):
        y = y * x + c
    return y


@register_jitable
def _exp(x: Any) -> Any:
    """2^k e^r, where r is what whole multiples of ln 2 leave."""
    shifted = x * (1.0 / LN2[0]) + WHOLE
    k = shifted - WHOLE
    return _series((x - k * LN2[0]) - k * LN2[1], EXP) * _two_to_the(shifted)


@register_jitable
def _wave(x: Any, turn: float) -> Any:
    """Sine of x, or with a turn of one quarter its cosine, from what whole quarters leave (Cody and Waite)."""
    k = (x * (1.0 / QUARTER[0]) + WHOLE) - WHOLE
    r = ((x - k * QUARTER[0]) - k * QUARTER[1]) - k * QUARTER[2]
    quarter = k + turn
    quarter = quarter - 4.0 * ((0.25 * quarter + WHOLE) - WHOLE)  # -2 to 2
    y = where(abs(quarter) == 1.0, _series(r * r, COS), r * _series(r * r, SIN))
    return where(quarter * quarter - quarter > 1.0, -y, y)


@overload(math.tanh, strict=False)
def _tanh(x: Any) -> Any:
    def tanh(x: Any) -> Any:
        y = 1.0 - 2.0 / (_exp(2.0 * min(abs(x), SATURATED)) + 1.0)
        return where(x < 0.0, -y, y)

    return tanh if x == LANES else None


def _learn(function: Callable[[float], float], series: Callable[[Any], Any] | None = None) -> None:
    """Let a function of math work on lanes."""
    each, far = _native(function.__name__), FAR.get(function)

    @overload(function, strict=False)
    def on_lanes(x: Any) -> Any:
        if x != LANES:
            return None
        return (lambda x: each(x) if abs(x) > far else series(x)) if series else lambda x: each(x)


_learn(math.exp, _exp)
_learn(math.sin, register_jitable(lambda x: _wave(x, 0.0)))
_learn(math.cos, register_jitable(lambda x: _wave(x, 1.0)))
_learn(math.log)
_learn(math.sqrt)
