"""``stickslip reproduce``: the paper's figures, numbers and claims, checked."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from stickslip.cli import columns
from stickslip.cli.failure import CLAIM_FAILED, DONE, UsageError
from stickslip.cli.options import OUTPUT, Flag, OutputOptions
from stickslip.cli.progress import tracked

EXAMPLES = """\
stickslip reproduce
stickslip reproduce 5 17 --out figures
stickslip reproduce --check
"""

CLAIM_FIELDS = ("key", "figure", "statement", "verdict", "evidence")
STANDS = {"holds", "holds with a correction"}


def command(
    *figures: int,
    out: Annotated[Path, Parameter(group=OUTPUT)] = Path("out"),
    check: Flag = False,
    output: OutputOptions = OutputOptions(),
) -> int:
    """Compute figures of Galvanetto (2001), and check what the paper prints and claims.

    Writes figNN.svg, .pdf and .png, values.json and values.md, report.json and report.md,
    and replaces those of an earlier run; other files in the folder stay. Prints their names,
    then a line for each claim that belongs to the figures: does it hold, and if not, why.

    Parameters
    ----------
    figures
        Numbers of figures; all that there are if not given.
    out
        Folder to write to; made if it is not there.
    check
        Exit with code 4 unless every claim holds, as it is printed or with a correction.
    """
    from stickslip.studies.sources import GALVANETTO

    return deliver("reproduce", GALVANETTO, figures, out, check=check, output=output)


def deliver(
    command: str,
    source: str,
    figures: tuple[int, ...],
    out: Path,
    *,
    check: bool,
    output: OutputOptions,
) -> int:
    """Compute a study, write its files, and print what became of its claims."""
    from stickslip import studies

    if out.exists() and not out.is_dir():
        raise UsageError(f"--out {out} is a file; figures go to a folder")

    def track(numbers: Sequence[int]) -> Iterator[int]:
        return tracked(numbers, len(numbers), "figures", quiet=output.quiet)

    done = studies.reproduce(figures or None, out, source=source, track=track)
    written = [str(path) for path in done.files]
    claims = done.report.claims
    if output.json:
        result = {"file": written}
        result |= {name: [getattr(claim, name) for claim in claims] for name in CLAIM_FIELDS}
        asked = {} if command == "reproduce" else {"name": source}
        print(columns.document(command, {**asked, "figures": figures}, result), end="")
    else:
        print("\n".join(written))
        if claims:
            print(f"\n{done.report.text()}", end="")
    failed = any(claim.verdict not in STANDS for claim in claims)
    return CLAIM_FAILED if check and failed else DONE
