"""Bifurcations of a family of maps: what is known of each, lists of them, cascades of flips."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Final,
    Literal,
    NamedTuple,
    TypeAlias,
    TypeVar,
    get_args,
)

import numpy as np

from stickslip.analysis.bifurcations.outcome import Outcome, disagreement
from stickslip.analysis.scales import LISTED
from stickslip.checks import one_of
from stickslip.results.parts import part
from stickslip.results.result import Result, ResultList
from stickslip.results.table import SHOWN, listed, more

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.bifurcations.conditions.locate import Located
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.analysis.maps.protocol import FamilyND, Floats, MapFamily

T = TypeVar("T")

BifurcationKind: TypeAlias = Literal[
    "fold",
    "flip",
    "neimark_sacker",
    "transcritical",
    "pitchfork",
    "border_collision",
    "boundary_crisis",
    "interior_crisis",
    "band_merging",
    "enters_gap",
    "attractor_change",
]
BIFURCATION_KINDS: Final[tuple[str, ...]] = get_args(BifurcationKind)

OUTSIDE: Final = "outside the question"  # reasons that begin so leave nothing open
POINTS_SHOWN: Final = 2  # of an orbit, in a line of a table


@dataclass(frozen=True, eq=False, repr=False)
class Bifurcation(Result):
    """A parameter value at which orbits or attractors of a map are born, lost or changed.

    Attributes
    ----------
    kind : str
        ``fold``, ``flip``, ``transcritical``, ``pitchfork``, ``border_collision``,
        ``boundary_crisis``, ``interior_crisis``, ``band_merging`` or ``enters_gap``. Of maps of
        R^n also ``neimark_sacker``, and ``attractor_change``: what attracts is not the same below
        and above, and no bifurcation of a followed orbit is there.
    parameter : str
        Name of the parameter that is varied.
    value : float
        Where it happens, and ...
    error : float
        ... how far off that may be: residual and rounding through the test function's slope.
    period : int
        Of the orbit concerned; the shortest, if several meet; 0 where chaos meets a break.
    points : ndarray of float, shape (period,), in R^n (period, n)
        The orbit there, in the map's order, the smallest point first; for a crisis, the
        orbit that the attractor meets, or the break or end of the domain.
    criticality : {"super", "sub"} or None
        Of a flip, a pitchfork or a Neimark-Sacker bifurcation.
    orbits_before, orbits_after : tuple of PeriodicOrbit
        The orbits concerned just below and just above `value`, those that persist included.
    attractors_before, attractors_after : tuple of Attractor
        All attractors inside the window just below and just above, ...
    looks : tuple of float
        ... which is at these two values of the parameter; NaN where nobody looked. What the map
        does between them besides, as cycles above the longest period searched may, shows, too.
    outcome, predicted_outcome : Outcome or None
        What becomes of orbits and attractors, seen from below to above: as observed, and as
        the map's slopes and values at the border foretell it.
    mechanism : str
        What happens there, for who knows what the map stands for; empty here.
    block : int or None
        Block that the mechanism concerns.
    quality : str
        ``located``, ``bracketed`` or ``failed``.
    interval : tuple of float
        Parameter values that enclose it.
    residual : float
        Test function at `value`.
    condition : object
        What is solved (`bifurcations.conditions.conditions`): starts two-parameter curves.
    multipliers : tuple of float, or in R^n ndarray of complex
        Of f^p there, all in R^n; for a border collision the one-sided ones, left and right of the
        border.
    in_cascade : bool
        Whether it was found by following a cascade, beyond the longest period searched.
    note : str
        What else is to be said; empty if nothing.
    system : map or None
        The family of maps; None if it was loaded without.
    """

    kind: BifurcationKind
    parameter: str
    value: float
    error: float
    period: int
    points: Floats
    criticality: Literal["super", "sub"] | None = None
    orbits_before: tuple[Any, ...] = ()
    orbits_after: tuple[Any, ...] = ()
    attractors_before: tuple[Any, ...] = ()
    attractors_after: tuple[Any, ...] = ()
    looks: tuple[float, float] = (math.nan, math.nan)
    outcome: Outcome | None = None
    predicted_outcome: Outcome | None = None
    mechanism: str = ""
    block: int | None = None
    quality: str = "located"
    interval: tuple[float, float] = (math.nan, math.nan)
    residual: float = math.nan
    condition: Any = None
    multipliers: Any = ()
    in_cascade: bool = False
    note: str = ""
    system: MapFamily | FamilyND | None = field(default=None, repr=False, compare=False)
    _column_names: ClassVar = (
        *("kind", "criticality", "parameter", "value", "error", "period", "points"),
        *("multipliers", "orbits_before", "orbits_after", "attractors_before"),
        *("attractors_after", "outcome", "predicted_outcome", "mechanism", "block"),
        *("quality", "in_cascade", "note"),
    )
    _plot: ClassVar = "bifurcations.draw_bifurcation"

    @property
    def born(self) -> int:
        """How many orbits more there are above `value` than below, of those concerned."""
        return len(self.orbits_after) - len(self.orbits_before)

    @property
    def disagreement(self) -> str:
        """In what the outcomes predicted and observed differ; empty if in nothing."""
        theory, seen = self.predicted_outcome, self.outcome
        return "" if theory is None or seen is None else disagreement(theory, seen)

    def __repr__(self) -> str:
        """Where, what, which orbits and attractors, and why: a few short lines."""
        points = listed((place(x, 12) for x in self.points), LISTED)
        critical = f"{self.criticality}critical " if self.criticality else ""
        lines = [
            f"Bifurcation({critical}{self.kind.replace('_', ' ')} of period {self.period} at "
            f"{self.parameter} = {self.value:.15g} ± {self.error:.1g}: {points})"
        ]
        lines.append(f"  orbits:     {_kinds(self.orbits_before)}  ->  {_kinds(self.orbits_after)}")
        if self.attractors_before or self.attractors_after:
            before, after = self.attractors_before, self.attractors_after
            seen = f"{_kinds(before)}  ->  {_kinds(after)}"
            below, above = self.looks
            looked = "" if math.isnan(below + above) else f"  (at {below:.9g} and {above:.9g})"
            lines.append(f"  attractors: {seen}{looked}")
        if self.outcome is not None:
            lines.append(f"  outcome:    {_outcome(self.outcome)}")
        if self.predicted_outcome is not None:
            lines.append(f"  predicted:  {_outcome(self.predicted_outcome)}")
        if self.disagreement:
            lines.append(f"  they differ in {self.disagreement}")
        lines += [f"  {text}" for text in (self.mechanism, self.note) if text]
        return "\n".join(lines)

    def row(self) -> dict[str, Any]:
        """Return the facts that fit into a line of a table, as plain values by name."""
        return {
            **{name: getattr(self, name) for name in self._column_names},
            "points": self.points.tolist(),
            "multipliers": list(self.multipliers),
            "orbits_before": len(self.orbits_before),
            "orbits_after": len(self.orbits_after),
            "attractors_before": len(self.attractors_before),
            "attractors_after": len(self.attractors_after),
            "outcome": _outcome(self.outcome),
            "predicted_outcome": _outcome(self.predicted_outcome),
        }

    def _columns(self) -> dict[str, Any]:
        return {name: [cell] for name, cell in self.row().items()}


def bifurcation_of(
    kind: BifurcationKind, found: Located, parameter: str, system: MapFamily | None, **more: Any
) -> Bifurcation:
    """Describe a condition that was solved for."""
    reading = found.reading
    points, value, error = np.array(reading.points), float(found.value), float(found.error)
    return Bifurcation(
        kind=kind,
        parameter=parameter,
        value=value,
        error=error,
        period=reading.condition.period,
        points=np.roll(points, -int(np.argmin(points))),
        quality=found.quality,
        interval=(value - error, value + error),
        residual=float(found.residual),
        condition=reading.condition,
        multipliers=reading.multipliers,
        system=system,
        **more,
    )


@part
@dataclass(frozen=True)
class UnresolvedChange:
    """A change between two parameter values that no located bifurcation explains.

    Attributes
    ----------
    reason : str
        A sentence.
    lo, hi : float
        Parameter values between which it happens.
    period : int
        Of the orbits in question; 0 where it does not matter.
    x : float
        A point of the orbit in question; NaN where there is none.
    """

    reason: str
    lo: float
    hi: float
    period: int = 0
    x: float = math.nan

    @property
    def is_outside(self) -> bool:
        """Whether it is no part of what was asked for, or is finer than lists are."""
        return self.reason.startswith(OUTSIDE)

    def __str__(self) -> str:
        """One line."""
        where = f"between {self.lo:.12g} and {self.hi:.12g}"
        orbit = f", period {self.period} near {self.x:.10g}" if self.period else ""
        return f"{where}{orbit}: {self.reason}"


def joined_where_they_touch(changes: Iterable[UnresolvedChange]) -> list[UnresolvedChange]:
    """Make one entry of those that have one reason and whose intervals touch."""
    found: list[UnresolvedChange] = []
    for item in sorted(changes, key=lambda item: (item.reason, item.lo)):
        if found and found[-1].reason == item.reason and item.lo <= found[-1].hi:
            last = found.pop()
            item = UnresolvedChange(item.reason, last.lo, max(last.hi, item.hi))
        found.append(item)
    return found


@dataclass(frozen=True, eq=False, repr=False)
class Cascade(Result):
    """Flips that double an orbit's period again and again.

    Attributes
    ----------
    flips : tuple of Bifurcation
        In their order; the period doubles from each to the next.
    accumulation : float
        Parameter value that they accumulate at, extrapolated; NaN for fewer than three flips.
    error : float
        Of the accumulation: difference of the last two extrapolations.
    ratios : ndarray of float, shape (n - 2,)
        Of successive gaps between flips; they tend to 4.669201609 where the map's turning
        point is quadratic.
    """

    flips: tuple[Bifurcation, ...]
    accumulation: float
    error: float
    ratios: Floats
    _drawn: ClassVar = ("period", "value")

    @property
    def values(self) -> tuple[float, ...]:
        """Parameter values of the flips."""
        return tuple(flip.value for flip in self.flips)

    @property
    def where(self) -> str:
        """Say where the flips accumulate, as far as that is known."""
        if math.isnan(self.accumulation):
            return "too few inside the range to tell where they accumulate"
        return f"accumulation at {self.accumulation:.13g} ± {self.error:.1g}"

    def __repr__(self) -> str:
        """Accumulation, then the flips with their ratios."""
        name = self.flips[0].parameter
        lines = [
            f"Cascade: {len(self.flips)} flips along {name}, {self.where}",
            "  period  value                ratio",
        ]
        # The ratio stands beside the flip that ends its second gap.
        ratios = ["", "", *(f"{ratio:.8g}" for ratio in self.ratios)]
        for flip, ratio in zip(self.flips, ratios, strict=False):
            lines.append(f"  {flip.period:6d}  {flip.value:<19.15g}  {ratio}".rstrip())
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        missing = np.full(len(self.flips) - len(self.ratios), np.nan)
        return {
            "period": [flip.period for flip in self.flips],
            "value": np.array(self.values),
            "ratio": np.append(missing, self.ratios),
        }


@part
class Coverage(NamedTuple):
    """How much of the orbits in R^n lists at values of a parameter have shown.

    Attributes
    ----------
    n_lists : int
    n_starts : int
        Seeds of each list's first round, as of `periodic_orbits`.
    known : int
        Orbits through which curves pass at the values of the last half of the lists, which lie
        between those of the first half, ...
    again : int
        ... those of them that these lists found, too, ...
    new : int
        ... and what they found beside them.
    """

    n_lists: int
    n_starts: int
    known: int
    again: int
    new: int

    @property
    def share(self) -> float:
        """Share of the known orbits that lists found; NaN of none.

        Where it is small, many are missing of those that only lists can show.
        """
        return self.again / self.known if self.known else math.nan

    def __str__(self) -> str:
        """One line."""
        head = f"orbits from {self.n_lists} lists of {self.n_starts} starts"
        if self.n_lists < 2:
            return f"{head}: how many are missing is not known"
        return (
            f"{head}: the last half found {self.again} of {self.known} orbits again and {self.new} "
            "new ones; others may be missing (raise n_lists, n_starts)"
        )


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationList(ResultList[Bifurcation]):
    """All bifurcations over a range of a parameter, by value, and what lies between them.

    In R^n all that were found: `coverage` tells how many orbits may be missing.

    Attributes
    ----------
    bifurcations : tuple of Bifurcation
        Also reached by indexing and iteration.
    parameter : str
    range : tuple of float
        Ends of the parameter's range.
    parameters : dict
        Values of all parameters of the system; the varied one's is that of the system given.
    max_period : int
        Longest period of the orbits that were searched.
    window : tuple of float or None
        The part of the map's domain that was searched; None for all of it.
    curves : tuple of Curve
        The orbits between the bifurcations.
    cascades : tuple of Cascade
    unresolved : tuple of UnresolvedChange
        Changes that no located bifurcation explains; docs/theory/completeness.md lists the kinds.
    outside : tuple of UnresolvedChange
        Where cycles above `max_period`, chaos or undecided motions attract: what becomes of such
        cycles there was not asked for. And what is finer than lists resolve.
    n_lists : int
        Parameter values at which complete lists of orbits were made.
    coverage : Coverage or None
        In R^n, where lists need not be complete, how many known orbits they found again.
    looks : tuple of float
        Parameter values at which the attractors were looked at, ascending: a cycle above
        `max_period` that is born and lost between two of them is not seen.
    """

    bifurcations: tuple[Bifurcation, ...]
    parameter: str
    range: tuple[float, float]
    parameters: dict[str, float]
    max_period: int
    window: tuple[float, float] | None = None
    curves: tuple[Curve, ...] = ()
    cascades: tuple[Cascade, ...] = ()
    unresolved: tuple[UnresolvedChange, ...] = ()
    outside: tuple[UnresolvedChange, ...] = ()
    n_lists: int = 0
    coverage: Coverage | None = None
    looks: tuple[float, ...] = ()
    _column_names: ClassVar = Bifurcation._column_names
    _plot: ClassVar = "bifurcations.draw_bifurcations"
    _of: ClassVar = "bifurcations"

    def of_kind(self, *kinds: str) -> tuple[Bifurcation, ...]:
        """Those of one of the kinds.

        Raises
        ------
        ValueError
            A kind is not one of ``BIFURCATION_KINDS``.
        """
        for kind in kinds:
            one_of("kind", kind, BIFURCATION_KINDS)
        return tuple(item for item in self.bifurcations if item.kind in kinds)

    def __repr__(self) -> str:
        """Table of the bifurcations, at most 120 characters wide, then what stayed open."""
        lo, hi = self.range
        where = "" if self.window is None else ", window ({:.10g}, {:.10g})".format(*self.window)
        lines = [
            f"BifurcationList: {len(self)} bifurcations, {self.parameter} in "
            f"({lo:.10g}, {hi:.10g}), periods to {self.max_period}{where}",
            f"  {self.parameter:<19s} error    kind              period  orbits   attractors  "
            "points",
        ]
        lines += [_line(item) for item in self.bifurcations[:SHOWN]]
        lines += more(len(self))
        for cascade in self.cascades:
            lines.append(
                f"  cascade of {len(cascade.flips)} flips from {cascade.flips[0].value:.10g}, "
                f"{cascade.where}"
            )
        lines += [f"  unresolved: {item}" for item in self.unresolved]
        lines += [f"  {item}" for item in self.outside]
        lines += [f"  {self.coverage}"] if self.coverage else []
        if len(self.looks) > 1:
            apart = max(b - a for a, b in pairwise(self.looks))
            lines.append(
                f"  attractors seen at {len(self.looks)} values, at most {apart:.3g} apart: cycles "
                "above that period, and chaos, may live between"
            )
        return "\n".join(lines)


def place(point: Any, digits: int) -> str:
    """Write a point: one number, or several in parentheses."""
    texts = [f"{x:.{digits}g}" for x in np.atleast_1d(point)]
    return f"({', '.join(texts)})" if np.ndim(point) else texts[0]


def _line(item: Bifurcation) -> str:
    """One line of a list's table."""
    kind = item.kind.replace("_", " ")
    if item.criticality:
        kind = f"{kind} ({item.criticality})"
    orbits = f"{len(item.orbits_before)} -> {len(item.orbits_after)}"
    attractors = _short(item.attractors_before) + " -> " + _short(item.attractors_after)
    if not item.attractors_before and not item.attractors_after:
        attractors = ""
    points = listed((place(x, 9) for x in item.points), POINTS_SHOWN)
    return (
        f"  {item.value:<19.15g} {item.error:<8.1g} {kind:17s} {item.period:6d}  {orbits:8s} "
        f"{attractors:11s} {points}"
    )


def _short(attractors: tuple[Attractor, ...]) -> str:
    """Attractors by letter and period: p4 a cycle of period 4, c2 chaos in 2 bands, u open."""
    return " ".join(f"{a.kind[0]}{a.period or ''}" for a in attractors) or "-"


def _kinds(items: tuple[Any, ...]) -> str:
    """Name orbits or attractors."""
    return ", ".join(f"{item.kind} period {item.period}" for item in items) or "none"


def _outcome(outcome: Outcome | None) -> str | None:
    if outcome is None:
        return None
    text = f"orbits: {outcome.orbits}; attractors: {outcome.attractors}"
    return f"{text} ({outcome.text})" if outcome.text else text


def attempted(
    part: Callable[[], T],
    what: str,
    lo: float,
    hi: float,
    unresolved: list[UnresolvedChange],
    *,
    partial: bool = False,
) -> T | None:
    """Return what a part of a search finds; None, and noted, if the program fails there.

    Ctrl-C leaves out the part, noted likewise, if a ``partial`` answer is wanted.
    """
    try:
        return part()
    except KeyboardInterrupt:
        if not partial:
            raise
        reason = f"interrupted: {what} left out"
    except Exception as error:
        logging.getLogger(__name__).exception("a fault of the program in %s", what)
        reason = f"a fault of the program left out {what} ({type(error).__name__}, logged)"
    unresolved.append(UnresolvedChange(reason, lo, hi))
    return None


def found_or_left_out(
    part: Callable[[], T], what: str, lo: float, hi: float
) -> T | UnresolvedChange:
    """Return what a part of a search finds; what is left open if the program fails there."""
    noted: list[UnresolvedChange] = []
    found = attempted(part, what, lo, hi, noted)
    return noted[0] if found is None else found
