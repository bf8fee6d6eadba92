"""``stickslip orbits``: every periodic orbit of the event map up to a period."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.cli.failure import COMPUTATION_FAILED, DONE, UsageError
from stickslip.cli.options import Flag, Whole
from stickslip.cli.progress import notes
from stickslip.cli.table import TableOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stickslip.analysis.orbits.orbit import OrbitList
    from stickslip.results.table import Table
    from stickslip.study.event_map import EventMap

EXAMPLES = """\
stickslip orbits --preset coulomb --max-period 4
stickslip orbits --preset coulomb --period 4 --infinitely-unstable --json
stickslip orbits --preset law9 --alpha 1.211 --max-period 6 --out orbits.csv
"""


def command(
    *,
    table: TableOptions = TableOptions(),
    max_period: Whole | None = None,
    period: Whole | None = None,
    infinitely_unstable: Flag = False,
    resolution: float = 1e-9,
) -> int:
    """List the periodic orbits of the event map, stable and unstable, each once.

    One row for each point of each orbit, the orbits numbered by period and place. Columns:
    orbit, period, kind, multiplier (inf if the orbit crosses a jump), point and d with its
    error, itinerary from this point to the next. What could not be decided is said on
    stderr; the exit code is 1 if the list is not complete up to the period asked for.

    Parameters
    ----------
    max_period
        List minimal periods 1 to this; 1 if not given.
    period
        List this minimal period alone.
    infinitely_unstable
        Add the orbits that cross a jump of the map.
    resolution
        Pieces of the map narrower than this may be missed.
    """
    import stickslip as ss

    if period is not None and max_period is not None:
        raise UsageError("give either --max-period or --period")
    highest = 1 if max_period is None else max_period
    f = table.event_map()
    answer: list[OrbitList] = []

    def compute() -> Table:
        found = ss.periodic_orbits(
            f,
            highest,
            period=period,
            infinitely_unstable=infinitely_unstable,
            resolution=resolution,
        )
        answer.append(found)
        return found.table()

    asked: dict[str, Any] = {"max_period": highest} if period is None else {"period": period}
    asked |= {"infinitely_unstable": infinitely_unstable, "resolution": resolution}
    table.deliver("orbits", f.model, asked, compute, lambda ax: _plot(f, answer[0], ax))
    return _ending(answer[0], quiet=table.quiet)


def _plot(f: EventMap, found: OrbitList, ax: Axes) -> Axes:
    """Draw the orbits' points on the map."""
    from stickslip.plot.event_map import event_map

    return found.plot(event_map(f, ax))


def _ending(found: OrbitList, *, quiet: bool) -> int:
    """Tell what stayed open; fail if orbits of a period asked for may be missing."""
    near = [near for near in found.near_folds if not near.resolved]
    reasons = [
        f"none, two or a whole interval of orbits of period {item.period} at d = {item.x:.12g}: "
        f"the map comes within {item.distance:.2g} of the diagonal"
        for item in near
    ]
    reasons += [str(item) for item in found.unresolved]
    notes(reasons, "undecided places", quiet=quiet)
    return DONE if found.complete >= found.max_period else COMPUTATION_FAILED
