"""Where kernels run: compiling them, caching them on disk, binding laws into them, threads.

Numba's own cache serves stale code when a callee in another file changes (numba issues 3588, 8851,
8926): here a hash over the sources of all kernels and of their imports names the cache folder.
"""

from __future__ import annotations

import hashlib
import importlib.util
import marshal
import os
import pickle
import re
import shutil
import stat
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, ClassVar, TypeVar, overload

import numba
from numba.core import caching, event
from numba.core.serialize import dumps

from stickslip.files import whole_file

config: Any = numba.config


def _believe_in_blas() -> None:
    """Keep numba from loading scipy.linalg, a seventh of the time to the first value."""
    # Numba only asks whether there is a BLAS, when it compiles or loads its first function. SciPy
    # is always there; a function that needs its BLAS loads it when it is compiled.
    with suppress(ImportError, AttributeError):
        linalg: Any = importlib.import_module("numba.np.linalg")
        ensure, linalg.ensure_blas = linalg.ensure_blas, lambda: None
        try:
            importlib.import_module("numba.np.arraymath")
        finally:
            linalg.ensure_blas = ensure


if not config.DISABLE_JIT:
    _believe_in_blas()

F = TypeVar("F", bound=Callable[..., Any])

PACKAGE = Path(__file__).resolve().parents[1]
IMPORT = re.compile(r"^from (stickslip[\w.]*) import ([\w, ]+|\([^)]*\))", re.M)
USES = "from stickslip.numerics.targets import "
BINDS = re.compile(rf"^{USES}.*\b(instantiate|write_module)\b", re.MULTILINE)
GENERATES = re.compile(rf"^{USES}.*\bgenerated_module\b", re.MULTILINE)
OLD_CACHE_SECONDS = 30 * 24 * 3600.0
ANNOUNCE_AFTER_SECONDS = 1.0


# --- the cache folder -------------------------------------------------------------------------


@cache
def source_hash() -> str:
    """Hash of every source file that kernels are made of, and of numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(kernel_sources(PACKAGE)):
        digest.update(path.relative_to(PACKAGE).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def kernel_sources(package: Path) -> set[Path]:
    """Files of kernels and of their generators, what they import (not indented), and so on."""
    files = {path: path.read_bytes().decode() for path in package.rglob("*.py")}
    users = {path: text for path, text in files.items() if USES in text}
    todo = [path for path, text in files.items() if "\n@kernel" in text]
    todo += [path for path, text in users.items() if GENERATES.search(text)]
    found: set[Path] = set()
    while todo:
        path = todo.pop()
        if path not in found:
            found.add(path)
            for match in IMPORT.finditer(files[path]):
                todo.extend(_modules(package, match))
    return found | {path for path, text in users.items() if BINDS.search(text)}


def _modules(package: Path, match: re.Match[str]) -> set[Path]:
    """Files that an import statement reads."""
    base = package.joinpath(*match[1].split(".")[1:])
    inside = {base / f"{name}.py" for name in re.findall(r"\w+", match[2])}
    return {path for path in {base.with_suffix(".py"), *inside} if path.exists()}


def _candidate_roots() -> Iterator[Path]:
    if folder := os.environ.get("STICKSLIP_CACHE_DIR"):
        yield Path(folder)
    if folder := os.environ.get("XDG_CACHE_HOME"):
        yield Path(folder) / "stickslip"
    home = os.path.expanduser("~")  # Path.home() raises where there is none
    if os.path.isabs(home):
        yield Path(home) / ".cache" / "stickslip"
    yield Path(tempfile.gettempdir()) / f"stickslip-{getattr(os, 'getuid', lambda: 0)()}"


def _private_and_writable(folder: Path) -> bool:
    """Make `folder` if need be; whether it can hold code: nobody else can write there."""
    # No level of the path belongs to another user or can be written by others, so that no folder of
    # it can be exchanged later. In a shared folder with the sticky bit, as /tmp, only the owner can
    # exchange what is there; the next level must then be ours, or the system's.
    try:
        for level in reversed((folder, *folder.parents)):
            if not level.exists():
                level.mkdir(0o700)
            if hasattr(os, "getuid") and not _guarded(level.lstat(), last=level == folder):
                return False
        folder.chmod(0o700)
        with tempfile.NamedTemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _guarded(level: os.stat_result, *, last: bool) -> bool:
    owners = {os.getuid()} if last else {0, os.getuid()}
    shared = level.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    sticky = not last and level.st_mode & stat.S_ISVTX
    return level.st_uid in owners and (not shared or bool(sticky))


@cache
def cache_root() -> Path | None:
    """Folder of compiled and generated kernels of this version of the sources, or None.

    The first of ``$STICKSLIP_CACHE_DIR``, ``$XDG_CACHE_HOME``, ``~/.cache`` and the temporary
    folder that this user alone can write. Folders of versions unused for a month go.
    """
    for base in _candidate_roots():
        numba_base = Path(os.path.realpath(base)) / "numba"  # a link could be turned elsewhere
        if _private_and_writable(numba_base):
            root = numba_base / source_hash()
            root.mkdir(exist_ok=True, mode=0o700)
            os.utime(root)
            _prune(numba_base, keep=root)
            return root
    return None


def _prune(base: Path, keep: Path) -> None:
    oldest = time.time() - OLD_CACHE_SECONDS
    for folder in base.iterdir():
        try:
            if folder != keep and folder.stat().st_mtime < oldest:
                shutil.rmtree(folder, ignore_errors=True)
        except OSError:
            continue


# --- files of the cache -----------------------------------------------------------------------
# Each ends in a seal, the hash of its place in the cache and of its content: nothing else is
# executed or unpickled. A pickle, a code object and the text of a module may all have this tail.

SEAL = b"\n# sha256 %s\n"
_told: set[str] = set()


def _seal(path: Path, content: bytes) -> bytes:
    root = cache_root()
    place = path.relative_to(root).as_posix() if root else ""
    return SEAL % hashlib.sha256(place.encode() + b"\0" + content).hexdigest().encode()


def _read(path: Path) -> bytes | None:
    """Content of a file of the cache; None if there is none, or it is not what was written."""
    try:
        sealed = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError:
        sealed = b""
    content = sealed[: -len(SEAL) - 62]
    if content and sealed == content + _seal(path, content):
        return content
    _tell("damaged", f"damaged in the kernel cache, made again: {path.name}")
    return None


def _write(path: Path, content: bytes) -> None:
    """Write a file of the cache, whole."""
    with _dispensable():
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as temporary:
            temporary.write_bytes(content + _seal(path, content))


@contextmanager
def _dispensable() -> Iterator[None]:
    """Go on without what cannot be written, and say so."""
    try:
        yield
    except OSError as error:
        _tell("not kept", f"compiled kernels are not kept for the next run: {error}")


def _kept(path: Path, make: Callable[[], bytes]) -> bytes:
    content = _read(path)
    if content is None:
        content = make()
        _write(path, content)
    return content


def _tell(what: str, text: str) -> None:
    """Say something about the cache on stderr, once; compiling goes with either of the others."""
    if what not in _told and not (what == "compiling" and _told):
        _told.add(what)
        print(f"stickslip: {text}", file=sys.stderr, flush=True)


class _Place(caching.CompileResultCacheImpl):
    """Where numba would keep a kernel: in our folder, or nowhere."""

    _locator_classes: ClassVar = [caching.UserProvidedCacheLocator]  # type: ignore[misc]


class _Files:
    """A sealed file for each signature of a kernel, in the place of numba's index and data."""

    def __init__(self, base: str, stamp: bytes) -> None:
        self._base, self._stamp = base, stamp

    def load(self, key: Any) -> Any:
        content = _read(self._path(key))
        found, data = (None, None) if content is None else pickle.loads(content)
        return data if found == key else None

    def save(self, key: Any, data: Any) -> None:
        _write(self._path(key), dumps((key, data)))

    def _path(self, key: Any) -> Path:
        name = hashlib.sha256(repr((self._stamp, key)).encode()).hexdigest()[:16]
        return Path(f"{self._base}.{name}.nbc")


class _Cache(caching.FunctionCache):
    """Numba's cache of a kernel, with files that cannot be mistaken."""

    _impl_class = _Place

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        base = os.path.join(self.cache_path, self._impl.filename_base)
        self._cache_file: Any = _Files(base, self._impl.locator.get_source_stamp())

    def save_overload(self, sig: Any, data: Any) -> None:
        with _dispensable():
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]


@contextmanager
def _numba_cache_folder(folder: Path) -> Iterator[None]:
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        config.CACHE_DIR = previous


# --- compiling --------------------------------------------------------------------------------

OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "_nrt": False,
}
_instance_key = threading.local()
_making = threading.RLock()  # held while a module is made: other threads wait for the whole of it
_ours: set[int] = set()


@overload
def kernel(func: F) -> F: ...
@overload
def kernel(*, inline: bool = ..., fused: bool = ...) -> Callable[[F], F]: ...
def kernel(
    func: F | None = None, *, inline: bool = False, fused: bool = False
) -> F | Callable[[F], F]:
    """Compile a function for the CPU: IEEE rounding, no exceptions, no counted references.

    `inline` compiles it into its callers: for small functions on the hot path. `fused` lets the
    compiler fuse products into sums, a tenth faster over lanes. Of ``a b + c d`` it may fuse
    either, and the copies in callers may differ: the last bit depends on what was loaded first
    (docs/notes/0008).
    """
    if func is None:
        return lambda function: _compiled(function, inline, fused)
    return _compiled(func, inline, fused)


def _compiled(func: F, inline: bool, fused: bool) -> F:
    if config.DISABLE_JIT:
        return func
    fastmath = {"contract"} if fused else False
    dispatcher: Any = numba.njit(**OPTIONS, fastmath=fastmath, forceinline=inline)(func)
    _ours.add(id(dispatcher))
    root = cache_root()
    key = getattr(_instance_key, "value", "plain")
    if root is not None and key is not None:
        with _numba_cache_folder(root / key), suppress(RuntimeError):  # no file: typed by hand
            dispatcher._cache = _Cache(func)
    return dispatcher


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


def instantiate(template: str, key: str, *, cached: bool = True, **bindings: Any) -> ModuleType:
    """Execute a template module of kernels again, with `bindings` among its globals.

    Numba sees plain global functions, which it inlines and caches; closures would be compiled anew
    in each process. Equal keys give the same instance; `cached` is False for bindings of this
    process.
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
        return _executed(name, spec.origin, code, key if cached else None, bindings)


def _executed(
    name: str, file: str, code: CodeType, key: str | None, bindings: dict[str, Any]
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
    """Import generated kernel `text`; a module of the same text is written once."""
    return generated_module(stem, hashlib.sha256(text.encode()).hexdigest()[:16], lambda: text)


def generated_module(stem: str, key: str, make_text: Callable[[], str]) -> ModuleType:
    """Import generated kernels, written as a module so that numba can cache them.

    The `key` must identify the text among those that this version of the sources generates.
    """
    name = f"stickslip_generated_{stem}_{key}"
    with _making:
        if name in sys.modules:
            return sys.modules[name]
        root = cache_root()
        path = Path(f"{name}.py") if root is None else root / "generated" / f"{name}.py"
        kept = _kept if root else lambda _, make: make()
        text = kept(path, lambda: make_text().encode())
        code = kept(
            path.with_suffix(f".{sys.implementation.cache_tag}.code"),
            lambda: marshal.dumps(compile(text, path, "exec")),
        )
        return _executed(name, str(path), marshal.loads(code), key if root else None, {})


class _Announcer(event.Listener):
    """Says on stderr that kernels are being compiled, once it takes longer than a second."""

    def __init__(self) -> None:
        self._depth = 0
        self._timer: threading.Timer | None = None

    def on_start(self, event: Any) -> None:
        if id(event.data["dispatcher"]) not in _ours:
            return
        self._depth += 1
        if self._depth == 1:
            self._timer = threading.Timer(ANNOUNCE_AFTER_SECONDS, _announce)
            self._timer.daemon = True
            self._timer.start()

    def on_end(self, event: Any) -> None:
        if id(event.data["dispatcher"]) not in _ours:
            return
        self._depth -= 1
        if self._depth == 0 and self._timer is not None:
            self._timer.cancel()


def _announce() -> None:
    kept = "kept for the next run" if cache_root() else "no private cache folder: not kept"
    _tell("compiling", f"compiling kernels, some seconds ({kept}) ...")


event.register("numba:compile", _Announcer())


# --- launching --------------------------------------------------------------------------------


def available_threads() -> int:
    """Count the processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def launch(task: Callable[[int, int], None], size: int, threads: int, smallest: int) -> None:
    """Run ``task(start, stop)`` over ``range(size)``, cut into tiles for `threads` threads."""
    # Kernels release the interpreter lock. Tiles shrink towards the end, so that all threads end
    # together, but not much below `smallest` items.
    if threads == 1 or size <= smallest:
        task(0, size)
        return
    tiles = iter(list(_tiles(size, threads, smallest)))

    def work() -> None:
        try:
            for start, stop in tiles:
                task(start, stop)
        finally:  # after an error nobody begins another tile
            for _ in tiles:
                pass

    others = [_helpers(threads - 1).submit(work) for _ in range(threads - 1)]
    try:
        work()  # this thread, too: it need not be woken, and has its scratch arrays already
    finally:  # a helper that is busy elsewhere is not waited for: its share is done
        begun = [other for other in others if not other.cancel()]
        wait(begun)
    for other in begun:
        other.result()


@cache
def _helpers(threads: int) -> ThreadPoolExecutor:
    """Threads that wait for the next launch: to start them takes longer than many a tile."""
    return ThreadPoolExecutor(threads, "stickslip")


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
