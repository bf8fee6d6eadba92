"""Commands about a range of a parameter: ``stickslip bifurcations`` and ``diagram``."""

from __future__ import annotations

import json
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from cyclopts import Parameter

from stickslip.cli.options import (
    OUTPUT,
    Flag,
    OutputOptions,
    SweepOptions,
    SystemOptions,
    Whole,
    check_equally_spaced,
)
from stickslip.cli.output import (
    PICTURE_SUFFIXES,
    document,
    draw_pictures,
    new_files,
    new_folder,
    notes,
    show_table,
)
from stickslip.cli.process import COMPUTATION_FAILED, DONE, UsageError
from stickslip.files import checked_suffix, write_csv, write_table, write_text

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.bifurcation import BifurcationList
    from stickslip.analysis.diagrams.diagram import Diagram
    from stickslip.cli.report import Report
    from stickslip.numerics.arrays import Floats

BIFURCATIONS_EXAMPLES = """\
stickslip bifurcations --preset coulomb --parameter V --range 0.0366 0.0372
stickslip bifurcations --preset law9 --parameter alpha \\
    --range 1.208 1.21865 --window 0.379 0.390 --out report
stickslip bifurcations --model mine.toml --parameter beta \\
    --range 1.29 1.31 --max-period 2 --csv
"""

PICTURES: Final = ("diagram.svg", "diagram.pdf", "diagram.png")
FILES: Final = (
    "report.md",
    "report.json",
    "bifurcations.csv",
    "bifurcations.json",
    "model.toml",
    *PICTURES,
)


def bifurcations(
    *,
    system: SystemOptions = SystemOptions(),
    sweep: SweepOptions,
    values: Annotated[Whole, Parameter(group=OUTPUT)] = 200,
    out: Annotated[Path | None, Parameter(group=OUTPUT, metavar="FOLDER")] = None,
    force: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    csv: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    output: OutputOptions = OutputOptions(),
) -> int:
    """List the bifurcations of a model's map over a range of a parameter, and explain them.

    Prints a report: where each one happens and how exactly that is known, which orbits and
    attractors there are before and after, what the map's slopes foretell, and the mechanism
    in the motion. It ends with what could not be explained; the exit code is 1 if that is all
    there is. Of a map of several numbers (three blocks) the list may lack some.

    Parameters
    ----------
    values
        Number of values of the parameter in the diagram.
    out
        Write to this folder: the report (report.md, report.json), the table
        (bifurcations.csv), all of the result (bifurcations.json, for stickslip.load), the
        model (model.toml) and a bifurcation diagram (diagram.svg, .pdf, .png).
    force
        Replace the files of an earlier run.
    csv
        Print the table alone, as CSV.
    """
    from stickslip.analysis.bifurcations.bifurcations import bifurcations

    if csv and output.json:
        raise UsageError("give either --csv or --json")
    grid = _grid(sweep, values)
    f = sweep.checked(system.map())
    with ExitStack() as stack:
        files = [] if out is None else stack.enter_context(new_folder(out, FILES, force=force))
        found = bifurcations(
            f, sweep.parameter, sweep.ends, max_period=sweep.max_period, window=sweep.window
        )
        report = _report(f, found)
        if files:
            named = dict(zip(FILES, files, strict=True))
            _write_report(named, report, f)
            diagram = _diagram(f, sweep, grid)
            pictures = [named[name] for name in PICTURES]
            draw_pictures(lambda ax: diagram.plot(ax, bifurcations=found), pictures)
    if output.json:
        asked = system.described(f.model) | sweep.asked()
        print(document("bifurcations", asked, _result(report)), end="")
    elif csv:
        write_csv(sys.stdout, found.table())
    else:
        if out is not None:
            print("\n".join(str(out / name) for name in FILES), end="\n\n")
        print(report.text(), end="")
    return _bifurcation_ending(found, quiet=output.quiet or not (csv or output.json))


def _report(f: Any, found: BifurcationList) -> Report:
    from stickslip.cli.report import Report

    laws = dict.fromkeys(law.title for law in f.model.laws)
    event = getattr(f, "event", None)
    blocks = "two blocks" if f.dimension == 1 else f.model.size
    what = f"a map from {event} to {event}" if event else blocks
    title = f"Bifurcations of {what} with friction {' and '.join(laws)}"
    return Report(found, picture=PICTURES[0], title=title)


def _result(report: Report) -> dict[str, Any]:
    content = json.loads(report.as_json())
    return {name: content[name] for name in ("bifurcations", "cascades", "unresolved", "outside")}


def _write_report(files: dict[str, Path], report: Report, f: Any) -> None:
    """Write everything but the pictures."""
    from stickslip.mechanics.model.file import write_model

    write_text(files["report.md"], report.as_markdown())
    write_text(files["report.json"], report.as_json())
    report.found.save(files["bifurcations.csv"])
    report.found.save(files["bifurcations.json"])
    write_model(f.model, files["model.toml"])


def _grid(sweep: SweepOptions, values: int) -> Floats:
    """Return equally spaced values of the parameter."""
    import numpy as np

    check_equally_spaced("--values", values)
    return np.linspace(*sweep.ends, values)


def _diagram(f: Any, sweep: SweepOptions, grid: Floats) -> Diagram:
    """Compute the diagram over the range."""
    from stickslip.analysis.diagrams.diagrams import bifurcation_diagram

    return bifurcation_diagram(
        f, sweep.parameter, grid, max_period=sweep.max_period, window=sweep.window
    )


def _bifurcation_ending(found: BifurcationList, *, quiet: bool) -> int:
    """Tell what stayed open beside a table that cannot; fail if nothing was explained."""
    texts = [f"unresolved: {item}" for item in found.unresolved]
    notes(texts, "unresolved changes", quiet=quiet)
    notes([str(item) for item in found.outside], "parts outside the question", quiet=quiet)
    return COMPUTATION_FAILED if found.unresolved and not len(found) else DONE


DIAGRAM_EXAMPLES = """\
stickslip diagram --preset coulomb --parameter V --range 0.0366 0.0372 \\
    --out fig.svg
stickslip diagram --model mine.toml --parameter alpha --range 1.208 1.21865 \\
    --window 0.379 0.390 --values 2000 --out fig.pdf --csv points.csv
"""


def diagram(
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
    longest period; the attractors; the breakpoints of the map. Of a map of several numbers
    (three blocks): the orbits that searches lead to, and the attractors. Without --out and --csv it
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
    grid = _grid(sweep, values)
    if out is not None:
        checked_suffix(out, PICTURE_SUFFIXES, "--out")
    if csv is not None:
        checked_suffix(csv, ("", ".csv"), "--csv")
    f = sweep.checked(system.map())
    files = [path for path in (out, csv) if path is not None]
    with new_files(files, force=force) as made:
        temporary = dict(zip(files, made, strict=True))
        diagram = _diagram(f, sweep, grid)
        if out is not None:
            draw_pictures(diagram.plot, [temporary[out]])
        if csv is not None:
            write_table(temporary[csv], diagram.table())
    notes(diagram.unresolved, "places that could not be settled", quiet=output.quiet)
    asked = system.described(f.model) | sweep.asked() | {"values": values}
    if output.json:
        print(document("diagram", asked, diagram.table()), end="")
    elif files:
        print("\n".join(map(str, files)))
    else:
        show_table(diagram.overview())
