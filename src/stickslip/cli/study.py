"""``stickslip study``: figures, numbers and claims of the literature, checked."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from stickslip.cli import columns
from stickslip.cli.failure import DONE, UsageError
from stickslip.cli.options import OUTPUT, Flag, OutputOptions
from stickslip.cli.reproduce import deliver

EXAMPLES = """\
stickslip study --list
stickslip study leine1998
stickslip study quasistatic 1 --out figures --check
"""


def command(
    name: str | None = None,
    *figures: int,
    list: Flag = False,
    out: Annotated[Path | None, Parameter(group=OUTPUT)] = None,
    check: Flag = False,
    output: OutputOptions = OutputOptions(),
) -> int:
    """Compute a study of the literature: figures, and published numbers beside computed ones.

    Writes figNN.svg, .pdf and .png, values.json and values.md, report.json and report.md,
    and replaces those of an earlier run; other files in the folder stay. Prints their names,
    then a line for each claim: does it hold, and if not, why.

    Parameters
    ----------
    name
        Of the study.
    figures
        Numbers of figures; all that there are if not given.
    list
        List the studies instead.
    out
        Folder to write to, out/NAME if not given; made if it is not there.
    check
        Exit with code 4 unless every claim holds, as it is stated or with a correction.
    """
    from stickslip import studies

    if list:
        known = studies.sources()
        rows = {
            field: [getattr(item, field) for item in known] for field in ("name", "source", "title")
        }
        if output.json:
            print(columns.document("study", {}, rows), end="")
        else:
            print("\n".join(f"{item.name:16s}  {item.source}: {item.title}" for item in known))
        return DONE
    if name is None:
        raise UsageError("name a study; stickslip study --list names them all")
    folder = out or Path("out") / name
    return deliver("study", name, figures, folder, check=check, output=output)
