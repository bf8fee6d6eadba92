"""The program as a process: its exit codes, its signals, its standard streams, its end.

Ctrl-C or a termination ends it with code 130 within a second. KeyboardInterrupt alone is lost in
``__del__`` and in hooks, and waits for kernels: signals also wake a thread that ends the process.
"""

from __future__ import annotations

import atexit
import io
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Final, NoReturn

from stickslip.errors import MissingExtraError
from stickslip.files import undo_all

DONE: Final = 0
COMPUTATION_FAILED: Final = 1
BAD_USAGE: Final = 2
REFUSED: Final = 3
CLAIM_FAILED: Final = 4
INTERRUPTED: Final = 130

LONGEST: Final = 1000
"""Characters of a message: it repeats what was given, which may be a whole file."""

USERS: Final = (ValueError, OSError, MissingExtraError)  # what the user can mend


class CommandError(Exception):
    """A command cannot do what was asked; `exit_code` says what kind of reason there is."""

    exit_code = BAD_USAGE


class UsageError(CommandError):
    """The options do not fit together, or a file cannot be used."""


class RefusalError(CommandError):
    """Something is in the way that only the user may remove."""

    exit_code = REFUSED


class ComputationError(CommandError):
    """The options were right and there is still no answer."""

    exit_code = COMPUTATION_FAILED


def exit_code_of(error: BaseException) -> int:
    """Exit code for an exception that reached the program."""
    # The library raises ValueError for illegal input before anything runs, and the system OSError
    # for files, and an extra may not be installed: the user's to mend. Anything else is a failure
    # of ours.
    if isinstance(error, CommandError):
        return error.exit_code
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    return BAD_USAGE if isinstance(error, USERS) else COMPUTATION_FAILED


def shortened(text: str) -> str:
    """Leave out the middle of a long message: what is wrong stands first, what to do last."""
    # What cannot be printed is escaped: an argument may hold what clears a terminal, or is no text.
    text = "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)
    left_out = len(text) - LONGEST
    if left_out <= 0:
        return text
    half = LONGEST // 2
    return f"{text[:half]} ... ({left_out} characters left out) ... {text[-half:]}"


SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
AGAIN: Final = 0.05  # seconds after which an interrupt that nobody handles is repeated
PATIENCE: Final = 0.6  # seconds that work may take to end by itself
SHOW_CURSOR: Final = "\r\x1b[K\x1b[?25h"


class _State:
    """State of the process as a whole."""

    interrupted = False
    over = False  # nothing is left to unwind
    held = 0  # blocks that no interrupt may divide
    told = False
    advice = ""
    code: int | None = None


def run_as_process(run: Callable[[], int]) -> NoReturn:
    """Call `run` and end the process with the code that it returns; 130 after an interrupt."""
    try:
        _begin()
        code = run()
        _State.over = True
    except BaseException:  # an interrupt may come out of a library as any error
        if not _State.interrupted:
            raise
        _end()
    if _State.interrupted:
        _end()
    _State.code = code
    sys.exit(code)


def _begin() -> None:
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as for a job in the background
            signal.signal(number, _interrupt)
    atexit.register(_last)  # the first to be registered is the last to be called
    _open_closed_streams()
    for name in ("unraisablehook", "excepthook"):
        place: Any = sys if name == "unraisablehook" else threading
        setattr(place, name, _unless_interrupted(getattr(place, name)))
    readable, writable = os.pipe()
    if hasattr(os, "set_blocking"):
        os.set_blocking(writable, False)
    signal.set_wakeup_fd(writable, warn_on_full_buffer=False)
    with suppress(RuntimeError):  # no thread to be had: the exception must do
        threading.Thread(target=_watch, args=(readable,), daemon=True).start()


# --- interrupts -------------------------------------------------------------------------------


def interrupted() -> bool:
    """Whether a signal asked the process to end."""
    return _State.interrupted


def advise(text: str) -> None:
    """Add what to do next to the message of an interrupt."""
    _State.advice = f"; {text}"


def say_interrupted() -> None:
    """Say once on stderr that the work was interrupted."""
    if not _State.told:
        _State.told = _State.interrupted
        restore = SHOW_CURSOR if sys.stderr.isatty() else ""  # a bar of progress hides it
        print(f"{restore}stickslip: interrupted{_State.advice}", file=sys.stderr, flush=True)


@contextmanager
def all_or_none() -> Iterator[None]:
    """Let an interrupt wait for the end of the block: a few quick steps that belong together."""
    _State.held += 1
    try:
        yield
    finally:
        _State.held -= 1
    if _State.interrupted and not _State.held:
        raise KeyboardInterrupt


def _interrupt(number: int, frame: object) -> None:
    _State.interrupted = True
    if _State.over:
        _end()
    if not (_State.held or _being_handled(sys.exception())):
        raise KeyboardInterrupt


def _being_handled(error: BaseException | None) -> bool:
    """Whether the interrupted code is cleaning up after an interrupt already."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


def _watch(wakeups: int) -> None:
    """Wait for a signal, then for the end; neither needs the main thread to run Python."""
    while (number := os.read(wakeups, 1)[0]) not in SIGNALS:
        pass
    _State.interrupted = True
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        time.sleep(AGAIN)
        if signal.getsignal(number) is _interrupt:  # a server handles its signals itself
            _repeat(number)
    _end()


def _repeat(number: int) -> None:
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        signal.raise_signal(number)


def _unless_interrupted(hook: Callable[[Any], object]) -> Callable[[Any], None]:
    """Silence the reports of errors that nobody handles: an interrupt causes them anywhere."""

    def wrapped(arguments: Any) -> None:
        if not _State.interrupted:
            hook(arguments)

    return wrapped


# --- the end ----------------------------------------------------------------------------------


def _end() -> NoReturn:
    """End at once, from any thread."""
    undo_all()
    with suppress(Exception):
        say_interrupted()
    os._exit(INTERRUPTED)


def _last() -> None:
    """Leave before Python takes the process apart: that takes a while, and signals then kill."""
    if _State.code is not None:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(_State.code)


# --- streams ----------------------------------------------------------------------------------


def _open_closed_streams() -> None:
    """Open the standard streams that the shell closed, before other files take their numbers."""
    # Results that cannot be written are an error, which the system tells of a file open for
    # reading; messages that cannot be written are none.
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)  # takes the lowest number that is free
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)
    if isinstance(sys.stdout, io.TextIOWrapper):  # names of files may have letters that it has not
        sys.stdout.reconfigure(errors="backslashreplace")
    inner = open(2, "wb", closefd=False) if sys.stderr is None else sys.stderr.buffer
    sys.stderr = _Forgiving(inner, "utf-8", "backslashreplace", line_buffering=True)


class _Forgiving(io.TextIOWrapper):
    """A stream for messages: where nobody can read them the work goes on."""

    def write(self, text: str) -> int:
        with suppress(OSError):
            super().write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError):
            super().flush()
