"""``stickslip diagram``: orbits, attractors and breakpoints over a parameter."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from stickslip.cli import columns, pictures
from stickslip.cli.files import new_files
from stickslip.cli.options import (
    OUTPUT,
    Flag,
    OutputOptions,
    SweepOptions,
    Whole,
    check_equally_spaced,
)
from stickslip.cli.progress import notes, shares
from stickslip.cli.table import SystemOptions
from stickslip.files import checked_suffix
from stickslip.results.table import write_table

if TYPE_CHECKING:
    pass

EXAMPLES = """\
stickslip diagram --preset coulomb --parameter V --range 0.0366 0.0372 \\
    --out fig.svg
stickslip diagram --model mine.toml --parameter alpha --range 1.208 1.21865 \\
    --window 0.379 0.390 --values 2000 --out fig.pdf --csv points.csv
"""


def command(
    *,
    system: SystemOptions = SystemOptions(),
    sweep: SweepOptions,
    values: Whole = 500,
    out: Annotated[Path | None, Parameter(group=OUTPUT)] = None,
    csv: Annotated[Path | None, Parameter(group=OUTPUT)] = None,
    force: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    output: OutputOptions = OutputOptions(),
) -> None:
    """Draw a bifurcation diagram with the unstable orbits in it.

    At each value of the parameter: every periodic orbit, stable and unstable, up to the
    longest period; the attractors; the breakpoints of the map. Without --out and --csv it
    prints where each orbit exists, and what it begins and ends with. The table in --csv and
    --json has a row for each point.

    Parameters
    ----------
    values
        Number of equally spaced values of the parameter, both ends included.
    out
        Write the picture; the name ends in .svg, .pdf or .png.
    csv
        Write the points as a CSV file.
    force
        Replace the files if they exist.
    """
    import numpy as np

    from stickslip.study.diagram import bifurcation_diagram

    check_equally_spaced("--values", values)
    if out is not None:
        checked_suffix(out, pictures.SUFFIXES, "--out")
    if csv is not None:
        checked_suffix(csv, ("", ".csv"), "--csv")
    grid = np.linspace(*sweep.ends, values)
    f = system.event_map()
    files = [path for path in (out, csv) if path is not None]
    with ExitStack() as stack:
        temporary = dict(
            zip(files, stack.enter_context(new_files(files, force=force)), strict=True)
        )
        show = stack.enter_context(shares("following orbits", quiet=output.quiet))
        diagram = bifurcation_diagram(
            f,
            sweep.parameter,
            grid,
            max_period=sweep.max_period,
            window=sweep.window,
            progress=show,
        )
        if out is not None:
            pictures.draw(diagram.plot, [temporary[out]])
        if csv is not None:
            write_table(temporary[csv], diagram.table())
    notes(diagram.unresolved, "places that could not be settled", quiet=output.quiet)
    asked = system.described(f.model) | sweep.asked() | {"values": values}
    if output.json:
        print(columns.document("diagram", asked, diagram.table()), end="")
    elif files:
        print("\n".join(map(str, files)))
    else:
        columns.show(diagram.overview())
