"""Files that a command writes: never over others unasked, and whole or not there.

They are opened before the computation: one that cannot be written is said at once, not in an hour.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from stickslip.cli.failure import RefusalError, UsageError
from stickslip.cli.process import all_or_none
from stickslip.files import undone_unless_finished, whole_file


@contextmanager
def new_files(paths: Sequence[Path], *, force: bool) -> Iterator[list[Path]]:
    """Give files to write; they appear under their names when the block ends well."""
    for path in paths:
        if path.is_dir():
            raise UsageError(f"{path} is a folder; give the name of a file")
        if path.is_file() and not force:
            raise RefusalError(f"{path} exists; --force replaces it")
    with ExitStack() as stack:
        yield [_entered(stack, path) for path in paths]
        with all_or_none():
            stack.close()


def _entered(stack: ExitStack, path: Path) -> Path:
    try:
        return stack.enter_context(whole_file(path))
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        told = getattr(error, "strerror", None) or error
        reason = f"cannot write {path}: {told} ({path.parent})"
        raise UsageError(reason) from error


@contextmanager
def new_folder(folder: Path, names: Sequence[str], *, force: bool) -> Iterator[list[Path]]:
    """Give files of a folder to write, as `new_files`; other files in the folder stay."""
    # The folder is made if it is not there, with those above it, and taken away if the block fails.
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder} is a file; give the name of a folder")
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    with undone_unless_finished(lambda: _remove_empty(missing)):
        folder.mkdir(parents=True, exist_ok=True)
        with new_files([folder / name for name in names], force=force) as paths:
            yield paths


def _remove_empty(folders: Sequence[Path]) -> None:
    for each in folders:
        with suppress(OSError):  # not made, or somebody else uses it by now
            each.rmdir()
