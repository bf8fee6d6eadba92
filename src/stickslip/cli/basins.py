"""``stickslip basins``: which starting points end on which attractor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.cli.failure import COMPUTATION_FAILED, DONE
from stickslip.cli.progress import note
from stickslip.cli.table import TableOptions

if TYPE_CHECKING:
    from stickslip.analysis.attractors.basins import Basins

EXAMPLES = """\
stickslip basins --preset coulomb
stickslip basins --preset coulomb --V 0.037 --json
stickslip basins --preset law9 --alpha 1.208 --out basins.csv
"""

FATES = {-1: "undecided", -2: "leaves"}


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

    def compute() -> dict[str, Any]:
        answer.append(ss.basins(f, resolution=resolution))
        return _rows(answer[0])

    table.deliver(
        "basins", f.model, {"resolution": resolution}, compute, lambda ax: answer[0].plot(ax)
    )
    return _ending(answer[0], quiet=table.quiet)


def _rows(found: Basins) -> dict[str, Any]:
    """Lay out the intervals; attractors are numbered from 1, 0 is none."""
    import numpy as np

    widths = np.diff(found.edges)
    fates = [_fate(found, int(k)) for k in found.index]
    names = ("attractor", "kind", "period", "d", "lyapunov")
    causes = [str(cause) for cause in found.causes]
    return {
        "left": found.edges[:-1],
        "right": found.edges[1:],
        "share": widths / widths.sum(),
        **dict(zip(names, map(list, zip(*fates, strict=True)), strict=True)),
        "left_cause": causes[:-1],
        "right_cause": causes[1:],
    }


def _fate(found: Basins, k: int) -> tuple[int, str, int, float, float]:
    if k in FATES:
        return 0, FATES[k], 0, float("nan"), float("nan")
    attractor = found.attractors[k]
    return (
        k + 1,
        attractor.kind if attractor.kind != "undecided" else "undecided attractor",
        attractor.period,
        float(attractor.bands[0, 0]),
        attractor.lyapunov.value,
    )


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
