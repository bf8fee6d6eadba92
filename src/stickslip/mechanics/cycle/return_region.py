"""Where the event map exists: global stick phases whose motions never come back to one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip import status as status_codes
from stickslip.analysis.continuation.curve import Curve
from stickslip.checks import MOST_KEPT, checked_interval, whole_number
from stickslip.errors import NoCycleError
from stickslip.mechanics.cycle.continuation import follow_cycle
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.cycle.trapping import TrappingBall, trapping_ball
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.arguments import checked_parameter, two_blocks
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.waiting import waits
from stickslip.numerics.zeros import halved
from stickslip.results.result import Result
from stickslip.results.table import free_name
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.numerics.arrays import Floats


HALVINGS: Final = 44  # of a cell of the grid: its edges are found to rounding
SAME_PERIOD: Final = 1e-3  # relative, between a cycle and the curve that it is compared with
UNDECIDED: Final = (status_codes.EVENT_LIMIT, status_codes.TIME_LIMIT)


@dataclass(frozen=True, eq=False, repr=False)
class Gap(Result):
    """An interval of differences from which motions do not return to global stick.

    Attributes
    ----------
    value : float
        Of the parameter.
    d : tuple of float
        Its ends: the last points of the grid's cells without a return, solved for to rounding.
    status : int
        At its middle, as in `stickslip.status`; an event limit means that it is undecided.
    curve : int or None
        Which of the curves of cycles attracts the motion from its middle.
    ball : TrappingBall or None
        That this motion enters and that the cycle's return map takes into itself.
    """

    value: float
    d: tuple[float, float]
    status: int
    curve: int | None
    ball: TrappingBall | None
    _column_names: ClassVar = (
        *("value", "d_low", "d_high", "status", "period", "multiplier", "shown"),
    )
    _plot: ClassVar = "cycles.plot_gap"
    _has_picture: ClassVar = False

    @property
    def shown(self) -> bool:
        """The motion from its middle has been seen to enter a ball that holds it."""
        return self.ball is not None

    def _columns(self) -> dict[str, Any]:
        period, multiplier = math.nan, math.nan
        if self.ball is not None:
            cycle = self.ball.cycle
            period, multiplier = cycle.period, float(np.abs(cycle.multipliers).max())
        facts = (
            *(self.value, *self.d, status_codes.NAMES[self.status]),
            *(period, multiplier, self.shown),
        )
        return {name: [fact] for name, fact in zip(self._column_names, facts, strict=True)}


@dataclass(frozen=True, eq=False, repr=False)
class ReturnRegion(Result):
    """Where the event map of two blocks is defined, in the plane of d and a parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray of float, shape (n,)
    gaps : tuple of tuple of Gap
        At each value, ascending in d.
    lost : ndarray of float, shape (n,)
        Share of the domain without a return, undecided parts included.
    undecided : ndarray of float, shape (n,)
        Share of the domain whose motions were given up.
    curves : tuple of Curve
        Cycles without global stick phases that attract from gaps, followed over the range.
    n_points : int
        Differences tried at each value: a narrower gap may be missed.
    """

    parameter: str
    values: Floats
    gaps: tuple[tuple[Gap, ...], ...]
    lost: Floats
    undecided: Floats
    curves: tuple[Curve, ...]
    n_points: int
    model: TwoBlock = field(repr=False)
    _plot: ClassVar = "cycles.plot_return_region"

    def attracting(self, curve: int) -> tuple[tuple[float, float], ...]:
        """Intervals of the parameter in which the cycles of a curve attract without global stick.

        Their ends are bifurcations on the curve, or ends of the range.
        """
        if not self.curves:
            raise ValueError("curve: this region has none.")
        followed = self.curves[whole_number("curve", curve, 0, at_most=len(self.curves) - 1)]
        holds = np.array([False, *(each.stable and each.d.size == 0 for each in followed), False])
        changes = {item.row: item.value for item in followed.bifurcations}

        def beside(row: int, step: int) -> float:
            return changes.get(row + step, changes.get(row, float(followed.values[row])))

        first = np.flatnonzero(~holds[:-1] & holds[1:]).tolist()
        last = (np.flatnonzero(holds[:-1] & ~holds[1:]) - 1).tolist()
        ends = [(beside(a, -1), beside(b, 1)) for a, b in zip(first, last, strict=True)]
        return tuple((min(pair), max(pair)) for pair in ends)

    def _columns(self) -> dict[str, Any]:
        """Lay out the gaps, a row each."""
        rows = [next(gap.table().rows()) for gaps in self.gaps for gap in gaps]
        others = Gap._column_names[1:]
        names = {free_name(self.parameter, others): "value"} | {name: name for name in others}
        return {name: [row[own] for row in rows] for name, own in names.items()}

    def __repr__(self) -> str:
        """Return a line a value, then the cycles that attract."""
        lines = [f"ReturnRegion: {len(self.values)} values of {self.parameter}"]
        for value, gaps, lost in zip(self.values, self.gaps, self.lost, strict=True):
            shown = sum(gap.shown for gap in gaps)
            told = f"{len(gaps)} gaps, {100 * lost:.3g} % of the domain, {shown} shown"
            lines.append(f"  {value:<12.8g} {told if gaps else 'defined everywhere'}")
        for number, curve in enumerate(self.curves):
            held = self.attracting(number)
            where = ", ".join(f"{low:.12g} .. {high:.12g}" for low, high in held) or "nowhere"
            lines.append(f"  cycle {number}, {len(curve)} computed, attracts at {where}")
        return "\n".join(lines)


@waits
@suggests
def return_region(
    model: TwoBlock,
    parameter: str,
    range: tuple[float, float],
    *,
    n_values: int = 9,
    n_points: int = 201,
    max_events: int = 3000,
) -> ReturnRegion:
    """Find where the event map of two blocks is undefined, and what motions do there.

    Parameters
    ----------
    model : TwoBlock
    parameter : str
        One of ``model.parameters``.
    range : tuple of float
        Lowest and highest value.
    n_values : int
        Equidistant values, the ends among them.
    n_points : int
        Differences tried at each, over the domain.
    max_events : int
        Changes of mode after which a motion is given up (undecided).

    Returns
    -------
    ReturnRegion

    Raises
    ------
    ValueError
        Another kind of model, no such parameter, a range or count that is not allowed.

    Notes
    -----
    What is shown and what is estimated: `TrappingBall`, docs/theory/cycles.md. Gaps narrower than
    a cell of the grid, and cycles whose basins hold no gap's middle, may be missed.

    Examples
    --------
    >>> import stickslip as ss
    >>> region = ss.return_region(ss.examples.coulomb(), "V", (0.03, 0.05), n_values=3, n_points=51)
    >>> region.gaps  # at each of the three values: the map is defined everywhere
    ((), (), ())
    """
    low, high = _checked(model, parameter, range)
    count = whole_number("n_values", n_values, at_most=MOST_KEPT, what="values of the parameter")
    points = whole_number(
        "n_points", n_points, at_most=MOST_KEPT, what="differences tried at each value"
    )
    values = np.linspace(low, high, count)
    curves: list[Curve] = []
    gaps: list[tuple[Gap, ...]] = []
    lost, undecided = np.zeros(count), np.zeros(count)
    for k, value in enumerate(values):
        here = model.replace(**{parameter: float(value)})
        intervals = _intervals(here, points, max_events)
        gaps.append(
            tuple(
                _gap(here, parameter, (low, high), curves, ends, status, max_events)
                for ends, status in intervals
            )
        )
        width = here.domain[1] - here.domain[0]
        for gap in gaps[-1]:
            share = (gap.d[1] - gap.d[0]) / width
            lost[k] += share
            undecided[k] += share if gap.status in UNDECIDED else 0.0
    return ReturnRegion(
        parameter, values, tuple(gaps), lost, undecided, tuple(curves), points, model
    )


def _checked(model: TwoBlock, parameter: str, ends: tuple[float, float]) -> tuple[float, float]:
    two_blocks(
        model,
        why="The plane of d and a parameter is that of two blocks. For more, ask "
        "ss.event_map(model).evaluate(d).status.",
    )
    checked_parameter("parameter", model, parameter)
    low, high = checked_interval("range", ends)
    for end in (low, high):
        model.replace(**{parameter: end})
    return low, high


def _intervals(
    model: TwoBlock, n_points: int, max_events: int
) -> list[tuple[tuple[float, float], int]]:
    """Intervals of d without a return, their edges halved down, and the status inside."""
    f = event_map(model, max_events=max_events)
    grid = np.linspace(*model.domain, max(n_points, 3))
    missing = np.isnan(f(grid))
    first = np.flatnonzero(missing & ~np.append(False, missing[:-1]))
    last = np.flatnonzero(missing & ~np.append(missing[1:], False))
    # From outside to inside of each gap; at an end of the domain both are that end.
    beside = np.concatenate([np.maximum(first - 1, 0), np.minimum(last + 1, len(grid) - 1)])
    outside, inside = grid[beside], np.concatenate([grid[first], grid[last]])
    if not inside.size:
        return []
    inside, _ = halved(lambda d: np.isnan(f(d)), inside, outside, HALVINGS)
    lows, highs = np.split(inside, 2)
    statuses = f.evaluate(0.5 * (lows + highs)).status
    return [
        ((float(a), float(b)), int(status))
        for a, b, status in zip(lows, highs, statuses, strict=True)
    ]


def _gap(
    model: TwoBlock,
    parameter: str,
    ends: tuple[float, float],
    curves: list[Curve],
    d: tuple[float, float],
    status: int,
    max_events: int,
) -> Gap:
    """Find what attracts the motion from the middle of a gap."""
    value = model.parameters[parameter]
    x, v = model.onset(0.5 * (d[0] + d[1])), np.full(2, model.V)
    try:
        cycle = find_cycle(model, x, v, max_events=max_events)
    except NoCycleError:
        return Gap(value, d, status, None, None)
    if cycle.d.size or not any(event.kind == "stick" for event in cycle.events):
        return Gap(value, d, status, None, None)
    number = _known(curves, cycle, value)
    if number is None:
        curves.append(follow_cycle(cycle, parameter, ends))
        number = len(curves) - 1
    ball = trapping_ball(cycle)
    if ball is not None and ball.entered(x, v, max_events=max_events) is None:
        ball = None
    return Gap(value, d, status, number, ball)


def _known(curves: list[Curve], cycle: Cycle, value: float) -> int | None:
    """Find the curve that passes through a cycle, by its period and events."""
    for number, curve in enumerate(curves):
        periods, events = curve.data["period"], curve.data["events"]
        steps = np.flatnonzero((curve.values[:-1] - value) * (curve.values[1:] - value) <= 0.0)
        for row in steps:
            a, b = curve.values[row], curve.values[row + 1]
            share = 0.5 if a == b else (value - a) / (b - a)
            period = (1 - share) * periods[row] + share * periods[row + 1]
            same = len(cycle.events) in (events[row], events[row + 1])
            if same and abs(period - cycle.period) <= SAME_PERIOD * cycle.period:
                return number
    return None
