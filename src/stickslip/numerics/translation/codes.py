"""Code of values: on the stack, joined and apart, and on the way from kernel to kernel.

A tuple is the parts it is made of, and an array its place and its shape, from the arguments of a
kernel to the calls that pass them on: nobody joins them on the way. Numba joins and passes all
that it knows of them: five of six instructions of kernels that hand a motion on.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from functools import cache, reduce
from itertools import accumulate
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, itanium_mangler
from numba.core.funcdesc import PythonFunctionDescriptor

from stickslip.numerics.translation.values import NotUnderstood, Value, known, types

WORD, HALF = ir.IntType(64), ir.IntType(32)
DATA, SHAPE, STRIDES = 4, 5, 6  # of numba's arrays, after two objects, a count and a size


class Descriptor(PythonFunctionDescriptor):
    """Tells numba of a translated kernel: others call `inner`, numba a function `around` it."""

    def __init__(self, told: Any, state: Any, result: Any) -> None:
        super().__init__(  # type: ignore[no-untyped-call]
            True,
            told.func.__module__,
            told.func_qualname,
            told.unique_name,
            "",
            None,
            result,
            None,
            tuple(told.arg_names),
            (),
            mangler=mangled,
            argtypes=tuple(state.args),
            inline=state.flags.forceinline,
            noalias=state.flags.noalias,
            abi_tags=[state.flags.get_mangle_string()],
            uid=told.unique_id,
        )


def mangled(name: str, kinds: Any, *, abi_tags: Any = (), uid: Any = None) -> str:
    """Name a kernel in LLVM's code: numba's names tell all types, thousands of letters."""
    told = hashlib.sha256(repr((kinds, abi_tags)).encode()).hexdigest()[:16]
    return str(itanium_mangler.mangle(name, (), abi_tags=(told,), uid=uid))


@cache
def carried(models: Any, kind: Any) -> Any:
    """Types of what kernels pass to kernels for a value, nested as the value is."""
    if kind is types.none:
        return ()
    if isinstance(kind, types.BaseTuple):
        return tuple(carried(models, each) for each in kind.types)
    passed = models[kind].get_argument_type()
    if isinstance(kind, types.Array):
        return _needed(kind, passed)
    if isinstance(passed, tuple):
        raise NotUnderstood(f"a {kind} as an argument")
    return passed


def _needed(kind: Any, fields: Any) -> tuple[Any, list[Any], list[Any]]:
    """Take from all that numba passes for an array its place, its shape and strides if need be."""
    strides = [] if kind.layout == "C" else list(fields[STRIDES])
    return fields[DATA], list(fields[SHAPE]), strides


def flat(codes: Any) -> Iterator[Any]:
    """Read what is in a nested list."""
    if not isinstance(codes, (tuple, list)):
        yield codes
    else:
        for each in codes:
            yield from flat(each)


@cache
def _first(context: Any, result: Any) -> Any:
    """Declare a kernel without arguments: what numba says of places for results and errors."""
    kind = context.call_conv.get_function_type(result, ())
    function = ir.Function(ir.Module(), kind, "first")
    context.call_conv.decorate_function(function, (), ())
    return function


@cache
def _passed(models: Any, kinds: tuple[Any, ...]) -> tuple[Any, ...]:
    """Types of all that kernels pass for some arguments."""
    return tuple(flat([carried(models, kind) for kind in kinds]))


def inner(context: Any, module: Any, told: Descriptor) -> Any:
    """Declare the function of a kernel in a module."""
    name = f"{told.mangled_name}.inner"
    if name in module.globals:
        return module.globals[name]
    first = _first(context, told.restype)
    kind, passed = first.function_type, _passed(context.data_model_manager, told.argtypes)
    function = ir.Function(module, ir.FunctionType(kind.return_type, [*kind.args, *passed]), name)
    for one, other in zip(function.args, first.args, strict=False):
        one.attributes = other.attributes
    if told.inline:
        function.attributes.add("alwaysinline")
    return function


def around(context: Any, module: Any, told: Descriptor) -> None:
    """Write the function that numba calls, with more arguments than the kernel needs."""
    function = context.declare_function(module, told)
    builder = ir.IRBuilder(function.append_basic_block())
    fields = context.get_arg_packer(told.argtypes)._unflattener.unflatten(function.args[2:])
    passed = [_chosen(*each) for each in zip(told.argtypes, fields, strict=True)]
    builder.ret(builder.call(inner(context, module, told), [*function.args[:2], *flat(passed)]))


def _chosen(kind: Any, codes: Any) -> Any:
    """Take what kernels pass from what numba passes."""
    if kind is types.none:
        return []
    if isinstance(kind, types.BaseTuple):
        return [_chosen(*each) for each in zip(kind.types, codes, strict=True)]
    return _needed(kind, codes) if isinstance(kind, types.Array) else codes


class Codes:
    """Writes code of values into one kernel."""

    def __init__(self, context: Any, called: Callable[..., Any]) -> None:
        self.context, self.called = context, called
        self.builder: Any = None
        self.code: Any = None
        self.entry: Any = None

    def block(self) -> Any:
        """Begin a block of code."""
        return self.code.append_basic_block()

    def room(self, type_: Any) -> Any:
        """Place on the stack for something of a type of LLVM, or of each of its parts."""
        if isinstance(type_, (tuple, list)):
            return [self.room(each) for each in type_]
        with self.builder.goto_block(self.entry):
            return self.builder.alloca(type_)

    def slot(self, kind: Any) -> Any:
        """Place for a value, of a tuple for each part."""
        if isinstance(kind, types.BaseTuple):
            return [self.slot(each) for each in kind.types]
        if isinstance(kind, types.Array):
            return self.room(carried(self.context.data_model_manager, kind))
        return self.room(self.context.get_value_type(kind))

    def store(self, value: Value, kind: Any, slot: Any) -> None:
        """Keep a value, as another type, in a slot."""
        if isinstance(kind, types.BaseTuple):
            for part, *each in zip(self.tuple_parts(value), kind.types, slot, strict=True):
                self.store(part, *each)
        elif isinstance(kind, types.Array):
            array = value if value.kind == kind else Value(kind, self.cast(value, kind))
            for code, place in zip(flat(self.fields_of(array)), flat(slot), strict=True):
                self.builder.store(code, place)
        else:
            self.builder.store(self.cast(value, kind), slot)

    def load(self, kind: Any, slot: Any) -> Value:
        """Read what a slot holds."""
        if isinstance(kind, types.BaseTuple):
            parts = [self.load(*each) for each in zip(kind.types, slot, strict=True)]
            return Value(kind, parts=parts)
        if isinstance(kind, types.Array):
            return self.argument(kind, map(self.builder.load, flat(slot)))
        if kind is types.none:
            return known(kind, None)
        return Value(kind, self.builder.load(slot))

    def code_of(self, value: Value) -> Any:
        """Code of a value: of a known one a constant."""
        if value.given is not None:
            return value.given
        if value.parts is not None or value.fields is not None:
            if value.made is None or value.made[0] is not self.builder.block:
                value.made = self.builder.block, self.whole_of(value)
            return value.made[1]
        if value.kind is types.none:
            return self.context.get_dummy_value()
        if value.known and value.kind is not None:
            return self.constant(value)
        raise NotUnderstood("an object as a value")

    def whole_of(self, value: Value) -> Any:
        """Code of a tuple or an array, joined of its parts."""
        context, builder, kind = self.context, self.builder, value.kind
        if value.fields is None:
            codes = [self.code_of(each) for each in value.parts or ()]
            return context.make_tuple(builder, kind, codes)
        data, shape, strides = value.fields
        size = WORD(context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        if kind.layout == "C":
            strides = list(accumulate(reversed(shape[1:]), builder.mul, initial=size))[::-1]
        passed = context.data_model_manager[kind].get_argument_type()
        nobody = [each(None) for each in passed[:2]]  # holds the memory: references are not counted
        fields = [*nobody, self.count_of(value), size, data, shape, strides[: len(shape)]]
        return context.get_argument_value(builder, kind, fields)

    def fields_of(self, array: Value) -> Any:
        """Code of where an array lies, of its shape, and of strides that are not told by it."""
        if array.fields is not None:
            return array.fields
        code = self.code_of(array)
        axes = range(array.kind.ndim)
        taken = self.builder.extract_value
        strides = () if array.kind.layout == "C" else axes
        return (
            taken(code, DATA),
            [taken(code, [SHAPE, k]) for k in axes],
            [taken(code, [STRIDES, k]) for k in strides],
        )

    def spread(self, value: Value) -> Value:
        """Take an array apart where it is made: its fields are there wherever the array is."""
        if isinstance(value.kind, types.Array):
            value.fields = self.fields_of(value)
        return value

    def count_of(self, array: Value) -> Any:
        """Code of how many elements an array has."""
        return reduce(self.builder.mul, self.fields_of(array)[1] or [WORD(1)])

    def constant(self, value: Value) -> Any:
        """Code of a known number or array."""
        kind, thing = value.kind, value.object
        if kind in (types.float64, types.int64, types.uint64, types.boolean):
            number = thing.item() if isinstance(thing, np.generic) else thing
            return ir.Constant(self.context.get_value_type(kind), number)
        return self.context.get_constant_generic(self.builder, kind, thing)

    def cast(self, value: Value, kind: Any) -> Any:
        """Code of a value as another type."""
        if value.kind == kind:
            return self.code_of(value)
        if value.known and kind == types.float64 and isinstance(value.object, (int, float)):
            return ir.Constant(ir.DoubleType(), float(value.object))
        return self.context.cast(self.builder, self.code_of(value), value.kind, kind)

    def part(self, value: Value, place: int) -> Value:
        """Part of a tuple."""
        if value.parts is not None:
            return value.parts[place]
        kind = value.kind.types[place]
        if kind is types.none:
            return known(kind, None)
        return Value(kind, self.builder.extract_value(self.code_of(value), place))

    def tuple_parts(self, value: Value) -> list[Value]:
        """Parts of a tuple."""
        return [self.part(value, k) for k in range(len(value.kind.types))]

    # --- kernels --------------------------------------------------------------------------------

    def argument(self, kind: Any, codes: Iterator[Any]) -> Value:
        """Read an argument of this kernel."""
        if kind is types.none:
            return known(kind, None)
        if isinstance(kind, types.BaseTuple):
            return Value(kind, parts=[self.argument(each, codes) for each in kind.types])
        if isinstance(kind, types.Array):
            array = Value(kind)
            data, *axes = (next(codes) for _ in _passed(self.context.data_model_manager, (kind,)))
            array.fields = data, axes[: kind.ndim], axes[kind.ndim :]
            return array
        return Value(kind, self.context.get_argument_value(self.builder, kind, next(codes)))

    def passed(self, value: Value) -> Iterator[Any]:
        """Codes of an argument of another kernel."""
        kind = value.kind
        if isinstance(kind, types.BaseTuple):
            for part in self.tuple_parts(value):
                yield from self.passed(part)
        elif isinstance(kind, types.Array):
            yield from flat(self.fields_of(value))
        elif kind is not types.none:
            yield self.context.get_value_as_argument(self.builder, kind, self.code_of(value))

    def result_of(self, part: Any, values: list[Value]) -> Value:
        """Call a kernel."""
        builder, context, told = self.builder, self.context, part.fndesc
        context.add_linking_libs([part.library])
        if isinstance(told, Descriptor):
            callee = inner(context, builder.module, told)
            codes = [code for value in values for code in self.passed(value)]
        elif isinstance(told.restype, types.Optional):
            raise NotUnderstood("a result that may be none")
        else:
            callee = context.declare_function(builder.module, told)
            given = [(value.kind, self.code_of(value)) for value in values]
            codes = [
                code for one in given for code in flat(context.get_value_as_argument(builder, *one))
            ]
        place = self.room(callee.args[0].type.pointee)
        status = builder.call(callee, [place, self.code.args[1], *codes])
        with cgutils.if_unlikely(builder, builder.icmp_signed("!=", status, status.type(0))):
            builder.ret(status)
        return self.taken(told.restype, place)

    def taken(self, kind: Any, place: Any) -> Value:
        """Read the result of a kernel from where the kernel put it."""
        if kind is types.none:
            return known(kind, None)
        if isinstance(kind, types.BaseTuple):
            parts = [self.taken(each, self.place_of(place, k)) for k, each in enumerate(kind.types)]
            return Value(kind, parts=parts)
        code = self.builder.load(place)
        if code.type != self.context.get_value_type(kind):
            code = self.context.data_model_manager[kind].from_data(self.builder, code)
        return self.spread(Value(kind, code))

    def put_result(self, kind: Any, value: Value, place: Any) -> None:
        """Put the result of this kernel where the caller takes it from."""
        if isinstance(kind, types.BaseTuple) and len(kind.types):
            for k, part in enumerate(self.tuple_parts(value)):
                self.put_result(kind.types[k], part, self.place_of(place, k))
            return
        code = self.cast(value, kind)
        if code.type != place.type.pointee:
            code = self.context.get_value_as_data(self.builder, kind, code)
        self.builder.store(code, place)

    def place_of(self, tuple_: Any, k: int) -> Any:
        """Where a part of a tuple is."""
        return self.builder.gep(tuple_, [HALF(0), HALF(k)], inbounds=True)
