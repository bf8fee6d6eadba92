"""``stickslip diagram``: orbits, attractors and breakpoints over a parameter."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
from stickslip.files import checked_suffix, columns_of, write_table

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np
    from numpy.typing import NDArray

    from stickslip.analysis.diagrams.diagram import Diagram

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

    from stickslip.analysis.diagrams.diagrams import bifurcation_diagram

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
            write_table(temporary[csv], _rows(diagram))
    notes(diagram.unresolved, "places that could not be settled", quiet=output.quiet)
    asked = system.described(f.model) | sweep.asked() | {"values": values}
    if output.json:
        print(columns.document("diagram", asked, _rows(diagram)), end="")
    elif files:
        print("\n".join(map(str, files)))
    else:
        columns.show(columns_of(diagram))


def _rows(diagram: Diagram) -> dict[str, Any]:
    """Lay out the diagram, a row for each point: orbits, then attractors, then breakpoints."""
    import numpy as np

    parts = [*_orbits(diagram), _attractors(diagram), *_breakpoints(diagram)]
    names = ("what", "number", "kind", "period", "point", "d", "multiplier", "lyapunov")
    table = {name: np.concatenate([part[name] for part in parts]) for name in names}
    return {diagram.parameter: np.concatenate([part["value"] for part in parts]), **table}


def _part(d: NDArray[np.float64], **facts: Any) -> dict[str, Any]:
    """Rows for points of shape (n, p); facts hold for all rows, or have shape (n, 1) or (p,)."""
    import numpy as np

    there = np.isfinite(d)
    point = np.arange(d.shape[1]) + 1
    facts = {"multiplier": np.nan, "lyapunov": np.nan, "point": point, **facts}
    spread = {name: np.broadcast_to(fact, d.shape)[there] for name, fact in facts.items()}
    return {"d": d[there], **spread}


def _orbits(diagram: Diagram) -> Iterator[dict[str, Any]]:
    import numpy as np

    for number, orbit in enumerate(diagram.orbits, start=1):
        yield _part(
            orbit.points,
            value=diagram.values[:, np.newaxis],
            what="orbit",
            number=number,
            kind=np.where(orbit.stable, "stable", "unstable")[:, np.newaxis],
            period=orbit.period,
            multiplier=orbit.multipliers[:, np.newaxis],
        )


def _attractors(diagram: Diagram) -> dict[str, Any]:
    """Attractors, numbered at each value."""
    import numpy as np

    table = diagram.attractors
    number = np.arange(table.where.size) - np.searchsorted(table.where, table.where) + 1
    facts = {"kind": table.kind, "period": table.period, "lyapunov": table.lyapunov}
    facts |= {"value": diagram.values[table.where], "number": number}
    columns = {name: fact[:, np.newaxis] for name, fact in facts.items()}
    return _part(table.points, what="attractor", **columns)


def _breakpoints(diagram: Diagram) -> Iterator[dict[str, Any]]:
    import numpy as np

    for number, line in enumerate(diagram.breakpoints, start=1):
        yield _part(
            line.d[:, np.newaxis],
            value=diagram.values[:, np.newaxis],
            what="breakpoint",
            number=number,
            kind=line.kind,
            period=0,
        )
