"""The folder of compiled kernels: one for each version of the sources, each file sealed.

Numba's own cache serves stale code when a callee in another file changes (numba issues 3588, 8851,
8926): here a hash over the sources of all kernels and of their imports names the folder.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import pickle
import re
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from itertools import dropwhile
from pathlib import Path
from types import CodeType
from typing import Any

import numba
from llvmlite.binding import get_host_cpu_features
from numba.core import caching, compiler
from numba.core.serialize import dumps

from stickslip.files import undone_unless_finished
from stickslip.numerics.waiting import WATCH

fcntl: Any
try:
    fcntl = importlib.import_module("fcntl")
except ImportError:  # on Windows
    fcntl = None

config: Any = numba.config

PACKAGE = Path(__file__).resolve().parents[1]
PREPARED = PACKAGE / "prepared"  # in wheels, for the machines of `LEVELS`
# Best first, and what tells that a processor has it. Code for a level is as fast on such
# processors as code for themselves.
LEVELS = {
    "x86-64-v4": {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": {"avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"},
}
IMPORT = re.compile(r"^from (stickslip[\w.]*) import ([\w, ]+|\([^)]*\))", re.M)
USES = "\nfrom stickslip.numerics.targets import "
GENERATED = "stickslip_generated_"  # modules named by their text
OLD_CACHE_SECONDS = 30 * 24 * 3600.0


# --- the cache folder -------------------------------------------------------------------------


@cache
def source_hash() -> str:
    """Hash of every source file that kernels are made of, and of numba's version."""
    folder = _private_folder()
    if folder is None:
        return _hash_of_sources()
    # Reading all files takes a twentieth of a short command: remembered while no file changes.
    files = sorted(_files(PACKAGE))
    about = [(p, s.st_ino, s.st_size, s.st_mtime_ns, s.st_ctime_ns) for p, s in files]
    state = repr((numba.__version__, about))
    memory = folder / f"sources-{hashlib.sha256(bytes(PACKAGE)).hexdigest()[:16]}"
    with suppress(OSError):
        known = memory.read_bytes()
        if known == known[:16] + _seal(state, known[:16]):
            return known[:16].decode()
    found = _hash_of_sources()
    if max(s.st_ctime for _, s in files) < time.time() - 2.0:  # no clock tells more from less
        _put(memory, found.encode() + _seal(state, found.encode()))
    return found


def _files(folder: str | Path) -> Iterator[tuple[str, os.stat_result]]:
    """Python's files inside a folder, and what the system knows of each."""
    for entry in os.scandir(folder):
        if entry.is_dir():
            yield from _files(entry.path)
        elif entry.name.endswith(".py"):
            yield entry.path, entry.stat()


def _hash_of_sources() -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(kernel_sources(PACKAGE)):
        digest.update(path.relative_to(PACKAGE).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def kernel_sources(package: Path) -> set[Path]:
    """Files of kernels and of their generators, what they import (not indented), and so on."""
    files = {path: f"\n{path.read_bytes().decode()}" for path in package.rglob("*.py")}
    used = {path: text.partition(USES)[2].partition("\n")[0] for path, text in files.items()}
    makers = "\n@kernel", "=written("  # the latter of functions that write code
    todo = [path for path, text in files.items() if any(one in text for one in makers)]
    found: set[Path] = set()
    while todo:
        path = todo.pop()
        if path not in found:
            found.add(path)
            for match in IMPORT.finditer(files[path]):
                todo.extend(_modules(package, match) & files.keys())
    binds = ("instantiate", "write_module")
    return found.union(path for path, names in used.items() if any(one in names for one in binds))


def _modules(package: Path, match: re.Match[str]) -> set[Path]:
    """Files that an import statement may read."""
    base = package.joinpath(*match[1].split(".")[1:])
    inside = (base / f"{name}.py" for name in re.findall(r"\w+", match[2]))
    return {base.with_suffix(".py"), *inside}


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
                level.mkdir(0o700, exist_ok=True)  # another process may be as far
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


def _private_folder() -> Path | None:
    """Return the first place that this user alone can write.

    Of ``$STICKSLIP_CACHE_DIR``, ``$XDG_CACHE_HOME``, ``~/.cache`` and the temporary folder.
    """
    for base in _candidate_roots():
        folder = Path(os.path.realpath(base)) / "numba"  # a link could be turned elsewhere
        if _private_and_writable(folder):
            return folder
    return None


@cache
def cache_root() -> Path | None:
    """Folder of compiled and generated kernels of this version of the sources, or None.

    Folders of versions unused for a month go.
    """
    folder = _private_folder()
    if folder is None:
        return None
    root = folder / source_hash()
    root.mkdir(exist_ok=True, mode=0o700)
    os.utime(root)
    _prune(folder, keep=root)
    return root


def _prune(base: Path, keep: Path) -> None:
    oldest = time.time() - OLD_CACHE_SECONDS
    for folder in base.iterdir():
        try:
            if folder != keep and folder.stat().st_mtime < oldest:
                shutil.rmtree(folder, ignore_errors=True)
        except OSError:
            continue


@cache
def prepared_root() -> Path | None:
    """Folder of kernels that came with the package for this version of the sources, or None."""
    root = PREPARED / source_hash()
    return root if root.is_dir() else None


@cache
def levels() -> tuple[str, ...]:
    """Levels of the processor that kernels are compiled for, best first."""
    if config.CPU_NAME or config.CPU_FEATURES is not None:  # another one, or one held to be less
        return tuple(dropwhile(lambda level: level != config.CPU_NAME, LEVELS))
    present = {name for name, has in get_host_cpu_features().items() if has}
    return tuple(level for level, needs in LEVELS.items() if needs <= present)


def prepared_levels() -> tuple[str, ...]:
    """Levels of this processor if there are prepared kernels, best first."""
    return levels() if prepared_root() else ()


# --- files of the cache -----------------------------------------------------------------------
# Each ends in a seal, the hash of its name and of its content: nothing else is executed or
# unpickled. A pickle, a code object and the text of a module may all have this tail.

SEAL = b"\n# sha256 %s\n"
_told: set[str] = set()


def _seal(name: str, content: bytes) -> bytes:
    return SEAL % hashlib.sha256(name.encode() + b"\0" + content).hexdigest().encode()


def _roots() -> list[Path]:
    return [root for root in (cache_root(), prepared_root()) if root is not None]


def _read(name: str) -> bytes | None:
    """Content of a file of the cache or of the package; None if no sound one is there."""
    for root in _roots():
        try:
            sealed = (root / name).read_bytes()
        except FileNotFoundError:
            continue
        except OSError:
            sealed = b""
        content = sealed[: -len(SEAL) - 62]
        if content and sealed == content + _seal(name, content):
            return content
        tell("damaged", f"damaged in the kernel cache, made again: {Path(name).name}")
    return None


def _write(name: str, content: bytes) -> None:
    """Write a file of the cache, whole, where there is one."""
    root = cache_root()
    if root is not None:
        _put(root / name, content + _seal(name, content))


def _put(path: Path, sealed: bytes) -> None:
    """Write a file whole: beside its place first, in no folder of its own, which takes 3 ms."""
    with _dispensable():
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(f".{os.urandom(4).hex()}.partial")
        with undone_unless_finished(lambda: beside.unlink(missing_ok=True)):
            beside.write_bytes(sealed)
            beside.replace(path)


@contextmanager
def _dispensable() -> Iterator[None]:
    """Go on without what cannot be written, and say so."""
    try:
        yield
    except OSError as error:
        tell("not kept", f"compiled kernels are not kept for the next run: {error}")


def kept(name: str, make: Callable[[], bytes]) -> bytes:
    """Content of a file of the cache, made if need be."""
    content = _read(name)
    if content is None:
        content = make()
        _write(name, content)
    return content


_codes: dict[str, bytes] = {}  # read or written by this process


def keep_code(name: str, code: bytes) -> None:
    """Keep code of a kernel, whose hash is its name."""
    if name not in _codes:
        _codes[name] = kept(f"parts/{name}.bc", lambda: code)


def kept_code(name: str) -> bytes | None:
    """Code that `keep_code` kept; None if it is lost."""
    if name not in _codes:
        code = _read(f"parts/{name}.bc")
        if code is None:
            return None
        _codes[name] = code
    return _codes[name]


def tell(what: str, text: str) -> None:
    """Say something about the cache on stderr, once; compiling goes with either of the others."""
    if not WATCH.quiet and what not in _told and not (what == "compiling" and _told):
        _told.add(what)
        print(f"stickslip: {text}", file=sys.stderr, flush=True)


def _known_by_name(function: Callable[..., Any]) -> bool:
    """Whether the hash of the sources, or the name of a generated module, tells what it does."""
    code: CodeType = function.__code__
    inside = Path(code.co_filename).is_relative_to(PACKAGE)
    return inside or function.__module__.startswith(GENERATED)


class KernelCache(caching.NullCache):
    """What numba compiled of a function: of each signature, for each machine, a sealed file."""

    MARK = ""

    def __init__(self, function: Callable[..., Any], folder: str | None) -> None:
        code = function.__code__
        self._enabled = folder is not None and _known_by_name(function)
        self._function = (
            sys.implementation.cache_tag,
            function.__module__,
            code.co_firstlineno,
            hashlib.sha256(code.co_code).hexdigest(),
        )
        self._name = f"{folder}/{function.__name__}{self.MARK}"

    def load_overload(self, sig: Any, target: Any) -> Any:
        """Return what was compiled on this machine, or prepared for its level, or None."""
        # Numba's own caches have the target refreshed here, which loads all that a compiler needs.
        if not self._enabled:
            return None
        for name in self._files(sig, target):
            content = _read(name)
            if content is not None:
                return self.rebuild(target, pickle.loads(content))
        return None

    def save_overload(self, sig: Any, made: Any) -> None:
        """Keep what was compiled, unless it holds addresses of this process."""
        if self._enabled and not made.library.has_dynamic_globals:
            _write(self._file(sig, made.codegen.magic_tuple()), self.reduce(made))

    def _has(self, sig: Any, target: Any) -> bool:
        names = self._files(sig, target)
        return any((root / name).exists() for root in _roots() for name in names)

    def _files(self, sig: Any, target: Any) -> list[str]:
        """Names of what may be kept of a signature: for this machine, and for its levels."""
        machine = target.codegen().magic_tuple()
        levels = ((machine[0], level, "") for level in prepared_levels())
        return [self._file(sig, known) for known in (machine, *levels)]

    def _file(self, sig: Any, machine: tuple[str, str, str]) -> str:
        name = hashlib.sha256(repr((self._function, sig, machine)).encode()).hexdigest()[:16]
        return f"{self._name}-{name}.nbc"

    @contextmanager
    def turn(self, sig: Any, target: Any) -> Iterator[None]:
        """Wait while other processes compile kernels of this folder, unless there is no need to."""
        root = cache_root()
        with ExitStack() as held:
            if fcntl is None or root is None or not self._enabled or self._has(sig, target):
                yield
                return
            with _dispensable():
                folder = (root / self._name).parent
                folder.mkdir(parents=True, exist_ok=True)
                opened = os.open(folder, os.O_RDONLY)
                held.callback(os.close, opened)
                fcntl.flock(opened, fcntl.LOCK_EX)
                held.callback(fcntl.flock, opened, fcntl.LOCK_UN)  # of what a fork holds, too
            yield

    def reduce(self, made: Any) -> bytes:
        """Take apart what was compiled, for a file."""
        return dumps(made._replace(type_annotation="")._reduce())  # a text as long as the code

    def rebuild(self, target: Any, payload: Any) -> Any:
        """Make a compiled function; None if something that it needs is lost."""
        return compiler.CompileResult._rebuild(target, *payload)
