"""What several starts at each grid point lead to: attractors of the map, limit cycles in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.maps.protocol import mix_labels
from stickslip.checks import MOST_STEPS
from stickslip.mechanics.cycle.limit_cycles import limit_cycles
from stickslip.numerics.long_run import CHAOTIC, LEFT, PERIODIC, UNDECIDED
from stickslip.sweeps.job import Columns, Observable, Output, whole
from stickslip.sweeps.system import Run

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.limit_cycles import CycleList
    from stickslip.sweeps.job import Points

SAME_POINT: Final = 1e-6  # of the domain: cycles whose rightmost points are this close are one


@dataclass(frozen=True, kw_only=True)
class CoexistingAttractors(Observable):
    """Number of different attractors that orbits from several starting points settle on.

    Parameters
    ----------
    n_starts : int
        Starting points, one at random in each of as many equal cells of the domain.
    transient, n, max_period : int
        As in `Attractor`.

    Notes
    -----
    Two cycles are one if their periods agree and their rightmost points lie within 1e-6 of the
    domain; two chaotic orbits are one if they share at least half of the cells, of 256, that the
    smaller one visits. Orbits that are undecided count as no attractor, so that the number is a
    lower bound where ``undecided_share`` is above zero, and wherever a basin holds no seed.
    """

    name: ClassVar[str] = "coexisting_attractors"
    needs: ClassVar[tuple[str, ...]] = ("orbits", "line")
    recorded: ClassVar[tuple[Output, ...]] = (
        Output("n_attractors", "int32", "number of coexisting attractors found"),
        Output("undecided_share", "float64", "share of starting points without a verdict"),
        Output("left_share", "float64", "share of starting points whose orbit ends"),
    )
    n_starts: int = whole(16)
    transient: int = whole(1000, least=0, most=MOST_STEPS)
    n: int = whole(1000, least=2)
    max_period: int = whole(64)

    @property
    def _run(self) -> Run:
        return Run(self.n_starts, self.transient, self.n, self.max_period)

    def runs(self) -> dict[Run, int]:
        """Return the orbits that are needed."""
        return {self._run: min(self.max_period, self.n // 2)}

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        found = points.orbits(self._run)
        by_point = (points.size, self.n_starts)
        kind = found.verdicts.kind.reshape(by_point)
        period = found.verdicts.period.reshape(by_point)
        cells = found.verdicts.cells.reshape(*by_point, -1)
        tail = found.followed.tail.reshape(*by_point, -1)
        width = SAME_POINT * points.widths
        number = [
            _cycles(period[i][kind[i] == PERIODIC], tail[i][kind[i] == PERIODIC], width[i])
            + _chaotic_sets(cells[i][kind[i] == CHAOTIC])
            for i in range(points.size)
        ]
        return {
            "n_attractors": np.array(number, dtype=np.int32),
            "undecided_share": (kind == UNDECIDED).mean(axis=1),
            "left_share": (kind == LEFT).mean(axis=1),
        }


def _cycles(period: NDArray[Any], tail: NDArray[Any], apart: float) -> int:
    """Count different cycles among orbits that have settled on one."""
    found: list[tuple[int, float]] = []
    for p, points in zip(period.tolist(), tail, strict=True):
        rightmost = float(points[-p:].max())
        if not any(p == q and abs(rightmost - other) <= apart for q, other in found):
            found.append((p, rightmost))
    return len(found)


def _chaotic_sets(cells: NDArray[np.uint64]) -> int:
    """Count different sets among chaotic orbits by the cells that they visit."""
    found: list[NDArray[np.uint64]] = []
    for bits in cells:
        for other in found:
            least = min(np.bitwise_count(bits).sum(), np.bitwise_count(other).sum())
            if 2 * np.bitwise_count(bits & other).sum() >= least:
                break
        else:
            found.append(bits)
    return len(found)


@dataclass(frozen=True, kw_only=True)
class LimitCycles(Observable):
    """Stable limit cycles that motions from states drawn at random lead to, and the first of them.

    Parameters
    ----------
    n_starts : int
        States drawn for each grid point, half of them with all blocks on the belt.
    max_events : int
        Changes of mode (of a forced model: periods of the forcing) that a motion is followed for.

    Notes
    -----
    The stable ones of `stickslip.limit_cycles`, which sorts cycles by the number of starts that
    lead to them.
    """

    name: ClassVar[str] = "limit_cycles"
    needs: ClassVar[tuple[str, ...]] = ("model",)
    recorded: ClassVar[tuple[Output, ...]] = (
        Output("n_cycles", "int32", "number of stable limit cycles found"),
        Output("cycle_period", "float64", "period of the first limit cycle, in sqrt(m / k)"),
        Output("cycle_multiplier", "float64", "largest multiplier of the first limit cycle"),
        Output("cycle_events", "int32", "events in a period of the first limit cycle"),
        Output("sliding_share", "float64", "share of starts from which all blocks slip on"),
        Output("no_cycle_share", "float64", "share of starts from which no cycle was found"),
    )
    n_starts: int = whole(8)
    max_events: int = whole(2000)

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        seeds = mix_labels(np.full(points.size, points.seed, dtype=np.uint64), points.index)
        rows = []
        for values, seed in zip(points.values(), seeds.tolist(), strict=True):
            model = points.system.model_at(values)
            found = limit_cycles(
                model, n_starts=self.n_starts, max_events=self.max_events, rng=seed
            )
            rows.append(_row(found))
        columns = zip(*rows, strict=True)
        return {
            output.name: np.array(column, dtype=output.dtype)
            for output, column in zip(self.recorded, columns, strict=True)
        }


def _row(found: CycleList) -> tuple[float, ...]:
    stable = [cycle for cycle in found if cycle.stable]
    shares = found.n_sliding / found.n_starts, found.n_undecided / found.n_starts
    if not stable:
        return (0, np.nan, np.nan, 0, *shares)
    first = stable[0]
    size = float(np.abs(first.multipliers).max(initial=0.0))
    return (len(stable), first.period, size, len(first.events), *shares)
