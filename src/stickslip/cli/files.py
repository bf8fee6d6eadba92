"""Files that are whole or not there: written under a temporary name, then renamed."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from stickslip.cli.failure import RefusalError, UsageError


@contextmanager
def new_file(path: Path, *, force: bool) -> Iterator[TextIO]:
    """Open `path` for writing; it appears under its name when the block ends well.

    Entered before the computation, so that a file that cannot be written is said at once
    and not after an hour.

    Parameters
    ----------
    path : pathlib.Path
        Where the file is to appear. Its folder must exist.
    force : bool
        Whether a file of that name may be replaced.
    """
    if path.is_dir():
        raise UsageError(f"--out {path} is a folder; give the name of a file")
    if path.exists() and not force:
        raise RefusalError(f"{path} exists; --force replaces it")
    temporary = _temporary_beside(path)
    try:
        with temporary.open("w", encoding="utf-8", newline="") as stream:
            yield stream
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _temporary_beside(path: Path) -> Path:
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".partial")
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror} ({path.parent})") from error
    # mkstemp makes private files; a result is as readable as any new file of this user.
    umask = os.umask(0)
    os.umask(umask)
    Path(name).chmod(0o666 & ~umask)
    os.close(handle)
    return Path(name)
