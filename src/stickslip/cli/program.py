"""The program: which subcommands there are, and how each of their endings is told."""

from __future__ import annotations

import errno
import logging
import os
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, Final

from cyclopts import App, CycloptsError, UnknownOptionError

from stickslip import __version__
from stickslip.cli import claims, installation, measurements, models, parameters, sweeps
from stickslip.cli.options import MODEL
from stickslip.cli.output import Spoken, told_as
from stickslip.cli.process import (
    BAD_USAGE,
    DONE,
    INTERRUPTED,
    CommandError,
    UsageError,
    exit_code_of,
    interrupted,
    say_interrupted,
    shortened,
)
from stickslip.files import FULL
from stickslip.numerics.waiting import WATCH

LONGEST_NAME = 40
"""Characters of what stands for a command's name."""

COMMANDS: Final[dict[str, tuple[Callable[..., Any], str]]] = {
    "map": (models.map_, models.MAP_EXAMPLES),
    "orbits": (models.orbits, models.ORBITS_EXAMPLES),
    "basins": (models.basins, models.BASINS_EXAMPLES),
    "safety": (models.safety, models.SAFETY_EXAMPLES),
    "bifurcations": (parameters.bifurcations, parameters.BIFURCATIONS_EXAMPLES),
    "diagram": (parameters.diagram, parameters.DIAGRAM_EXAMPLES),
    "simulate": (models.simulate, models.SIMULATE_EXAMPLES),
    "cycles": (models.cycles, models.CYCLES_EXAMPLES),
    "fit": (measurements.fit, measurements.FIT_EXAMPLES),
    "sweep": (sweeps.sweep, sweeps.SWEEP_EXAMPLES),
    "plot": (sweeps.plot, sweeps.PLOT_EXAMPLES),
    "certify": (claims.certify, claims.CERTIFY_EXAMPLES),
    "verify": (claims.verify, claims.VERIFY_EXAMPLES),
    "reproduce": (claims.reproduce, claims.REPRODUCE_EXAMPLES),
    "study": (claims.study, claims.STUDY_EXAMPLES),
    "explore": (installation.explore, installation.EXPLORE_EXAMPLES),
    "doctor": (installation.doctor, installation.DOCTOR_EXAMPLES),
    "warmup": (installation.warmup, installation.WARMUP_EXAMPLES),
}
"""By name: the function, and its examples."""


def application(first: str = "") -> App:
    """Build the parser of the command that `first` names; of all `COMMANDS` if it names none."""
    app = App(
        name="stickslip",
        help="Dry-friction oscillators as exact, fast event maps.",
        help_epilogue="Each command shows its options and examples: stickslip map --help",
        help_format="markdown",
        version=__version__,
        suppress_keyboard_interrupt=False,
    )
    for name in {first} & COMMANDS.keys() or COMMANDS:
        command, examples = COMMANDS[name]
        app.command(command, name=name, help_epilogue=_examples(examples))
    if first not in COMMANDS:
        app.register_install_completion_command()
    return app


def _examples(commands: str) -> str:
    """Lay out commands as they are typed: a line each, never reflowed."""
    return f"Examples:\n\n```\n{commands}```"


def run(tokens: list[str]) -> int:
    """Parse, run, and turn every ending into an exit code and a message without traceback."""
    WATCH.quiet = bool({"-q", "--quiet"} & set(tokens))
    Spoken.options = partial(_options, *tokens[:1])
    logging.basicConfig(format="stickslip: %(message)s", stream=sys.stderr)
    logging.getLogger("stickslip").setLevel(logging.INFO)
    try:
        _refuse_undecoded(tokens)
        code = application(*tokens[:1])(
            tokens, exit_on_error=False, print_error=False, result_action="return_value"
        )
        sys.stdout.flush()
        return DONE if code is None else int(code)
    except CycloptsError as error:
        return _tell(tokens, error, BAD_USAGE)
    except (BrokenPipeError, SystemExit) as error:
        if isinstance(error, SystemExit) and not isinstance(error.__context__, BrokenPipeError):
            raise
        _drop_output()  # of help, Rich makes an exit with 1 of a pipe that is closed
        return DONE
    except (Exception, KeyboardInterrupt) as error:
        code = _tell(tokens, error, exit_code_of(error))
        if _is_lost(error):
            _drop_output()
        return code


def _options(command: str = "") -> dict[str, str]:
    """Options of a command by argument; numbers of a model are called as everywhere."""
    if command not in COMMANDS:
        return {}
    every = application(command)[command].assemble_argument_collection()
    names = [each.name for each in every if each.parameter.group != (MODEL,)]
    own = {name.lstrip("-").replace("-", "_"): name for name in names}
    return own | (claims.SPOKEN if command == "certify" else {})


def _refuse_undecoded(tokens: list[str]) -> None:
    """Refuse arguments that are no text: they cannot be told, in JSON or in a picture."""
    for number, token in enumerate(tokens, start=1):
        if any("\ud800" <= character <= "\udfff" for character in token):
            raise UsageError(
                f"argument {number}, {token!r}, is not text in the encoding of the system, "
                f"{sys.getfilesystemencoding()}"
            )


def _tell(tokens: list[str], error: BaseException, code: int) -> int:
    """Say what went wrong: a line on stderr or, with ``--json``, a document on stdout."""
    command = next((token for token in tokens if not token.startswith("-")), "")
    command = shortened(command[:LONGEST_NAME])
    if {"-v", "--verbose"} & set(tokens) and not isinstance(error, CycloptsError):
        traceback.print_exception(error)
    if code == INTERRUPTED or interrupted():
        say_interrupted()
        return INTERRUPTED
    if "--json" in tokens:
        from stickslip.cli.output import error_document

        with suppress(OSError):
            print(error_document(command, error), end="", flush=True)
            return code
    name = f"stickslip {command}".rstrip()
    print(f"{name}: {shortened(_message(error))}", file=sys.stderr)
    return code


def _is_lost(error: BaseException) -> bool:
    """Whether the standard output is full or closed; an error of any other file names the file."""
    lost = (*FULL, errno.EBADF)
    return isinstance(error, OSError) and error.filename is None and error.errno in lost


def _message(error: BaseException) -> str:
    expected = isinstance(error, CycloptsError | CommandError) or exit_code_of(error) != 1
    if isinstance(error, OSError) and _is_lost(error):
        return f"cannot write to the standard output: {error.strerror}"
    text = told_as(error) or type(error).__name__
    if isinstance(error, UnknownOptionError) and any(
        "-p" in x.names for x in error.argument_collection
    ):
        name = str(error.token.keyword or error.token.value).lstrip("-")
        text += f" A number of the model is given as -p {name}=VALUE."
    return text if expected else f"{type(error).__name__}: {text} (-v shows where)"


def _drop_output() -> None:
    """Drop output that waits to be printed: its reader left, as ``head`` does, or is full."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
