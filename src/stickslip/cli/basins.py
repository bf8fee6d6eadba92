"""``stickslip basins``: which starting points end on which attractor."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.cli.failure import COMPUTATION_FAILED, DONE
from stickslip.cli.progress import note
from stickslip.cli.table import TableOptions

if TYPE_CHECKING:
    from stickslip.analysis.attractors.basins import Basins
    from stickslip.results.table import Table

EXAMPLES = """\
stickslip basins --preset coulomb
stickslip basins --preset coulomb --V 0.037 --json
stickslip basins --preset law9 --alpha 1.208 --out basins.csv
"""


def command(*, table: TableOptions = TableOptions(), resolution: float = 1e-5) -> int:
    """Divide the domain of the event map into basins of attraction.

    One row for each interval, from left to right. Columns: its ends; its share of the
    domain; number, kind, period, smallest point and Lyapunov exponent of the attractor that
    its points end on; why it ends where it does. An interval whose motions reach a gap of
    the map "leaves"; what is "undecided" is explained on stderr, and the exit code is 1 if
    that is the whole domain.

    Parameters
    ----------
    resolution
        Share of the domain below which interwoven basins are left undecided.
    """
    import stickslip as ss

    f = table.event_map()
    answer: list[Basins] = []

    def compute() -> Table:
        answer.append(ss.basins(f, resolution=resolution))
        return answer[0].table()

    table.deliver(
        "basins", f.model, {"resolution": resolution}, compute, lambda ax: answer[0].plot(ax)
    )
    return _ending(answer[0], quiet=table.quiet)


def _ending(found: Basins, *, quiet: bool) -> int:
    """Tell what is undecided or was left out; fail if nothing could be decided."""
    if found.undecided > 0.0:
        note(f"{found.undecided:.3g} of the domain undecided: {found.reason}", quiet=quiet)
    if found.thin:
        note(
            f"{found.thin} intervals below 1e-10 of the domain are not listed: "
            "basins accumulate at an edge",
            quiet=quiet,
        )
    return COMPUTATION_FAILED if (found.index == -1).all() else DONE
