"""Every periodic orbit of a map of the line, up to a period and a resolution.

Infinitely unstable ones, of the map with its jumps filled in, are known from ends of pieces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, cast, overload

import numpy as np

from stickslip.analysis.branches.discontinuities import Unresolved
from stickslip.analysis.branches.pieces import Pieces, TooManyPiecesError, pieces_of_powers
from stickslip.analysis.branches.table import BranchTable, branch_table
from stickslip.analysis.maps.arguments import line_map, map_of, not_for
from stickslip.analysis.maps.protocol import (
    EXACT,
    SAME,
    Bools,
    Floats,
    Indices,
    Labels,
    Map1D,
    MapND,
    Modelled,
    domain_size,
    sample,
    values_and_slopes,
)
from stickslip.analysis.orbits.diagonal import TOUCH, Brackets, brackets_on_diagonal, forward_orbits
from stickslip.analysis.orbits.newton import ROUNDINGS, Polished, polish
from stickslip.analysis.orbits.orbit import (
    JumpCrossing,
    NearFold,
    OrbitList,
    PeriodicOrbit,
    orbit_of,
    wanted_periods,
)
from stickslip.analysis.orbits.orbits_nd import N_STARTS, OrbitListND, search_orbits
from stickslip.numerics.arrays import EPS
from stickslip.numerics.waiting import doing, waits
from stickslip.numerics.zeros import MAX_ROUNDS
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.branches.laps import Laps

CLEARLY: Final = 8.0  # residuals: images so far apart are of different points
HOLE: Final = "an orbit would pass a gap that the search for branches did not see, in"


@overload
def periodic_orbits(
    f: Map1D | Modelled[Map1D],
    max_period: int = ...,
    *,
    period: int | None = ...,
    infinitely_unstable: bool = ...,
    resolution: float | None = ...,
    n_starts: None = ...,
) -> OrbitList: ...
@overload
def periodic_orbits(
    f: MapND | Modelled[MapND],
    max_period: int = ...,
    *,
    period: int | None = ...,
    infinitely_unstable: bool = ...,
    resolution: None = ...,
    n_starts: int | None = ...,
) -> OrbitListND: ...
@waits
@suggests
def periodic_orbits(
    f: Map1D | MapND | Modelled[Map1D] | Modelled[MapND],
    max_period: int = 1,
    *,
    period: int | None = None,
    infinitely_unstable: bool = False,
    resolution: float | None = None,
    n_starts: int | None = None,
) -> OrbitList | OrbitListND:
    """Find periodic orbits of a map or model, stable and unstable, each once.

    Parameters
    ----------
    f : map or model
    max_period : int
        Minimal periods 1 to this.
    period : int, optional
        Instead: minimal period exactly this.
    infinitely_unstable : bool
        On a line: whether to list orbits of the map with its jumps filled in, too: one point is
        a jump d, its image y any value between f(d-) and f(d+).
    resolution : float, optional
        On a line: of the map's table of `branches`.
    n_starts : int, optional
        In R^n: starts of Newton's method for each period in the first round, 256 by default. As
        many again follow until they find no new orbit and each was found three times, 16 times
        the first round at most.

    Returns
    -------
    OrbitList or OrbitListND
        On a line: complete for every piece of f, ..., f^p whose laps of f are wider than the
        resolution; ``near_folds`` and ``unresolved`` say what could not be decided. In R^n:
        those found from the starts; ``unseen`` estimates how many were not.

    Raises
    ------
    ValueError
        A period or number of starts that is not a whole number >= 1; an option of the other
        kind of map; neither a map nor a model.

    Notes
    -----
    On a line: breakpoints and turning points of f^p come from those of f by inverting one lap
    after another; every piece of f^p between them that meets the diagonal is searched, rising
    ones after splitting them where the slope is 1 (docs/theory/maps.md). In R^n: damped Newton
    steps for all points of an orbit at once, with exact Jacobians.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.2})
    >>> [(orbit.period, orbit.stable) for orbit in ss.periodic_orbits(f, 4)]
    [(1, False), (1, False), (2, True)]
    """
    found = map_of(f)
    if isinstance(found, MapND):
        of_line = {"infinitely_unstable": infinitely_unstable, "resolution": resolution is not None}
        not_for("a line", **of_line)
        return search_orbits(found, max_period, period, N_STARTS if n_starts is None else n_starts)
    f = line_map(found)
    not_for("R^n", n_starts=n_starts is not None)
    wanted = wanted_periods(max_period, period)
    table = branch_table(f, resolution)
    search = _Search(table)
    for p, pieces in search.powers(wanted[-1], closed=not infinitely_unstable):
        if p in wanted:
            search.add_orbits(pieces)
            if infinitely_unstable:
                search.add_jump_orbits(pieces)
    return search.result(wanted[-1])


def jump_orbits(table: BranchTable, max_period: int) -> list[PeriodicOrbit]:
    """Find the infinitely unstable orbits alone, up to a period."""
    search = _Search(table)
    for _, pieces in search.powers(max_period, closed=False):
        search.add_jump_orbits(pieces)
    return search.orbits


@dataclass(frozen=True)
class _Counted:
    """A map that counts its evaluations."""

    f: Map1D
    count: list[int] = field(default_factory=lambda: [0])

    @property
    def domain(self) -> tuple[float, float]:
        return self.f.domain

    def value_and_derivative(self, x: Floats) -> tuple[Floats, Floats]:
        """Values and slopes, all that laps ask for."""
        self.count[0] += np.size(x)
        return values_and_slopes(self.f, x)


class _Search:
    """Orbits found so far, and what stayed open."""

    def __init__(self, table: BranchTable) -> None:
        self.table = table
        self.counted = cast("Any", _Counted(table.f))
        # Cut at harmless breakpoints, too: across them slopes bend, and no cubic foretells that.
        self.laps: Laps = replace(table.pieces, f=self.counted)
        self.scale = domain_size(table.f)
        self.orbits: list[PeriodicOrbit] = []
        self.near_folds: list[NearFold] = []
        self.unresolved: list[Unresolved] = list(table.unresolved)
        self.complete = 0

    def powers(self, highest: int, *, closed: bool) -> Any:
        """Yield (p, pieces of f^p) as far as they can be followed."""
        try:
            for pieces in pieces_of_powers(self.laps, highest, closed=closed):
                doing(f"orbits of period {pieces.power} of {highest}")
                self.complete = pieces.power
                yield pieces.power, pieces
        except TooManyPiecesError as reason:
            lo, hi = self.table.f.domain
            self.unresolved.append(Unresolved(f"{reason}:", lo, hi, self.complete + 1))
        finally:
            doing("")

    def result(self, highest: int) -> OrbitList:
        """Return the list, by period and place."""
        order = sorted(self.orbits, key=lambda orbit: (orbit.period, orbit.points[0]))
        return OrbitList(
            orbits=tuple(order),
            max_period=highest,
            resolution=self.table.resolution,
            near_folds=tuple(self.near_folds),
            unresolved=tuple(self.unresolved),
            complete=self.complete,
            n_evaluations=self.counted.count[0],
        )

    # ------------------------------------------------------------------ ordinary orbits

    def add_orbits(self, pieces: Pieces) -> None:
        """Add all orbits of one minimal period."""
        brackets, near_folds = brackets_on_diagonal(pieces, self.table.resolution)
        self.near_folds += near_folds
        brackets, found = self._solved(brackets)
        error = np.where(np.isfinite(found.error), found.error, 0.0)
        slack = 4 * error + EXACT * self.scale
        minimal = ~found.repeats(slack)
        brackets, found, slack = brackets.take(minimal), found.take(minimal), slack[minimal]
        close = np.minimum(slack, SAME * self.scale)
        clear = self._clear_of_roots(brackets, found)
        for k in self._distinct(found):
            if not self._is_on_border(brackets.word[k], found.points[k], close[k], clear[k]):
                self.orbits.append(self._orbit(brackets, found, k))

    def _solved(self, brackets: Brackets) -> tuple[Brackets, Polished]:
        """Solve each bracket: Newton from a guess by inverse branches, else after halving."""
        found = self._polished(brackets, self._guess(brackets))
        failed = self._failed(brackets, found)
        if failed.size:
            wide = brackets.take(failed)
            shrunk, lost = self._shrunk(wide)
            better = self._polished(shrunk, 0.5 * (shrunk.left + shrunk.right)[:, :-1])
            # Images of adjacent floats are too far apart where slopes are as steep as beside a
            # logarithm, but inverse ones are as close as can be.
            lines = self._failed(shrunk, better)
            wide, middle = wide.take(lines), 0.5 * (shrunk.left + shrunk.right)[lines, 0]
            back = self._polished(wide, self._back(wide, middle, self.laps.inverse))
            good = np.setdiff1d(np.arange(len(lines)), self._failed(wide, back))
            better.put(lines[good], back.take(good))
            found.put(failed, better)
            for k in np.flatnonzero(lost):
                lo, hi = float(shrunk.left[k, 0]), float(shrunk.right[k, 0])
                self.unresolved.append(Unresolved(HOLE, lo, hi, found.points.shape[1]))
            kept = np.delete(np.arange(len(brackets)), failed[lost])
            brackets, found = brackets.take(kept), found.take(kept)
        return brackets, found

    def _failed(self, brackets: Brackets, found: Polished) -> Indices:
        failed = ~found.converged | self._are_beyond(brackets, found.points)
        return np.flatnonzero(failed | ~self._clear_of_roots(brackets, found).all(axis=1))

    def _clear_of_roots(self, brackets: Brackets, found: Polished) -> Bools:
        """Tell which points are no root-like ends of laps that they are close to, (n, p).

        Beside a square root images tell points apart that differ by less than rounding.
        """
        laps, word, clear = self.laps, brackets.word, np.ones(found.points.shape, dtype=np.bool_)
        images = np.roll(found.points, -1, axis=1)
        for end, value, slope in (
            (laps.left, laps.value_left, laps.slope_left),
            (laps.right, laps.value_right, laps.slope_right),
        ):
            close = np.abs(found.points - end[word]) <= SAME * self.scale
            told = np.abs(images - value[word]) > CLEARLY * found.off
            clear &= told | ~(close & np.isinf(slope[word]))
        return clear

    def _are_beyond(self, brackets: Brackets, points: Floats) -> Bools:
        """Tell which points lie beyond an end that is clearly off the orbit inside.

        Beyond a square root a lap goes on so steeply that anything is solved there.
        """
        inward = np.sign(brackets.right - brackets.left)[:, :-1]
        touch = TOUCH * self.scale
        beyond = np.zeros(len(points), dtype=np.bool_)
        for end, off, side in (
            (brackets.left, brackets.off_left, inward),
            (brackets.right, brackets.off_right, -inward),
        ):
            beside = ROUNDINGS * np.spacing(np.abs(end[:, :-1]))  # where pieces are as narrow
            out = (side * (points - end[:, :-1]) < -beside).any(axis=1)
            beyond |= out & (np.abs(off) > touch)
        return beyond

    def _guess(self, brackets: Brackets) -> Floats:
        """Go once back around the orbit: that divides the middle's error by the multiplier."""
        bottom = np.minimum(brackets.left, brackets.right)
        top = np.maximum(brackets.left, brackets.right)
        low = np.maximum(bottom[:, 0], bottom[:, -1])
        high = np.minimum(top[:, 0], top[:, -1])
        return self._back(brackets, 0.5 * (low + high), self.laps.near_inverse)

    def _back(
        self, brackets: Brackets, x: Floats, inverse: Callable[[Indices, Floats], Floats]
    ) -> Floats:
        """Go back around orbits from their first points, within brackets."""
        word = brackets.word
        bottom = np.minimum(brackets.left, brackets.right)
        top = np.maximum(brackets.left, brackets.right)
        x = np.clip(x, bottom[:, -1], top[:, -1])
        points = np.empty(word.shape)
        for k in range(word.shape[1] - 1, -1, -1):
            x = np.clip(inverse(word[:, k], x), bottom[:, k], top[:, k])
            points[:, k] = x
        return points

    def _polished(self, brackets: Brackets, points: Floats) -> Polished:
        lap = brackets.word.ravel()
        slack = EXACT * self.scale
        lo, hi = self.table.f.domain
        lower = np.maximum(np.minimum(brackets.left, brackets.right)[:, :-1] - slack, lo)
        upper = np.minimum(np.maximum(brackets.left, brackets.right)[:, :-1] + slack, hi)

        def evaluate(k: Indices, x: Floats) -> tuple[Floats, Floats, Labels]:
            return *self.laps.evaluate(lap[k], x), np.zeros(len(k), dtype=np.uint64)

        return polish(evaluate, points, lower, upper, self.scale)

    def _shrunk(self, brackets: Brackets) -> tuple[Brackets, Bools]:
        """Halve brackets down to adjacent floats, or to a middle whose orbit has no value."""
        left, right = brackets.left.copy(), brackets.right.copy()
        lost = np.zeros(len(left), dtype=np.bool_)
        rises = brackets.off_right >= brackets.off_left
        for _ in range(MAX_ROUNDS):
            x = 0.5 * (left[:, 0] + right[:, 0])
            orbit, _ = forward_orbits(self.laps, brackets.word, x, left, right)
            lost |= np.isnan(orbit).any(axis=1)
            beyond, kept = ((orbit[:, -1] >= x) == rises)[:, None], lost[:, None]
            left = np.where(beyond | kept, left, orbit)
            right = np.where(beyond & ~kept, orbit, right)
        return replace(brackets, left=left, right=right), lost

    def _distinct(self, found: Polished) -> Indices:
        """Choose orbits that are not another one once more."""
        (n, p), error = found.points.shape, found.error.max(axis=1, initial=0.0)
        turns = np.argmin(found.points, axis=1)[:, None] + np.arange(p)  # the smallest point first
        points = found.points[np.arange(n)[:, None], turns % p]
        order = np.argsort(points[:, 0], kind="stable")
        kept: list[int] = []
        for k in order:
            slack = 2 * (error[k] if np.isfinite(error[k]) else 0.0) + EXACT * self.scale
            for j in reversed(kept):
                if points[k, 0] - points[j, 0] > slack:
                    kept.append(int(k))
                    break
                if np.abs(points[k] - points[j]).max() <= slack:
                    break
            else:
                kept.append(int(k))
        return np.array(kept, dtype=np.intp)

    # ------------------------------------------------------------------ as results

    def _is_on_border(self, word: Indices, points: Floats, close: Floats, clear: Bools) -> bool:
        """Report orbits that touch a break; tell if it is one that no orbit survives."""
        period, laps = len(points), self.laps
        rows = zip(word, points.tolist(), close.tolist(), clear.tolist(), strict=True)
        for lap, x, slack, off_root in rows:
            for number, slope in (
                (laps.end_left[lap], laps.slope_left[lap]),
                (laps.end_right[lap], laps.slope_right[lap]),
            ):
                if not self.table.matters(number) or (off_root and np.isinf(slope)):
                    continue
                item = self.table.breakpoints[number]
                lo, hi = item.interval
                if not lo - slack <= x <= hi + slack:
                    continue
                reason = f"an orbit point is on the {item.kind}"
                self.unresolved.append(Unresolved(reason, x, x, period, abs(x - item.d)))
                # Within a break that is not located a lap is no more than a guess.
                if item.kind != "corner" or item.quality != "located":
                    return True
        return False

    def _orbit(self, brackets: Brackets, found: Polished, k: int) -> PeriodicOrbit:
        labels = self.table.labels_at(found.points[k])
        ends = np.stack([brackets.left[k, :-1], brackets.right[k, :-1]], axis=1)
        located = bool(found.converged[k])
        return orbit_of(
            self.table.f,
            found.points[k],
            labels,
            multiplier=float(found.slopes[k].prod()),
            error=found.error[k],
            interval=None if located else np.sort(ends),
            texts=[self.table.text(int(label)) for label in labels],
            residual=float(found.residual[k]),
            quality="located" if located else "bracketed",
        )

    def add_jump_orbits(self, pieces: Pieces) -> None:
        """Add all infinitely unstable orbits of one period, but for those on an end of a jump."""
        table, slack = self.table, SAME * self.scale
        crossings: list[tuple[Breakpoint, Floats, Indices]] = []
        for number, jump in enumerate(table.breakpoints):
            if jump.kind != "jump":
                continue
            low, high = sorted((jump.left, jump.right))
            for path, word in _ways_to(pieces, number, slack):
                if min(abs(path[0] - low), abs(path[0] - high)) <= slack:
                    reason = "an orbit is on an end of the jump"
                    self.unresolved.append(Unresolved(reason, jump.d, jump.d, len(path)))
                elif low < path[0] < high:
                    crossings.append((jump, path, word))
        # All points in the map's order, the jump first, evaluated together.
        points = np.array([np.roll(path, 1) for _, path, _ in crossings])
        values = sample(table.f, points.reshape(len(crossings), pieces.power)[:, 1:])
        self.orbits += [
            _orbit(table, *crossing, values.value[k], values.derivative[k])
            for k, crossing in enumerate(crossings)
        ]


def _ways_to(pieces: Pieces, number: int, slack: float) -> list[tuple[Floats, Indices]]:
    """Orbits of p points that end on a break, and the laps of all points but the last."""
    p = pieces.power
    found: list[tuple[Floats, Indices]] = []
    for ends in (pieces.left, pieces.right):
        for k in np.flatnonzero((ends.number == number) & (ends.depth == p - 1)):
            found.append((ends.orbit[k, :p], pieces.word[k, : p - 1]))
    found.sort(key=lambda way: float(way[0][0]))
    # Two neighbouring pieces share each end.
    return [
        way
        for k, way in enumerate(found)
        if k == 0 or float(way[0][0] - found[k - 1][0][0]) > slack
    ]


def _orbit(
    table: BranchTable,
    jump: Breakpoint,
    path: Floats,
    word: Indices,
    images: Floats,
    slopes: Floats,
) -> PeriodicOrbit:
    """Describe the orbit d, y, f(y), ..., with f of its last point d."""
    points = np.roll(path, 1)
    residual = np.abs(images - np.roll(points, -1)[1:])
    error = _errors(slopes, residual, ROUNDINGS * EPS * domain_size(table.f))
    labels = table.labels_at(points)
    texts = [table.text(int(label)) for label in labels]
    texts[0] = f"{table.text(jump.left_label)} | {table.text(jump.right_label)}"
    crossing = JumpCrossing(
        d=jump.d,
        y=float(path[0]),
        share=float((path[0] - jump.left) / (jump.right - jump.left)),
        rising=bool((jump.right > jump.left) == (table.pieces.direction[word].prod() > 0)),
    )
    return orbit_of(
        table.f,
        points,
        labels,
        multiplier=math.inf,
        error=error,
        texts=texts,
        residual=float(residual.max(initial=0.0)),
        jump=crossing,
    )


def _errors(slopes: Floats, residual: Floats, rounding: float) -> Floats:
    """Errors of the points, from the jump backwards: each map divides by its slope."""
    error = np.zeros(len(slopes) + 1)
    error[0] = after = rounding
    for k in range(len(slopes) - 1, -1, -1):
        after = (after + residual[k] + rounding) / abs(slopes[k]) if slopes[k] != 0 else math.inf
        error[k + 1] = after
    return error
