"""Where a store lies, a local folder, a zip file or a bucket by its URL, and who may write to it.

One writer holds a file lock of the system, or in a bucket a lease that is renewed. A lease counts
as abandoned when its holder was a process of this machine that no longer runs, or when it was not
renewed for some time.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import socket
import threading
import time
import uuid
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Final

from stickslip.checks import instance, shown
from stickslip.errors import StoreBusy, StoreFull, StoreRefused
from stickslip.extras import require_extra
from stickslip.files import undone_unless_finished, whole_file

EXTRA = ("fsspec", "zarr", "xarray", "filelock", "psutil")
BUCKETS = {"s3", "s3a"}
ZIP = ".zip"
GONE = "gone"  # a work folder that is being removed
WORKING = ".partial"  # what the name of that which is not whole ends with
# Members of an archive: missing, other than their checksum, cut off, or with a broken header.
UNREADABLE: Final = (KeyError, zipfile.BadZipFile, zlib.error, EOFError, RuntimeError)


@dataclass(frozen=True)
class Place:
    """A folder of objects, in a file system or a bucket."""

    url: str  # as the user wrote it
    path: str  # of the folder that is written to, as its file system names it
    fs: Any
    local: bool  # a folder of this machine, whose files appear whole or not at all
    archive: Path | None = None  # the zip file that the folder becomes once it is complete
    options: dict[str, Any] = field(default_factory=dict)

    def of(self, name: str) -> str:
        """Path of an object."""
        return f"{self.path}/{name}"

    def beside(self, what: str) -> str:
        """Path of a hidden object next to the folder."""
        above, _, name = self.path.rpartition("/")
        return f"{above}/.{name}.{what}"

    def read(self, name: str) -> bytes | None:
        """Return the content of an object, None if there is none that can be read."""
        try:
            if self.packed:
                with self._opened() as archive:
                    return archive.read(name)
            content: bytes = self.fs.cat_file(self.of(name))
        except (FileNotFoundError, NotADirectoryError, IsADirectoryError, *UNREADABLE):
            return None
        return content

    def write(self, name: str, content: bytes) -> None:
        """Write an object, whole or not at all."""
        path = self.of(name)
        with room_for(path):
            if not self.local:
                self.fs.pipe_file(path, content)
                return
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            with whole_file(Path(path)) as temporary:
                temporary.write_bytes(content)

    def names(self, folder: str) -> list[str]:
        """List the objects below a folder of it."""
        if self.packed:
            with self._opened() as archive:
                return [name for name in archive.namelist() if name.startswith(f"{folder}/")]
        self.fs.invalidate_cache()
        paths = self.fs.find(self.of(folder))
        return [f"{folder}/{path.rpartition(f'/{folder}/')[2]}" for path in paths]

    def _opened(self) -> zipfile.ZipFile:
        assert self.archive is not None
        try:
            return zipfile.ZipFile(self.archive)
        except zipfile.BadZipFile as error:
            raise StoreRefused(
                f"{self.archive} is no whole zip file: {error}. Restore it from a copy, or give "
                "the name of a new store."
            ) from error

    def remove(self, path: str) -> None:
        """Remove an object, if there is one."""
        with suppress(FileNotFoundError):
            self.fs.rm_file(path)
        self.fs.invalidate_cache()

    def empty(self) -> bool:
        """Whether the folder holds no objects, half-written ones aside."""
        self.fs.invalidate_cache()
        paths = (f"{at}/{name}" for at, _, names in self.fs.walk(self.path) for name in names)
        return all(WORKING in path[len(self.path) :] for path in paths)

    def zarr_store(self, *, read_only: bool = False) -> Any:
        """Open the place as a zarr store; a finished archive only for reading."""
        from zarr import storage

        if self.packed:
            return storage.ZipStore(str(self.archive), mode="r", read_only=True)
        if self.local:
            return storage.LocalStore(self.path, read_only=read_only)
        return storage.FsspecStore.from_url(
            self.url, storage_options=self.options, read_only=read_only
        )

    @property
    def packed(self) -> bool:
        """Whether the place is a finished archive, with no work folder beside it."""
        return self.archive is not None and self.archive.exists() and not Path(self.path).exists()

    def clear_remains(self) -> None:
        """Remove the half-written files of a writer that was killed."""
        if self.local:
            shutil.rmtree(self.beside(GONE), ignore_errors=True)
            for partial in list(Path(self.path).rglob(f"*{WORKING}")):
                if partial.is_dir():
                    shutil.rmtree(partial, ignore_errors=True)
                else:
                    partial.unlink(missing_ok=True)

    def pack(self) -> None:
        """Make the archive of the folder, then remove the folder; nothing for other places."""
        if self.archive is None or self.packed:
            return
        folder = Path(self.path)
        with room_for(str(self.archive)), whole_file(self.archive) as temporary:
            with zipfile.ZipFile(temporary, "w", zipfile.ZIP_STORED) as archive:
                for path in sorted(folder.rglob("*")):
                    if path.is_file():
                        # A fixed date: equal stores are equal files.
                        info = zipfile.ZipInfo(path.relative_to(folder).as_posix())
                        archive.writestr(info, path.read_bytes())
        # Gone at once: a folder that lost some of its files would be taken for a damaged sweep.
        gone = folder.rename(self.beside(GONE))
        shutil.rmtree(gone)

    def unpack(self) -> None:
        """Make the work folder of a finished archive again, damaged files aside."""
        if self.packed:
            with whole_file(Path(self.path)) as temporary, self._opened() as archive:
                temporary.mkdir()
                for member in archive.infolist():
                    with suppress(*UNREADABLE):
                        archive.extract(member, temporary)


def place_of(store: str | PathLike[str], options: dict[str, Any] | None = None) -> Place:
    """Find the place that names a local folder, a ``.zip`` file or a URL known to fsspec."""
    require_extra("sweep", "sweeps", *EXTRA)
    from fsspec.core import url_to_fs
    from fsspec.implementations.local import LocalFileSystem
    from fsspec.utils import get_protocol

    if not isinstance(store, str | PathLike):
        raise ValueError(f"store = {shown(store)} is neither a path nor an address.")
    url = str(store)
    if not url or "\0" in url:
        raise ValueError(f"store = {shown(url)} is neither a path nor an address.")
    options = {} if options is None else options
    told = "what the file system is told, by name"
    for name in instance("storage_options", options, Mapping, told):
        instance("storage_options", name, str, f"a name, as in {told}")
    if get_protocol(url) in BUCKETS:
        require_extra("cluster", "buckets", "s3fs")
    try:
        fs, path = url_to_fs(url, **options)
    except (RecursionError, TypeError) as error:
        raise ValueError(
            f"storage_options = {shown(options)}: the file system does not take them."
        ) from error
    except (ImportError, ValueError) as error:
        raise ValueError(f"store = {shown(url)} cannot be reached: {error}") from error
    local = isinstance(fs, LocalFileSystem)
    if "/" not in path.strip("/") and not local:
        raise ValueError(f"store = {shown(url)}: a name inside the bucket is needed.")
    if not local:
        try:
            fs.exists(f"{path}/zarr.json")
        except Exception as error:  # of a library for each kind of bucket
            raise ValueError(
                f"store = {shown(url)} cannot be reached ({type(error).__name__}: {error}). Give "
                "its credentials and endpoint in storage_options, or as its library finds them."
            ) from error
        return Place(url, path.rstrip("/"), fs, local, options=options)
    folder, archive = Path(path), None
    if folder.suffix.lower() == ZIP:
        folder, archive = folder.with_name(folder.name + WORKING), folder
    if folder.exists() and not folder.is_dir():
        raise StoreRefused(
            f"store = {shown(url)} is a file: a sweep is a folder, or an archive in .zip."
        )
    return Place(url, str(folder), fs, local, archive)


@contextmanager
def room_for(path: str) -> Iterator[None]:
    """Raise StoreFull, with the file's name, where no space was left."""
    try:
        yield
    except StoreFull:
        raise
    except Exception as error:
        if not _is_full(error):
            raise
        raise StoreFull(
            f"no space is left for {path}. What was finished is kept: make room, then run the same "
            "sweep again (on the command line with --resume) to go on."
        ) from error


def _is_full(error: BaseException) -> bool:
    """Whether an error says that no space is left."""
    seen: BaseException | None = error
    while seen is not None:
        if isinstance(seen, OSError) and seen.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            return True
        seen = seen.__cause__ or seen.__context__
    return False


LOCK: Final = "lock"  # what the object beside the store is called after it
HOLDER: Final = "writer"  # who holds the file lock, for the message alone
RENEWED_EVERY: Final = 20.0  # seconds
ABANDONED_AFTER: Final = 120.0


@contextmanager
def writing(place: Place) -> Iterator[Callable[[], None]]:
    """Hold the right to write to a place; yields what raises StoreBusy if the right was lost."""
    with _file_lock(place) if place.local else _lease(place) as check:
        yield check


@contextmanager
def _file_lock(place: Place) -> Iterator[Callable[[], None]]:
    from filelock import FileLock, Timeout

    holder = Path(place.beside(HOLDER))
    try:
        holder.parent.mkdir(parents=True, exist_ok=True)
        Path(place.beside(LOCK)).touch()  # else it counts as held where it cannot be made
    except OSError as error:
        told = f"cannot write {place.url}: {error.strerror} ({error.filename})"
        raise type(error)(told) from error
    lock = FileLock(place.beside(LOCK))
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise _busy(place, _told(holder)) from None
    try:
        with undone_unless_finished(lambda: holder.unlink(missing_ok=True)):
            with room_for(str(holder)):
                holder.write_text(json.dumps(_me()))
            yield lambda: None
            holder.unlink()
    finally:
        lock.release()


def _told(holder: Path) -> dict[str, Any]:
    try:
        told: dict[str, Any] = json.loads(holder.read_text())
    except (OSError, ValueError):  # it is only just beginning
        return {}
    return told


@contextmanager
def _lease(place: Place) -> Iterator[Callable[[], None]]:
    lease = _Lease(place)
    lease.take()
    stop = threading.Event()
    renewal = threading.Thread(target=lease.renew_until, args=(stop,), daemon=True)
    renewal.start()
    try:
        yield lease.check
    finally:
        stop.set()
        renewal.join()
        lease.give_back()


class _Lease:
    """An object that only one process can create, and renews while it works."""

    def __init__(self, place: Place) -> None:
        self.place = place
        self.path = place.beside(LOCK)
        self.mine = {**_me(), "token": uuid.uuid4().hex}
        self.lost = False

    def take(self) -> None:
        for _ in range(2):
            try:
                self._put(mode="create")
                return
            except FileExistsError:
                held = self._read()
                if held is not None and not _abandoned(held):
                    raise _busy(self.place, held) from None
                self.place.remove(self.path)
        raise _busy(self.place, self._read() or {})

    def renew_until(self, stop: threading.Event) -> None:
        while not stop.wait(RENEWED_EVERY):
            if (self._read() or {}).get("token") != self.mine["token"]:
                self.lost = True
                return
            self._put(mode="overwrite")

    def check(self) -> None:
        if self.lost:
            raise _busy(self.place, self._read() or {})

    def give_back(self) -> None:
        if (self._read() or {}).get("token") == self.mine["token"]:
            self.place.remove(self.path)

    def _put(self, mode: str) -> None:
        content = json.dumps({**self.mine, "renewed": time.time()}).encode()
        self.place.fs.pipe_file(self.path, content, mode=mode)

    def _read(self) -> dict[str, Any] | None:
        self.place.fs.invalidate_cache()
        try:
            held: dict[str, Any] = json.loads(self.place.fs.cat_file(self.path))
        except (FileNotFoundError, ValueError):
            return None
        return held


def _me() -> dict[str, Any]:
    import psutil

    return {
        "host": socket.gethostname(),
        "process": os.getpid(),
        "started": psutil.Process().create_time(),
        "since": time.strftime("%Y-%m-%d %H:%M:%S"),
    }


def _abandoned(held: dict[str, Any]) -> bool:
    import psutil

    if held.get("host") == socket.gethostname():
        try:
            return bool(psutil.Process(held["process"]).create_time() != held["started"])
        except psutil.NoSuchProcess:
            return True
    return bool(time.time() - held.get("renewed", 0.0) > ABANDONED_AFTER)


def _busy(place: Place, held: dict[str, Any]) -> StoreBusy:
    who = "another process"
    if "process" in held:
        who = f"process {held['process']} on {held['host']}, since {held['since']}"
    return StoreBusy(
        f"{place.url} is being written by {who}. Nothing was changed; wait for it, or end it."
    )
