"""The folder of compiled kernels: one for each version of the sources, each file sealed.

Numba's own cache serves stale code when a callee in another file changes (numba issues 3588, 8851,
8926): here a hash over the sources of all kernels and of their imports names the folder.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import re
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numba
from numba.core import caching
from numba.core.serialize import dumps

from stickslip.files import whole_file

config: Any = numba.config

PACKAGE = Path(__file__).resolve().parents[1]
IMPORT = re.compile(r"^from (stickslip[\w.]*) import ([\w, ]+|\([^)]*\))", re.M)
USES = "from stickslip.numerics.targets import "
BINDS = re.compile(rf"^{USES}.*\b(instantiate|write_module)\b", re.MULTILINE)
GENERATES = re.compile(rf"^{USES}.*\bgenerated_module\b", re.MULTILINE)
OLD_CACHE_SECONDS = 30 * 24 * 3600.0


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
    tell("damaged", f"damaged in the kernel cache, made again: {path.name}")
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
        tell("not kept", f"compiled kernels are not kept for the next run: {error}")


def kept(path: Path, make: Callable[[], bytes]) -> bytes:
    """Content of a file of the cache, made if need be."""
    content = _read(path)
    if content is None:
        content = make()
        _write(path, content)
    return content


_codes: dict[str, bytes] = {}  # read or written by this process


def keep_code(name: str, code: bytes) -> None:
    """Keep code of a kernel, whose hash is its name."""
    root = cache_root()
    if root is not None and name not in _codes:
        _codes[name] = kept(root / "parts" / f"{name}.bc", lambda: code)


def kept_code(name: str) -> bytes | None:
    """Code that `keep_code` kept; None if it is lost."""
    root = cache_root()
    if root is not None and name not in _codes:
        code = _read(root / "parts" / f"{name}.bc")
        if code is None:
            return None
        _codes[name] = code
    return _codes.get(name)


def tell(what: str, text: str) -> None:
    """Say something about the cache on stderr, once; compiling goes with either of the others."""
    if what not in _told and not (what == "compiling" and _told):
        _told.add(what)
        print(f"stickslip: {text}", file=sys.stderr, flush=True)


LOCATOR: Any = vars(caching).get("UserProvidedCacheLocator")  # private in numba 0.61
LOCATOR = LOCATOR or vars(caching)["_UserProvidedCacheLocator"]


class Place(caching.CompileResultCacheImpl):
    """Where numba would keep a kernel: in our folder, or nowhere."""

    MARK = ""
    _locator_classes: ClassVar = [LOCATOR]  # type: ignore[misc]


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


class _KernelCache(caching.FunctionCache):
    """Numba's cache of a kernel, with files that cannot be mistaken."""

    def __init__(self, function: Callable[..., Any], place: type[Place]) -> None:
        self._impl_class = place
        super().__init__(function)  # type: ignore[no-untyped-call]
        base = os.path.join(self.cache_path, f"{self._impl.filename_base}{place.MARK}")
        self._cache_file: Any = _Files(base, self._impl.locator.get_source_stamp())

    def save_overload(self, sig: Any, data: Any) -> None:
        with _dispensable():
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]


def enable(dispatcher: Any, key: str, place: type[Place] = Place) -> None:
    """Keep what `dispatcher` compiles in the folder of `key`."""
    root = cache_root()
    if root is not None:
        previous = config.CACHE_DIR
        config.CACHE_DIR = str(root / key)
        try:
            with suppress(RuntimeError):  # no file: typed by hand
                dispatcher._cache = _KernelCache(dispatcher.py_func, place)
        finally:
            config.CACHE_DIR = previous
