"""Where a store lies: a local folder, a zip file, or a bucket, by its URL."""

from __future__ import annotations

import errno
import shutil
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Final

from stickslip.checks import instance, shown
from stickslip.errors import StoreFull, StoreRefused
from stickslip.extras import require_extra
from stickslip.files import whole_file

EXTRA = ("fsspec", "zarr", "xarray", "filelock", "psutil")
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

    def files(self, folder: str) -> Iterable[str]:
        """List the paths of the objects below a folder of it."""
        if self.packed:
            with self._opened() as archive:
                return [name for name in archive.namelist() if name.startswith(f"{folder}/")]
        self.fs.invalidate_cache()
        found: list[str] = self.fs.find(self.of(folder))
        return found

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

    if not isinstance(store, str | PathLike):
        raise ValueError(f"store = {shown(store)} is neither a path nor an address.")
    url = str(store)
    if not url:
        raise ValueError("store = '' is neither a path nor an address.")
    options = {} if options is None else options
    told = "what the file system is told, by name"
    for name in instance("storage_options", options, Mapping, told):
        instance("storage_options", name, str, f"a name, as in {told}")
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
    if folder.suffix == ZIP:
        folder, archive = folder.with_name(folder.name + WORKING), folder
    if folder.exists() and not folder.is_dir():
        raise StoreRefused(
            f"store = {shown(url)}: there is a file of that name. Take another name."
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
