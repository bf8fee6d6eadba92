"""Command line: each subcommand turns options into calls of public names, nothing more."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from stickslip import __version__


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command ``stickslip``.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the program's name; ``sys.argv[1:]`` if not given.

    Returns
    -------
    int
        Exit code: 0 done, 1 a computation failed, 2 bad usage or file, 3 refused to
        overwrite, 4 a checked claim did not hold, 130 interrupted.
    """
    tokens = list(sys.argv[1:] if arguments is None else arguments)
    if tokens == ["--version"]:  # without building the parser: scripts ask this often
        print(__version__)
        return 0
    from stickslip.cli.program import run

    return run(tokens)
