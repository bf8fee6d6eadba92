"""The program: which subcommands there are, and how each of their endings is told."""

from __future__ import annotations

import os
import sys
import traceback
from contextlib import suppress

from cyclopts import App, CycloptsError

from stickslip import __version__
from stickslip.cli import (
    basins,
    bifurcations,
    certify,
    cycles,
    diagram,
    doctor,
    explore,
    map,
    orbits,
    plot,
    reproduce,
    simulate,
    study,
    sweep,
    verify,
    warmup,
)
from stickslip.cli.failure import BAD_USAGE, DONE, INTERRUPTED, UsageError, exit_code_of
from stickslip.cli.process import interrupted, say_interrupted

COMMANDS = (
    map,
    orbits,
    basins,
    bifurcations,
    diagram,
    simulate,
    cycles,
    sweep,
    plot,
    certify,
    verify,
    reproduce,
    study,
    explore,
    doctor,
    warmup,
)


def application() -> App:
    """Build the parser; every module of `COMMANDS` offers ``command`` and ``EXAMPLES``."""
    app = App(
        name="stickslip",
        help="Dry-friction oscillators as exact, fast event maps.",
        help_epilogue="Each command shows its options and examples: stickslip map --help",
        help_format="markdown",
        version=__version__,
        suppress_keyboard_interrupt=False,
    )
    for module in COMMANDS:
        name = module.__name__.rpartition(".")[2]
        app.command(module.command, name=name, help_epilogue=_examples(module.EXAMPLES))
    app.register_install_completion_command()
    return app


def _examples(commands: str) -> str:
    """Lay out commands as they are typed: a line each, never reflowed."""
    return f"Examples:\n\n```\n{commands}```"


def run(tokens: list[str]) -> int:
    """Parse, run, and turn every ending into an exit code and a message without traceback."""
    try:
        code = application()(
            tokens, exit_on_error=False, print_error=False, result_action="return_value"
        )
        _flush()
        return DONE if code is None else int(code)
    except CycloptsError as error:
        return _tell(tokens, error, BAD_USAGE)
    except BrokenPipeError:
        return _reader_left()
    except (Exception, KeyboardInterrupt) as error:
        return _tell(tokens, error, exit_code_of(error))


def _flush() -> None:
    """Write what is left of the result."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise UsageError(f"cannot write the result to stdout: {error.strerror}") from error


def _tell(tokens: list[str], error: BaseException, code: int) -> int:
    """Say what went wrong: a line on stderr or, with ``--json``, a document on stdout."""
    command = next((token for token in tokens if not token.startswith("-")), "")
    if {"-v", "--verbose"} & set(tokens):
        traceback.print_exception(error)
    if code == INTERRUPTED or interrupted():
        say_interrupted()
        return INTERRUPTED
    if "--json" in tokens:
        from stickslip.cli.columns import error_document

        with suppress(OSError):
            print(error_document(command, error), end="", flush=True)
            return code
    print(f"stickslip {command}: {_message(error)}".replace(" :", ":"), file=sys.stderr)
    return code


def _message(error: BaseException) -> str:
    expected = isinstance(error, CycloptsError) or exit_code_of(error) != 1
    if isinstance(error, OSError) and error.filename is not None:
        return f"cannot use {error.filename}: {error.strerror}"
    text = str(error) or type(error).__name__
    return text if expected else f"{type(error).__name__}: {text} (-v shows where)"


def _reader_left() -> int:
    """End quietly when whoever read the pipe, like ``head``, had enough."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return DONE
