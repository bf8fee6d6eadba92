"""``stickslip reproduce``: the paper's figures and the table of its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from stickslip.cli import columns
from stickslip.cli.failure import UsageError
from stickslip.cli.options import OUTPUT, OutputOptions
from stickslip.cli.progress import tracked

EXAMPLES = """\
stickslip reproduce
stickslip reproduce 5 17 --out figures
"""


def command(
    *figures: int,
    out: Annotated[Path, Parameter(group=OUTPUT)] = Path("out"),
    output: OutputOptions = OutputOptions(),
) -> None:
    """Compute figures of Galvanetto (2001) and compare the numbers that the paper prints.

    Writes figNN.svg, .pdf and .png, and values.json and values.md, and replaces those of
    an earlier run; other files in the folder stay.

    Parameters
    ----------
    figures
        Numbers of figures; all that there are if not given.
    out
        Folder to write to; made if it is not there.
    """
    from stickslip import paper

    if out.exists() and not out.is_dir():
        raise UsageError(f"--out {out} is a file; figures go to a folder")

    def track(numbers: Sequence[int]) -> Iterator[int]:
        return tracked(numbers, len(numbers), "figures", quiet=output.quiet)

    written = [str(path) for path in paper.reproduce(figures or None, out, track=track).files]
    if output.json:
        print(columns.document("reproduce", {"figures": figures}, {"file": written}), end="")
        return
    for path in written:
        print(path)
