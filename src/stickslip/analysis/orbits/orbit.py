"""Periodic orbits of a map: what is known of each, and lists of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeVar

import numpy as np

from stickslip.analysis.maps.protocol import SAME
from stickslip.checks import MOST_KEPT, whole_number
from stickslip.results.parts import part
from stickslip.results.result import Result, ResultList
from stickslip.results.table import more

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from stickslip.analysis.branches.discontinuities import Unresolved
    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D

SHOWN: Final = 24  # orbits in a list's repr


Orbit = TypeVar("Orbit", bound="AnyOrbit")


def wanted_periods(max_period: object, period: object) -> range:
    """Return the minimal periods that are asked for: up to one, or exactly that one."""
    if period is None:
        return range(1, whole_number("max_period", max_period, at_most=MOST_KEPT) + 1)
    p = whole_number("period", period, at_most=MOST_KEPT)
    return range(p, p + 1)


@part
@dataclass(frozen=True)
class JumpCrossing:
    """Where an infinitely unstable orbit crosses a jump of the map.

    Attributes
    ----------
    d : float
        The jump, a point of the orbit.
    y : float
        Its image, a value that the filled-in jump takes on.
    share : float
        Place of y in the jump: 0 at f(d-), 1 at f(d+).
    rising : bool
        Whether the p-th power of the filled-in map rises across d: then points on either
        side move away from the orbit, else they hop across it.
    """

    d: float
    y: float
    share: float
    rising: bool


class AnyOrbit(Result):
    """What orbits of maps of any dimension have in common."""

    period: int
    stable: bool

    def _kind(self, multipliers: Any) -> str:
        """``stable``, ``unstable``, or ``neutral``: multipliers on the unit circle tell neither."""
        outermost = float(np.max(np.abs(multipliers), initial=0.0))
        if abs(outermost - 1.0) <= SAME:
            return "neutral"
        return "stable" if self.stable else "unstable"


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbit(AnyOrbit):
    """A periodic orbit of a map.

    Attributes
    ----------
    points : ndarray of float, shape (period,)
        In the map's order, the smallest first.
    period : int
        Minimal.
    multiplier : float
        Derivative of the period-th power of the map at the orbit: product of exact
        derivatives. Infinite for an infinitely unstable orbit.
    stable : bool
        The multiplier is inside (-1, 1). On its ends an orbit may attract all the same: `kind`
        is then ``neutral``.
    itinerary : tuple of str, length period
        What the map says of each point's branch: its own text if it has one, else the label.
    labels : ndarray of uint64, shape (period,)
    quality : str
        ``located``: Newton's method converged inside the bracket. ``bracketed``: only the
        interval is known.
    interval : ndarray of float, shape (period, 2)
        Contains the points: from the residuals and the map's rounding.
    residual : float
        Largest abs(f(x_i) - x_(i+1)).
    jump : JumpCrossing or None
        For an infinitely unstable orbit.
    system : map or None
        The map that it is an orbit of; None if it was loaded without.
    """

    points: Floats
    period: int
    multiplier: float
    stable: bool
    itinerary: tuple[str, ...]
    labels: Labels = field(repr=False)
    quality: str
    interval: Floats
    residual: float
    jump: JumpCrossing | None = None
    system: Map1D | None = field(default=None, repr=False, compare=False)
    _plot: ClassVar = "orbits.draw_orbit"

    @property
    def infinitely_unstable(self) -> bool:
        """Whether the orbit crosses a jump."""
        return self.jump is not None

    def __repr__(self) -> str:
        """Period, multiplier and points in one line, the crossing of a jump in a second."""
        points = ", ".join(f"{x:.12g}" for x in self.points)
        facts = f"period {self.period}, multiplier {self.multiplier:.10g}, {self.kind}"
        text = f"PeriodicOrbit({facts}: {points})"
        if self.jump is None:
            return text
        d, y, share = self.jump.d, self.jump.y, self.jump.share
        return f"{text}\n  crosses the jump d = {d:.15g} at y = {y:.15g}, share {share:.10g}"

    @property
    def kind(self) -> str:
        """``stable``, ``neutral``, ``unstable`` or ``infinitely unstable``."""
        return "infinitely unstable" if self.jump is not None else self._kind(self.multiplier)

    def _columns(self) -> dict[str, Any]:
        return {
            "period": np.repeat(self.period, self.period),
            "kind": np.repeat(self.kind, self.period),
            "multiplier": np.repeat(self.multiplier, self.period),
            "point": np.arange(self.period) + 1,
            "d": self.points,
            "error": 0.5 * (self.interval[:, 1] - self.interval[:, 0]),
            "itinerary": np.array(self.itinerary),
        }


def orbit_of(
    f: Map1D,
    points: Floats,
    labels: Labels,
    *,
    multiplier: float,
    error: ArrayLike = 0.0,
    interval: Floats | None = None,
    texts: Sequence[str] | None = None,
    **known: Any,
) -> PeriodicOrbit:
    """Describe an orbit of a map from its points in any turn; rows are turned with them."""
    start = int(np.argmin(points))
    if interval is None:
        interval = points[:, None] + np.multiply.outer(error, [-1.0, 1.0])
    points, labels = np.roll(points, -start), np.roll(labels, -start)
    if texts is None:  # the map's own if it has any: one for each label, as each takes a motion
        described, where, which = np.unique(labels, return_index=True, return_inverse=True)
        describe = getattr(f, "itinerary", None)
        told = described.tolist() if describe is None else map(describe, points[where].tolist())
        texts = np.array([*map(str, told)])[which].tolist()
    else:
        texts = [*texts[start:], *texts[:start]]
    return PeriodicOrbit(
        points=points,
        period=len(points),
        multiplier=multiplier,
        stable=known.pop("stable", abs(multiplier) < 1),
        itinerary=tuple(map(str, texts)),
        labels=labels,
        quality=known.pop("quality", "located"),
        interval=np.roll(interval, -start, axis=0),
        system=f,
        **known,
    )


@part
@dataclass(frozen=True)
class NearFold:
    """A piece of f^p that all but touches the diagonal: two orbits about to be born, or lost.

    Attributes
    ----------
    period : int
        The p; a divisor of it may be the orbits' minimal period.
    x : float
        Where f^p comes closest to the diagonal.
    distance : float
        abs(f^p(x) - x).
    resolved : bool
        Whether it is settled that there is no orbit; if not, there are none or two, or
        f^p runs along the diagonal.
    """

    period: int
    x: float
    distance: float
    resolved: bool


class OrbitSequence(ResultList[Orbit]):
    """Periodic orbits, a sequence: its ``orbits``."""

    orbits: tuple[Orbit, ...]
    _of: ClassVar = "orbits"

    @property
    def stable(self) -> tuple[Orbit, ...]:
        """Those with all multipliers inside the unit circle."""
        return tuple(orbit for orbit in self.orbits if orbit.stable)

    def of_period(self, p: int) -> tuple[Orbit, ...]:
        """Those of minimal period p."""
        p = whole_number("p", p)
        return tuple(orbit for orbit in self.orbits if orbit.period == p)


@dataclass(frozen=True, eq=False, repr=False)
class OrbitList(OrbitSequence[PeriodicOrbit]):
    """All periodic orbits up to a period: a sequence with what stayed open.

    Attributes
    ----------
    orbits : tuple of PeriodicOrbit
        By period, then by smallest point.
    max_period : int
    resolution : float
        Pieces of the map narrower than this may have been missed.
    near_folds : tuple of NearFold
    unresolved : tuple of Unresolved
        What could not be decided, with reasons.
    complete : int
        Highest period up to which the list is complete above the resolution.
    n_evaluations : int
        Evaluations of the map, without those for its table of branches.
    """

    orbits: tuple[PeriodicOrbit, ...]
    max_period: int
    resolution: float
    near_folds: tuple[NearFold, ...]
    unresolved: tuple[Unresolved, ...]
    complete: int
    n_evaluations: int
    _number: ClassVar = "orbit"
    _column_names: ClassVar = (
        *("period", "kind", "multiplier", "point"),
        *("d", "error", "itinerary"),
    )
    _plot: ClassVar = "orbits.draw_orbits"

    def __repr__(self) -> str:
        """Table of the orbits, then what stayed open."""
        lines = [
            f"OrbitList: {len(self)} orbits up to period {self.max_period}, complete to period "
            f"{self.complete} for pieces wider than {self.resolution:.2g}",
            "  period      multiplier  kind                 points",
        ]
        for orbit in self.orbits[:SHOWN]:
            points = ", ".join(f"{x:.10g}" for x in orbit.points)
            lines.append(
                f"  {orbit.period:6d}  {orbit.multiplier:14.8g}  {orbit.kind:19s}  {points}"
            )
        lines += more(len(self), SHOWN)
        for near in self.near_folds:
            settled = "no orbit" if near.resolved else "none, two or a whole interval of them"
            lines.append(
                f"  near-fold of period {near.period} at {near.x:.12g}, "
                f"distance {near.distance:.2g}: {settled}"
            )
        lines += [f"  unresolved: {item}" for item in self.unresolved]
        return "\n".join(lines)
