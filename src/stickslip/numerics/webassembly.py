"""Kernels as a WebAssembly module: the same code, optimised for browsers.

Every argument has its place in the module's memory, whose addresses are known here: a caller writes
numbers there, calls an entry without arguments, and reads what it left. LLVM writes an object;
what a linker would add, the list of exports, is added here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

import llvmlite.binding as llvm
import msgspec
import numpy as np
from llvmlite import ir
from numba import typeof
from numba.core import types
from numba.np import arrayobj

from stickslip.numerics.linking import Kernel, linked

TRIPLE: Final = "wasm32-unknown-unknown"
FEATURES: Final = "+bulk-memory,+mutable-globals,+nontrapping-fptoint,+sign-ext"
FIRST: Final = 1 << 19
"""First address of arguments; constants lie from 0 on, the stack ends here."""
SECTION: Final = "stickslip"
"""Custom section with the places of arguments, as JSON."""
_I64: Final = ir.IntType(64)


@dataclass
class Memory:
    """Where arguments are: arrays that share memory here share it there."""

    end: int = FIRST
    places: dict[str, tuple[int, str, tuple[int, ...]]] = field(default_factory=dict)
    arrays: dict[int, tuple[int, np.ndarray[Any, Any]]] = field(default_factory=dict)

    def place(self, name: str, array: np.ndarray[Any, Any]) -> int:
        """Return the address of an array."""
        root: Any = array
        while isinstance(root.base, np.ndarray):
            root = root.base
        if id(root) not in self.arrays:
            self.arrays[id(root)] = (self.end, root)
            self.end += -(-max(root.nbytes, 1) // 16) * 16
        address = self.arrays[id(root)][0] + array.ctypes.data - root.ctypes.data
        self.places[name] = (address, array.dtype.str[1:], array.shape)
        return address

    def described(self) -> bytes:
        """Return places, size, and what is not zero at first."""
        filled = [
            (address, array.tobytes().hex())
            for address, array in self.arrays.values()
            if np.any(array)
        ]
        return msgspec.json.encode({"places": self.places, "end": self.end, "filled": filled})


def web_module(entries: Mapping[str, tuple[Kernel, Mapping[str, Any]]]) -> bytes:
    """Compile a module with an entry for each kernel; arguments by name, arrays, numbers, tuples.

    It imports its memory, a stack pointer and functions of C's mathematical library.
    """
    memory, whole = Memory(), llvm.parse_assembly("")
    for name, (kernel, arguments) in entries.items():
        kinds = tuple(map(typeof, arguments.values()))
        whole.link_in(linked(kernel, kinds, name, partial(_values, memory, name, arguments)))
    return _exporting(_object(whole, set(entries)), set(entries), memory.described())


def _values(
    memory: Memory, entry: str, arguments: Mapping[str, Any], target: Any, builder: Any
) -> list[Any]:
    return [
        _placed(target, builder, typeof(value), value, memory, f"{entry}.{name}")
        for name, value in arguments.items()
    ]


def _placed(target: Any, builder: Any, kind: Any, value: Any, memory: Memory, name: str) -> Any:
    """Give a value its place, and say where it is, or what it is there."""
    if isinstance(kind, types.NoneType):
        return target.get_dummy_value()
    if isinstance(kind, types.BaseTuple):
        names: Any = getattr(value, "_fields", range(len(value)))
        kinds: Any = kind
        found = [
            _placed(target, builder, of, part, memory, f"{name}.{key}")
            for of, part, key in zip(kinds, value, names, strict=True)
        ]
        return target.make_tuple(builder, kind, found)
    if not isinstance(kind, types.Array):
        place = memory.place(name, np.array(value, np.float64 if kind == types.float64 else int))
        at = builder.inttoptr(_I64(place), target.get_data_type(kind).as_pointer())
        return builder.load(at)
    place = memory.place(name, value)
    array = arrayobj.make_array(kind)(target, builder)
    arrayobj.populate_array(
        array,
        data=builder.inttoptr(_I64(place), target.get_data_type(kind.dtype).as_pointer()),
        shape=[_I64(n) for n in value.shape],
        strides=[_I64(n) for n in value.strides],
        itemsize=_I64(value.itemsize),
        meminfo=None,
    )
    return array._getvalue()


def _object(module: llvm.ModuleRef, entries: set[str]) -> bytes:
    """Optimise for browsers; all but the entries is private."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple(TRIPLE)
    machine = target.create_target_machine(opt=3, features=FEATURES)
    text = str(module)
    for name, value in (("triple", TRIPLE), ("datalayout", str(machine.target_data))):
        text = re.sub(rf'^target {name} = ".*"$', f'target {name} = "{value}"', text, flags=re.M)
    text = re.sub(r'"(target-cpu|target-features)"="[^"]*"', "", text)
    module = llvm.parse_assembly(text)
    for item in [*module.functions, *module.global_variables]:
        if not item.is_declaration and item.name not in entries:
            item.linkage = "internal"
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(3))
    builder.getModulePassManager().run(module, builder)
    return bytes(machine.emit_object(module))


# --- what a linker would do: https://webassembly.github.io/spec/core/binary/modules.html,
# --- https://github.com/WebAssembly/tool-conventions/blob/main/Linking.md

CUSTOM, EXPORT, ELEMENT, SYMBOLS = 0, 7, 9, 8
UNDEFINED, EXPLICIT_NAME = 0x10, 0x40
FUNCTION, DATA, OF_SECTION = 0, 1, 3


@dataclass
class _Reader:
    data: bytes
    at: int = 0

    def number(self) -> int:
        """Read an unsigned LEB128 number."""
        value = shift = 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    def bytes(self) -> bytes:
        """Read a length and as many bytes."""
        length = self.number()
        self.at += length
        return self.data[self.at - length : self.at]

    def more(self) -> bool:
        return self.at < len(self.data)


def _number(value: int) -> bytes:
    low, high = value & 127, value >> 7
    return bytes([low | 128]) + _number(high) if high else bytes([low])


def _sized(data: bytes) -> bytes:
    return _number(len(data)) + data


def _sections(code: bytes) -> Iterator[tuple[int, bytes]]:
    reader = _Reader(code, 8)
    while reader.more():
        yield reader.number(), reader.bytes()


def _exporting(code: bytes, entries: set[str], described: bytes) -> bytes:
    """Make a module of an object: exports and a description come in, notes for linkers go."""
    sections = list(_sections(code))
    numbers = dict(_functions(sections))
    listed = [_sized(name.encode()) + b"\0" + _number(numbers[name]) for name in sorted(entries)]
    kept = [(kind, body) for kind, body in sections if kind != CUSTOM]
    kept.append((EXPORT, _number(len(listed)) + b"".join(listed)))
    # Sections stand in the order of their numbers, but for the count of data (12), before the code.
    kept.sort(key=lambda section: ELEMENT + 0.5 if section[0] == 12 else section[0])
    kept.append((CUSTOM, _sized(SECTION.encode()) + described))
    return code[:8] + b"".join(_number(kind) + _sized(body) for kind, body in kept)


def _functions(sections: list[tuple[int, bytes]]) -> Iterator[tuple[str, int]]:
    """Names and numbers of the functions that an object defines."""
    for kind, body in sections:
        reader = _Reader(body)
        if kind != CUSTOM or reader.bytes() != b"linking":
            continue
        reader.number()  # version
        while reader.more():
            part, table = reader.number(), _Reader(reader.bytes())
            if part == SYMBOLS:
                yield from _symbols(table)


def _symbols(table: _Reader) -> Iterator[tuple[str, int]]:
    for _ in range(table.number()):
        kind, flags = table.number(), table.number()
        if kind == OF_SECTION:
            table.number()
            continue
        if kind == DATA:
            table.bytes()
            if not flags & UNDEFINED:
                for _ in range(3):
                    table.number()
            continue
        number = table.number()
        if not flags & UNDEFINED or flags & EXPLICIT_NAME:
            name = table.bytes().decode()
            if kind == FUNCTION and not flags & UNDEFINED:
                yield name, number
