"""Exit codes, and the exceptions that carry them from a command to the program."""

from __future__ import annotations

from typing import Final

from stickslip.errors import MissingExtraError

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
