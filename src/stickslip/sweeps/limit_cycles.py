"""Limit cycles in continuous time, of any model: the one block and the forced ones too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from stickslip.analysis.maps.protocol import mix_labels
from stickslip.mechanics.cycle.limit_cycles import limit_cycles
from stickslip.sweeps.observable import Columns, Observable, Output, whole

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.limit_cycles import CycleList
    from stickslip.sweeps.points import Points


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
    The stable ones of `stickslip.limit_cycles`. The first cycle is the one that most starts led
    to.
    """

    name: ClassVar[str] = "limit_cycles"
    needs: ClassVar[tuple[str, ...]] = ("model",)
    n_starts: int = whole(8)
    max_events: int = whole(2000)

    def outputs(self) -> tuple[Output, ...]:
        """Return its variables."""
        return (
            Output("n_cycles", "int32", "number of stable limit cycles found"),
            Output("cycle_period", "float64", "period of the first limit cycle, in sqrt(m / k)"),
            Output("cycle_multiplier", "float64", "largest multiplier of the first limit cycle"),
            Output("cycle_events", "int32", "events in a period of the first limit cycle"),
            Output("sliding_share", "float64", "share of starts from which all blocks slip on"),
            Output("no_cycle_share", "float64", "share of starts from which no cycle was found"),
        )

    def compute(self, points: Points) -> Columns:
        """Return their values."""
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
            for output, column in zip(self.outputs(), columns, strict=True)
        }


def _row(found: CycleList) -> tuple[float, ...]:
    stable = [cycle for cycle in found if cycle.stable]
    shares = found.n_sliding / found.n_starts, found.n_undecided / found.n_starts
    if not stable:
        return (0, np.nan, np.nan, 0, *shares)
    first = stable[0]
    size = float(np.abs(first.multipliers).max(initial=0.0))
    return (len(stable), first.period, size, len(first.events), *shares)
