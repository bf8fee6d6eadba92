"""``stickslip bifurcations``: every bifurcation over a range of a parameter, explained."""

from __future__ import annotations

import json
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, cast

from cyclopts import Parameter

from stickslip.cli import columns, pictures
from stickslip.cli.failure import COMPUTATION_FAILED, DONE, UsageError
from stickslip.cli.files import new_folder
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
from stickslip.files import write_text
from stickslip.results.table import write_csv

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.bifurcation import BifurcationList
    from stickslip.analysis.maps.protocol import MapFamily
    from stickslip.study.event_map import EventMap
    from stickslip.study.report import Report

EXAMPLES = """\
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


def command(
    *,
    system: SystemOptions = SystemOptions(),
    sweep: SweepOptions,
    values: Annotated[Whole, Parameter(group=OUTPUT)] = 200,
    out: Annotated[Path | None, Parameter(group=OUTPUT, metavar="FOLDER")] = None,
    force: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    csv: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    output: OutputOptions = OutputOptions(),
) -> int:
    """List the bifurcations of the event map over a range of a parameter, and explain them.

    Prints a report: where each one happens and how exactly that is known, which orbits and
    attractors there are before and after, what the map's slopes foretell, and the mechanism
    in the motion. It ends with what could not be explained; the exit code is 1 if that is all
    there is.

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
    from stickslip.study.bifurcations import bifurcations

    if csv and output.json:
        raise UsageError("give either --csv or --json")
    check_equally_spaced("--values", values)
    ends = sweep.ends
    f = system.event_map()
    with ExitStack() as stack:
        files = [] if out is None else stack.enter_context(new_folder(out, FILES, force=force))
        with shares("bifurcations", quiet=output.quiet) as show:
            found = bifurcations(
                cast("MapFamily", f),
                sweep.parameter,
                ends,
                max_period=sweep.max_period,
                window=sweep.window,
                progress=show,
            )
        report = _report(f, found)
        if files:
            named = dict(zip(FILES, files, strict=True))
            _write(named, report, f)
            _draw(named, found, f, values, quiet=output.quiet)
    if output.json:
        asked = system.described(f.model) | sweep.asked()
        print(columns.document("bifurcations", asked, _result(report)), end="")
    elif csv:
        write_csv(sys.stdout, found.table())
    else:
        if out is not None:
            print("\n".join(str(out / name) for name in FILES), end="\n\n")
        print(report.text(), end="")
    return _ending(found, quiet=output.quiet or not (csv or output.json))


def _report(f: EventMap, found: BifurcationList) -> Report:
    from stickslip.study.report import Report

    laws = dict.fromkeys(law.title for law in f.model.laws)
    title = f"Bifurcations of two blocks with friction {' and '.join(laws)}"
    return Report(found, picture=PICTURES[0], title=title)


def _result(report: Report) -> dict[str, Any]:
    content = json.loads(report.as_json())
    return {name: content[name] for name in ("bifurcations", "cascades", "unresolved")}


def _write(files: dict[str, Path], report: Report, f: EventMap) -> None:
    """Write everything but the pictures."""
    from stickslip.study.model_file import write_model

    write_text(files["report.md"], report.as_markdown())
    write_text(files["report.json"], report.as_json())
    report.found.save(files["bifurcations.csv"])
    report.found.save(files["bifurcations.json"])
    write_model(f.model, files["model.toml"])


def _draw(
    files: dict[str, Path], found: BifurcationList, f: EventMap, values: int, *, quiet: bool
) -> None:
    """Draw the diagram of the same range, the bifurcations marked in it."""
    import numpy as np

    from stickslip.study.diagram import bifurcation_diagram

    with shares("diagram", quiet=quiet) as show:
        diagram = bifurcation_diagram(
            f,
            found.parameter,
            np.linspace(*found.range, values),
            max_period=found.max_period,
            window=found.window,
            progress=show,
        )
    pictures.draw(
        lambda ax: diagram.plot(ax, bifurcations=found), [files[name] for name in PICTURES]
    )


def _ending(found: BifurcationList, *, quiet: bool) -> int:
    """Tell what stayed open beside a table that cannot; fail if nothing was explained."""
    texts = [f"unresolved: {item}" for item in found.unresolved]
    notes(texts, "unresolved changes", quiet=quiet)
    return COMPUTATION_FAILED if found.unresolved and not len(found) else DONE
