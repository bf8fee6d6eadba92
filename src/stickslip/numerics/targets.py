"""Where kernels run: compiling them, binding laws into them, threads."""

from __future__ import annotations

import hashlib
import importlib.util
import linecache
import marshal
import os
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, wait
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from functools import cache
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, TypeVar, overload

import numba
from numba.core import event

from stickslip.numerics import kernel_cache
from stickslip.numerics.linking import Kernel
from stickslip.numerics.threads import IN_PIECES, pool, threads_start
from stickslip.numerics.waiting import waiting

config: Any = numba.config


F = TypeVar("F", bound=Callable[..., Any])

ANNOUNCE_AFTER_SECONDS = 1.0
LASTS = 1_000_000  # points that may take seconds


# --- compiling --------------------------------------------------------------------------------

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "boundscheck": None,
    "error_model": "numpy",
    "_nrt": False,
}
_instance_key = threading.local()
_making = threading.RLock()  # held while a module is made: other threads wait for the whole of it


@overload
def kernel(func: F) -> F: ...
@overload
def kernel(
    *, inline: bool = ..., fused: bool = ..., short_loops: bool = ...
) -> Callable[[F], F]: ...
def kernel(
    func: F | None = None, *, inline: bool = False, fused: bool = False, short_loops: bool = False
) -> F | Callable[[F], F]:
    """Compile a function for the CPU: IEEE rounding, no exceptions, no counted references.

    `inline` compiles it into its callers: for small functions on the hot path. `fused` lets the
    compiler fuse products into sums, a tenth faster over lanes. Of ``a b + c d`` it may fuse
    either, and the last bit may differ between kernels that call it (docs/notes/0008). Of one that
    Python calls `short_loops` says that loops, of all that it calls, are neither unrolled nor made
    vectors: half of what LLVM does where motions are carried one by one, for nothing.
    """
    if func is None:
        return lambda function: _compiled(function, inline, fused, short_loops)
    return _compiled(func, inline, fused, short_loops)


def _compiled(func: F, inline: bool, fused: bool, short_loops: bool) -> F:
    if config.DISABLE_JIT:
        return func
    fastmath = {"contract"} if fused else False
    options = {**OPTIONS, "fastmath": fastmath, "forceinline": inline}
    made: Any = Kernel(func, options, getattr(_instance_key, "value", "plain"), short_loops)
    return made


def kernel_uncached(func: F) -> F:
    """Compile `func` for this process only: code that no other process can import."""
    with _instance(None):
        return kernel(func)


@contextmanager
def _instance(key: str | None) -> Iterator[None]:
    previous = getattr(_instance_key, "value", "plain")
    _instance_key.value = key
    try:
        yield
    finally:
        _instance_key.value = previous


def instantiate(template: str, key: str, **bindings: Any) -> ModuleType:
    """Execute a template module of kernels again, with `bindings` among its globals.

    Numba sees plain global functions, which it inlines and caches; closures would be compiled anew
    in each process. Equal keys give the same instance.
    """
    name = f"{template}[{key}]"
    with _making:
        if name in sys.modules:
            made = sys.modules[name]
            if not bindings.keys() <= vars(made).keys():
                raise ValueError(f"{name} was made with other bindings than {sorted(bindings)}")
            return made
        spec = importlib.util.find_spec(template)
        if spec is None or spec.origin is None:
            raise ModuleNotFoundError(template)
        code = compile(Path(spec.origin).read_text(encoding="utf-8"), spec.origin, "exec")
        return _executed(name, spec.origin, code, key, bindings)


def _executed(
    name: str, file: str, code: CodeType, key: str, bindings: dict[str, Any]
) -> ModuleType:
    """Make a module of kernels, cached by their key; one that fails leaves nothing behind."""
    module = sys.modules[name] = ModuleType(name)
    module.__file__ = file
    module.__dict__.update(bindings)
    try:
        with _instance(key):
            exec(code, module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def write_module(stem: str, text: str) -> ModuleType:
    """Import generated kernel `text`, written as a module, once, so that numba can cache it."""
    key = hashlib.sha256(text.encode()).hexdigest()[:16]
    name = f"{kernel_cache.GENERATED}{stem}_{key}"
    with _making:
        if name in sys.modules:
            return sys.modules[name]
        kernel_cache.kept(f"generated/{name}.txt", text.encode)
        linecache.cache[f"{name}.py"] = (len(text), None, text.splitlines(True), f"{name}.py")
        code = kernel_cache.kept(
            f"generated/{name}.{sys.implementation.cache_tag}.code",
            lambda: marshal.dumps(compile(text, f"{name}.py", "exec")),
        )
        return _executed(name, f"{name}.py", marshal.loads(code), key, {})


class _Announcer(event.Listener):
    """Says on stderr that kernels are being compiled, once it takes longer than a second."""

    # Nobody knows how many a call needs: `waiting` tells how many are ready.

    def __init__(self) -> None:
        self._depth = 0
        self._timer: threading.Timer | None = None
        self._told = ExitStack()

    def on_start(self, event: Any) -> None:
        if not isinstance(event.data["dispatcher"], Kernel):
            return
        self._depth += 1
        if self._depth == 1:
            self._timer = threading.Timer(ANNOUNCE_AFTER_SECONDS, _announce)
            self._timer.daemon = True
            with suppress(RuntimeError):  # no thread to be had: nothing is said
                self._timer.start()
                self._told.enter_context(waiting("compiling kernels"))

    def on_end(self, event: Any) -> None:
        if not isinstance(event.data["dispatcher"], Kernel):
            return
        self._depth -= 1
        if self._depth == 0 and self._timer is not None:
            self._timer.cancel()
            self._told.close()


def _announce() -> None:
    kept = (
        "kept for the next run"
        if kernel_cache.cache_root()
        else "no private cache folder: not kept"
    )
    kernel_cache.tell("compiling", f"compiling kernels, some seconds ({kept}) ...")


event.register("numba:compile", _Announcer())


# --- launching --------------------------------------------------------------------------------


def available_threads() -> int:
    """Count the processor cores that this process may use."""
    if not threads_start():
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def launch(task: Callable[[int, int], None], size: int, threads: int, smallest: int) -> None:
    """Run ``task(start, stop)`` over ``range(size)``, cut into tiles for `threads` threads."""
    if (in_pieces := IN_PIECES.get()) is not None:
        in_pieces(task, size, smallest)
        return
    # Kernels release the interpreter lock. Tiles shrink towards the end, so that all threads end
    # together, but not much below `smallest` items.
    if threads == 1 or size <= smallest:
        task(0, size)
        return
    tiles = iter(list(_tiles(size, threads, smallest)))
    watch = waiting(f"{size} points") if size >= LASTS else nullcontext()

    def work() -> None:
        try:
            for start, stop in tiles:
                if tell is not None:
                    tell(start / size)
                task(start, stop)
        finally:  # after an error nobody begins another tile
            for _ in tiles:
                pass

    with watch as tell:
        others = [_helpers(threads - 1).submit(work) for _ in range(threads - 1)]
        try:
            work()  # this thread, too: it need not be woken, and has its scratch arrays already
        finally:  # a helper that is busy elsewhere is not waited for: its share is done
            begun = [other for other in others if not other.cancel()]
            wait(begun)
    for other in begun:
        other.result()


@cache
def _helpers(threads: int) -> Executor:
    """Threads that wait for the next launch: to start them takes longer than many a tile."""
    return pool(threads, "stickslip")


if hasattr(os, "register_at_fork"):  # a fork has none of its parent's threads
    os.register_at_fork(after_in_child=_helpers.cache_clear)


def _tiles(size: int, threads: int, smallest: int) -> Iterator[tuple[int, int]]:
    """Cut ``range(size)`` into tiles, each a fourth of a thread's share of what is left."""
    start = 0
    while start < size:
        stop = start + max(smallest, (size - start) // (4 * threads))
        if size - stop < smallest // 2:
            stop = size
        yield start, stop
        start = stop
