"""One writer for a store: a file lock of the system, or in a bucket a lease that is renewed.

A lease counts as abandoned when its holder was a process of this machine that no longer runs, or
when it was not renewed for some time.
"""

from __future__ import annotations

import json
import os
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from stickslip.errors import StoreBusy
from stickslip.files import undone_unless_finished
from stickslip.sweeps.place import Place, room_for

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
    holder.parent.mkdir(parents=True, exist_ok=True)
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
