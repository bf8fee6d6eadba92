"""Command line: each subcommand turns options into calls of public names, nothing more."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress

from stickslip import __version__


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command ``stickslip``.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the program's name. If not given this is the program itself: it takes
        ``sys.argv[1:]``, answers signals, and ends the process with the exit code.

    Returns
    -------
    int
        Exit code: 0 done, 1 a computation failed, 2 bad usage or file, 3 refused to
        overwrite, 4 a checked claim did not hold, 130 interrupted.
    """
    if arguments is None:
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, _end)  # until there is more to do: importing takes a while
        # No matrix here is large; to begin threads for them takes a sixth of a short command.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        # Numba loads it where it is installed and uses it only if it runs already: a tenth.
        sys.modules.setdefault("coverage", None)  # type: ignore[arg-type]
        _put_off_collector()
        from stickslip.cli.process import run_as_process

        run_as_process(lambda: main(sys.argv[1:]))
    tokens = list(arguments)
    if tokens == ["--version"]:  # without building the parser: scripts ask this often
        with suppress(OSError):  # the whole program tells of it
            print(__version__, flush=True)
            return 0
    from stickslip.cli.program import run

    return run(tokens)


def _put_off_collector() -> None:
    """Look for garbage when the program is loaded: what is loaded lasts, and is a tenth, too."""
    usual = gc.get_threshold()

    def loaded(phase: str, about: object) -> None:
        gc.callbacks.remove(loaded)
        gc.set_threshold(*usual)

    gc.callbacks.append(loaded)
    gc.set_threshold(200_000, *usual[1:])


def _end(number: int, frame: object) -> None:
    with suppress(OSError):
        os.write(2, b"stickslip: interrupted\n")
    os._exit(130)
