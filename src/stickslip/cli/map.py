"""``stickslip map``: the event map at given points or on a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from stickslip.cli.failure import COMPUTATION_FAILED, DONE, UsageError
from stickslip.cli.options import ENGINE, Flag, Whole
from stickslip.cli.progress import note, tracked
from stickslip.cli.table import TableOptions

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.event_map import EventMap

EXAMPLES = """\
stickslip map --preset coulomb -d -0.2 -d 0.1 --itinerary
stickslip map --alpha 1.2 --beta 1.3 --V 0.0366 \\
    --friction coulomb:mu=0.22 -d -0.2 -d 0.1 --json
stickslip map --preset law9 --alpha 1.209 --grid 2000 \\
    --window 0.379 0.39 --out map.csv
"""

PIECE = 20_000  # points between two steps of the progress bar


def command(
    *,
    table: TableOptions = TableOptions(),
    d: Annotated[
        tuple[float, ...], Parameter(name=["--d", "-d"], negative=(), show_default=False)
    ] = (),
    grid: Whole | None = None,
    window: Annotated[tuple[float, float] | None, Parameter(negative=())] = None,
    itinerary: Flag = False,
    max_time: Annotated[float | None, Parameter(group=ENGINE)] = None,
    threads: Annotated[Whole | None, Parameter(group=ENGINE)] = None,
) -> int:
    """Carry d = X_2 - X_1 from one global stick phase to the next.

    Prints a table on a terminal, CSV into a pipe. A motion that never returns to global
    stick has value nan and a status that says why; the exit code is 1 if no point at all
    has an answer.

    Parameters
    ----------
    d
        A point to map; may be given several times.
    grid
        Map so many equally spaced points instead, both ends included.
    window
        The two ends of the grid; the whole domain if not given.
    itinerary
        Add the modes of the blocks (. stick, - backward, + forward) from event to event.
    max_time
        Give up on a motion after this time, in units of sqrt(m / k).
    threads
        Threads for large arrays; all cores if not given.
    """
    asked = {} if max_time is None else {"max_time": max_time}
    f = table.event_map(threads=threads, **asked)
    points = _points(f, d, grid, window)

    def compute() -> dict[str, Any]:
        return _evaluated(f, points, itinerary=itinerary, quiet=table.quiet)

    def plot(ax: Axes) -> Axes:
        return _plot(f, points, window, ax, marked=bool(d))

    result = table.deliver("map", f.model, asked, compute, plot)
    return _ending(result, quiet=table.quiet)


def _points(
    f: EventMap, d: tuple[float, ...], grid: int | None, window: tuple[float, float] | None
) -> NDArray[np.float64]:
    import numpy as np

    if bool(d) == (grid is not None):
        raise UsageError("give either points, -d 0.1 -d 0.2, or a grid, --grid 2000")
    if grid is None:
        if window is not None:
            raise UsageError("--window belongs to --grid")
        return np.array(d)
    if grid < 2:
        raise UsageError(f"--grid {grid}: a grid has at least 2 points")
    first, last = window or f.domain
    return np.linspace(first, last, grid)


def _evaluated(
    f: EventMap, points: NDArray[np.float64], *, itinerary: bool, quiet: bool
) -> dict[str, Any]:
    import numpy as np

    pieces = np.array_split(points, max(1, -(-points.size // PIECE)))
    bar = tracked(pieces, len(pieces), "mapping", quiet=quiet)
    results = [f.evaluate(piece) for piece in bar]
    tables = [result.table() for result in results]
    table: dict[str, Any] = {
        name: np.concatenate([part[name] for part in tables]) for name in tables[0]
    }
    if itinerary:
        table["itinerary"] = [f.itinerary(point) for point in points]
    return table


def _plot(
    f: EventMap,
    points: NDArray[np.float64],
    window: tuple[float, float] | None,
    ax: Axes,
    *,
    marked: bool,
) -> Axes:
    """Draw the map over the window; points that were asked for one by one are marked."""
    from stickslip.plot.event_map import event_map

    event_map(f, ax, window=window)
    if marked:
        ax.plot(points, f(points), "o", ms=4)
    return ax


def _ending(table: Mapping[str, Any], *, quiet: bool) -> int:
    """Tell how many points have no value and why; fail if none has an answer."""
    import numpy as np

    from stickslip import status

    codes, counts = np.unique(table["status"], return_counts=True)
    for code, count in zip(codes, counts, strict=True):
        if code != status.OK:
            note(f"{count} of {counts.sum()}: {status.MESSAGES[code]}", quiet=quiet)
    answers = {status.OK, status.NEVER_SLIPPING, status.NEVER_CYCLE}
    return DONE if answers & set(codes.tolist()) else COMPUTATION_FAILED
