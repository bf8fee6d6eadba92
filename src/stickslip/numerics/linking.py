"""Kernels of numba, each optimised once: in the machine code of what Python calls.

Numba optimises and emits a function by itself, and again inside each function that calls it, down
to the last callee. Here a kernel that kernels call is a *part*, typed and lowered only. What Python
calls is its part in a wrapper, with all parts that it needs linked in, each once, optimised and
emitted as a whole (docs/notes/0009).
"""

from __future__ import annotations

import gc
import hashlib
import importlib
import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, cached_property
from types import SimpleNamespace
from typing import Any, ClassVar

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import cgutils, compiler, entrypoints, types
from numba.core.codegen import CodeLibrary, JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.environment import Environment
from numba.core.imputils import builtin_registry
from numba.core.registry import CPUDispatcher

from stickslip.numerics import kernel_cache
from stickslip.numerics.translation.codes import Descriptor, around
from stickslip.numerics.translation.statements import translate
from stickslip.numerics.translation.values import NotUnderstood
from stickslip.numerics.waiting import WATCH

# LLVM's 250, and what five numbers count: kernels pass so many less for an array than numba does,
# and long laws of one's own are a seventh slower without what was taken in because of them.
INLINED = 275
ADDRESSES = "numba.dynamic.globals"  # names of objects of this process


class _PartLibrary(JITCodeLibrary):
    """Code of a kernel, as lowered, and of all that it calls: each by its hash, callees first."""

    def __init__(self, codegen: Any, codes: dict[str, bytes] | None = None) -> None:
        CodeLibrary.__init__(self, codegen, "part")  # without numba's module for all
        self._codes = codes or {}
        self._finalized = codes is not None

    @property
    def codes(self) -> dict[str, bytes]:
        self._ensure_finalized()
        return self._codes

    def add_linking_library(self, library: Any) -> None:
        library._ensure_finalized()
        self._dynamic_globals += library._dynamic_globals
        if isinstance(library, _PartLibrary):
            self._codes.update(library.codes)
        else:
            self._codes.update(_named(library._get_module_for_linking()))

    def add_ir_module(self, ir_module: Any) -> None:
        """Simplify code and keep it."""
        for function in ir_module.functions:
            if function.blocks:
                function.linkage = "linkonce_odr"
        module = llvm.parse_assembly(cgutils.normalize_ir_text(str(ir_module)))
        module.name = ir_module.name
        module.verify()
        self._optimize_functions(module)
        self._codes.update(_named(module))
        self._dynamic_globals += [name for name in ir_module.globals if name.startswith(ADDRESSES)]

    def _optimize_functions(self, module: llvm.ModuleRef) -> None:
        """As numba does, but for functions only that have code."""
        module.data_layout = self._codegen._data_layout
        try:
            passes, *builder = self._codegen._function_pass_manager()
        except TypeError:  # it takes the module in numba 0.61
            return super()._optimize_functions(module)
        for function in module.functions:
            if not function.is_declaration:
                passes.run(function, *builder)

    def link_into(self, module: llvm.ModuleRef) -> None:
        """Add all code to a module that calls it."""
        # Callers first: the linker drops code that nothing calls yet.
        for code in reversed(self.codes.values()):
            module.link_in(llvm.parse_bitcode(code))

    def finalize(self) -> None:
        self._finalized = True


def _named(module: llvm.ModuleRef) -> dict[str, bytes]:
    code = module.as_bitcode()
    return {hashlib.sha256(code).hexdigest(): code}


class _EntryLibrary(JITCodeLibrary):
    """Machine code of what Python calls: of its own, whatever other code the process has."""

    short_loops = False  # neither made vectors nor unrolled, which takes most of LLVM's time

    def _get_module_for_linking(self) -> llvm.ModuleRef:
        """Tell the names of what is called from outside: nothing links machine code."""
        called = (
            f'define void @"{each.name}"() {{ ret void }}'
            for each in self._final_module.functions
            if not each.is_declaration and each.linkage == llvm.Linkage.external
        )
        return llvm.parse_assembly("\n".join(called))

    def finalize_with(self, part: _PartLibrary) -> None:
        part.link_into(self._final_module)
        self.finalize()

    def _optimize_functions(self, module: llvm.ModuleRef) -> None:
        """Leave the wrapper as it is: it is optimised with all that is linked in."""
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        # No copy of a part serves other machine code, whatever was loaded first (docs/notes/0008).
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr:
                function.linkage = "internal"
        # One pass over all: numba makes two, for counted references, and there are none.
        made = self._codegen._module_pass_manager()
        manager, *builder = made if isinstance(made, tuple) else [made]  # alone in numba 0.61
        if builder:
            tuned = llvm.create_pipeline_tuning_options(speed_level=3)
            tuned.slp_vectorization = True
            tuned.loop_vectorization = tuned.loop_unrolling = not self.short_loops
            tuned.inlining_threshold = INLINED
            builder = [llvm.create_pass_builder(self._codegen._tm, tuned)]
            manager = builder[0].getModulePassManager()
        manager.run(self._final_module, *builder)


class _Flags(compiler.Flags):
    """Numba's flags, one object for all that are equal: a part of each key of typing."""

    _known: ClassVar[dict[str, _Flags]] = {}
    __hash__ = object.__hash__

    def __eq__(self, other: object) -> bool:
        return self is other

    def copy(self) -> _Flags:
        return self

    @classmethod
    def of_parts(cls, flags: Any) -> _Flags:
        """Return flags to compile a part with, which only kernels call."""
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        return cls._known.setdefault(flags.summary(), cls(flags))


class _PartCompiler(compiler.Compiler):
    def __init__(
        self, typing: Any, target: Any, library: Any, args: Any, result: Any, flags: Any, names: Any
    ) -> None:
        library = _PartLibrary(target.codegen())
        super().__init__(typing, target, library, args, result, _Flags.of_parts(flags), names)


_open: list[Callable[..., Any]] = []  # kernels that wait for those that they call


def _called(thing: Any, kinds: tuple[Any, ...]) -> Any:
    """Part of a kernel, compiled for some types; None of anything else."""
    if not isinstance(thing, Kernel):
        return None
    if thing.py_func in _open:
        raise NotUnderstood("recursion")
    return thing.part.compile(kinds)


def _result(target: Any, signature: Any, descriptor: Any, library: Any, entry: Any) -> Any:
    known = {
        "target_context": target,
        "typing_context": target.typing_context,
        "signature": signature,
        "fndesc": descriptor,
        "library": library,
        "objectmode": False,
        "lifted": (),
        "reload_init": (),
        "entry_point": entry,
    }
    return compiler.CompileResult(**(dict.fromkeys(compiler.CR_FIELDS) | known))


class _PartCache(kernel_cache.KernelCache):
    """Keeps a part: its type, and the code of all that it needs, each in a file for all parts."""

    MARK = "-part"

    def reduce(self, made: Any) -> bytes:
        made.fndesc.typemap = made.fndesc.calltypes = None
        for name, code in made.library.codes.items():
            kernel_cache.keep_code(name, code)
        return pickle.dumps((made.signature, made.fndesc, list(made.library.codes)))

    def rebuild(self, target: Any, payload: Any) -> Any:
        signature, descriptor, names = payload
        codes: dict[str, bytes] = {}
        for name in names:
            code = kernel_cache.kept_code(name)
            if code is None:
                return None
            codes[name] = code
        library = _PartLibrary(target.codegen(), codes)
        entry = object()  # a name for callers: nothing runs it
        return _result(target, signature, descriptor, library, entry)


class _Part(CPUDispatcher):
    """What kernels call."""

    def __init__(self, entry: Kernel) -> None:
        super().__init__(
            entry.py_func, targetoptions=entry.targetoptions, pipeline_class=_PartCompiler
        )
        self._cache: Any = _PartCache(entry.py_func, entry.folder)

    def compile(self, sig: Any) -> Any:
        """Translate the kernel for some types; numba's own way if the text is not understood."""
        args = tuple(sig)
        if args in self.overloads:
            return self.overloads[args]
        made = self._cache.load_overload(args, self.targetctx)
        if made is None:
            _open.append(self.py_func)
            try:
                made = self.translated(args)
            except NotUnderstood:
                super().compile(args)
                return self.overloads[args]
            finally:
                _open.remove(self.py_func)
            WATCH.compiled += 1
            self._cache.save_overload(args, made)
        self.overloads[args] = made
        return made

    def translated(self, args: tuple[Any, ...]) -> Any:
        """Translate the kernel, or say that its text is not understood."""
        flags: Any = compiler.Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        state = SimpleNamespace(args=args, flags=_Flags.of_parts(flags))
        target = state.targetctx = narrowed(self.targetctx, state.flags)
        state.typingctx = target.typing_context
        state.library = _PartLibrary(target.codegen())
        signature, descriptor = translate(self.py_func, state, _called)
        return _result(target, signature, descriptor, state.library, None)

    def add_overload(self, made: Any) -> None:
        self.overloads[tuple(made.signature.args)] = made

    def get_overload(self, args: Any) -> Any:
        """Name by which kernels that numba compiles call this one."""
        made = _as_numba_calls(self.overloads[tuple(args)])
        name = object()
        made.target_context.insert_user_function(name, made.fndesc, [made.library])
        return name


@cache
def narrowed(target: Any, flags: _Flags) -> Any:
    """Numba's target for some flags: one for all kernels that have these."""
    return compiler._make_subtarget(target, flags)


def _as_numba_calls(made: Any) -> Any:
    """Add to a translated part the function that numba calls."""
    target, library = made.target_context, made.library
    if isinstance(made.fndesc, Descriptor):
        library = _PartLibrary(target.codegen())
        module = library.create_ir_module("around")
        around(target, module, made.fndesc)
        library.add_linking_library(made.library)
        library.add_ir_module(module)
    return made._replace(library=library)


@contextmanager
def _without_collector() -> Iterator[None]:
    """Collect no cycles of objects: the code of kernels is half a million that are needed."""
    collected = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collected:
            gc.enable()


class _EntryCompiler(_FunctionCompiler):
    def __init__(self, entry: Kernel) -> None:
        super().__init__(entry.py_func, entry.targetdescr, entry.targetoptions, {}, None)
        self._entry = entry

    @_without_collector()
    def _compile_core(self, args: Any, result: Any) -> Any:
        made = self._entry.lowered(args)
        target, descriptor = made.target_context, made.fndesc
        library = _EntryLibrary(target.codegen(), descriptor.qualname)
        library.enable_object_caching()
        library.short_loops = self._entry.short_loops
        environment = Environment.from_fndesc(descriptor)
        target.create_cpython_wrapper(library, descriptor, environment, None, release_gil=True)
        library.finalize_with(made.library)
        call = target.get_executable(library, descriptor, environment)
        return made._replace(
            library=library, environment=environment, entry_point=call, metadata={}
        )


class Kernel(CPUDispatcher):
    """What Python calls, kept in a folder of the cache; kernels that name it call its part."""

    def __init__(
        self,
        function: Callable[..., Any],
        options: dict[str, Any],
        folder: str | None,
        short_loops: bool = False,
    ) -> None:
        super().__init__(function, targetoptions=options)
        self.short_loops = short_loops
        self.folder = folder
        self._outside: list[Any] = []  # machine code lives as long as this
        self._cache: Any = kernel_cache.KernelCache(function, folder)

    def _compilation_chain_init_hook(self) -> None:
        """Leave numba's extensions to the compiler: looking for them takes a while."""

    def compile(self, sig: Any) -> Any:
        """Compile for some types, unless another process does."""
        with self._cache.turn(sig, self.targetctx):
            self._compiler = _EntryCompiler(self)  # not before: most kernels only kernels call
            return super().compile(sig)

    @cached_property
    def part(self) -> Any:
        """What kernels call; made when one does, or when this is compiled."""
        return _Part(self)

    def lowered(self, args: tuple[Any, ...]) -> Any:
        """Its part for some types, typed and lowered, as numba calls it."""
        with global_compiler_lock:
            _believe_in_blas()
            entrypoints.init_all()
            _refresh(self.targetctx)  # not before: what was compiled runs without it
            return _as_numba_calls(self.part.compile(args))

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.part)

    def address(self, args: tuple[Any, ...]) -> int:
        """Where its machine code for some types is, called as numba calls functions."""
        made = self.lowered(args)
        target, name = made.target_context, made.fndesc.llvm_func_name
        library = _EntryLibrary(target.codegen(), name)
        module = library.create_ir_module("address")
        kind = target.call_conv.get_function_type(made.fndesc.restype, args)
        # What nothing outside calls is optimised for its callers: one that stays as it is.
        outside = ir.Function(module, kind, f"{name}.outside")
        builder = ir.IRBuilder(outside.append_basic_block())
        builder.ret(builder.call(ir.Function(module, kind, name), outside.args))
        with global_compiler_lock:
            library.add_ir_module(module)
            library.finalize_with(made.library)
        self._outside.append(library)
        return int(library.get_pointer_to_function(outside.name))


def _refresh(target: Any) -> None:
    """Have numba read what is registered, once: each of 250 methods asks for it again."""
    target.load_additional_registries()
    target.install_registry(builtin_registry)
    target.refresh = lambda: None
    try:
        target.typing_context.refresh()
    finally:
        del target.refresh
    target.refresh()


@cache
def _believe_in_blas() -> None:
    """Keep numba from loading scipy.linalg, a tenth of a second."""
    # Numba only asks whether there is a BLAS, when it compiles its first function. SciPy is always
    # there; a function that needs its BLAS loads it when it is compiled.
    with suppress(ImportError, AttributeError):
        linalg: Any = importlib.import_module("numba.np.linalg")
        ensure, linalg.ensure_blas = linalg.ensure_blas, lambda: None
        try:
            importlib.import_module("numba.np.arraymath")
        finally:
            linalg.ensure_blas = ensure


def linked(
    kernel: Kernel, kinds: tuple[Any, ...], name: str, arguments: Callable[[Any, Any], list[Any]]
) -> llvm.ModuleRef:
    """Code of a function without arguments that calls a kernel, and of all that it needs.

    `arguments` gets numba's target and a builder, and gives the values that the kernel is called
    with. Nothing is optimised yet.
    """
    made = kernel.lowered(kinds)
    target, known = made.target_context, made.fndesc
    module = _EntryLibrary(target.codegen(), name).create_ir_module(name)
    outside = ir.Function(module, ir.FunctionType(ir.VoidType(), []), name)
    builder = ir.IRBuilder(outside.append_basic_block())
    kind = target.call_conv.get_function_type(known.restype, kinds)
    callee = ir.Function(module, kind, known.llvm_func_name)
    values = arguments(target, builder)
    target.call_conv.call_function(builder, callee, known.restype, kinds, values)
    builder.ret_void()
    whole = llvm.parse_assembly(str(module))
    made.library.link_into(whole)
    return whole
