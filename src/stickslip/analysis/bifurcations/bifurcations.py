"""Every bifurcation of a family of maps over a range of a parameter, from one call."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import islice, pairwise
from operator import call
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar

import numpy as np

from stickslip.analysis.bifurcations.accounting import (
    BESIDE,
    Look,
    accounted,
    too_close,
    unexplained,
    unlike,
)
from stickslip.analysis.bifurcations.bifurcation import (
    Bifurcation,
    BifurcationList,
    UnresolvedChange,
    attempted,
    bifurcation_of,
    found_or_left_out,
    joined_where_they_touch,
)
from stickslip.analysis.bifurcations.cascades import cascades, with_double
from stickslip.analysis.bifurcations.conditions.conditions import Collision, Connection, Contact
from stickslip.analysis.bifurcations.crisis.comparison import ParameterPoint, parameter_point
from stickslip.analysis.bifurcations.crisis.crises import LOOKS, CrisisEvent, CrisisSearch, Sides
from stickslip.analysis.bifurcations.explain import explained, with_attractors
from stickslip.analysis.bifurcations.in_space.bifurcations_nd import bifurcations_nd
from stickslip.analysis.bifurcations.orbit_curves import orbit_curves
from stickslip.analysis.bifurcations.scan.adding_up import Concerned, concerned_orbits
from stickslip.analysis.bifurcations.scan.events import SAME_VALUE, passes_cut
from stickslip.analysis.bifurcations.scan.nodes import Family, Node
from stickslip.analysis.bifurcations.scan.survey import Survey
from stickslip.analysis.branches.along.tracked import ConditionLost, DomainEnd, TrackedDiscontinuity
from stickslip.analysis.maps.arguments import checked_range, line_family, map_of, not_for
from stickslip.analysis.maps.protocol import FamilyND, Floats, MapFamily, Modelled, explanation
from stickslip.analysis.orbits.newton import solve_orbit
from stickslip.analysis.work import Work
from stickslip.checks import MOST_KEPT, whole_number
from stickslip.numerics.processes import in_processes
from stickslip.numerics.waiting import waits
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from stickslip.analysis.bifurcations.bifurcation import Cascade
    from stickslip.analysis.bifurcations.conditions.locate import MapAt
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

T = TypeVar("T")
Looked: TypeAlias = "ParameterPoint | UnresolvedChange | None"
Jobs: TypeAlias = "dict[float, Callable[[], Looked]]"  # by the value

N_LISTS: Final = 24
NEARER: Final = 1 / 64  # of that, where theory foretells what is not seen there
LAST_FLIP: Final = 5  # of a cascade: as far beyond its accumulation attractors are looked at


@waits
@suggests
def bifurcations(
    system: MapFamily | FamilyND | Modelled[MapFamily] | Modelled[FamilyND],
    parameter: str,
    range: tuple[float, float],
    *,
    max_period: int = 4,
    window: tuple[float, float] | None = None,
    n_lists: int | None = None,
    n_starts: int | None = None,
    progress: Callable[[float], None] | None = None,
    partial: bool = False,
) -> BifurcationList:
    """Find, locate and explain the bifurcations of a system along one of its parameters.

    Parameters
    ----------
    system : model or map with parameters
        A `TwoBlock`, an event map or a `PiecewiseMap`; of R^n a `Chain`, a return map or a `Map`.
    parameter : str
        Parameter that is varied, as in ``system.parameters``.
    range : pair of float
        ``lo < hi``, both allowed for the system.
    max_period : int
        Longest period of the orbits that are searched for; cascades are followed beyond.
    window : pair of float, optional
        Part of the domain of a map of a line that is searched: orbits that leave it end there.
    n_lists : int, optional
        Lists of orbits over the range to begin with (24 by default; 12 in R^n); of a line they
        are complete, and more are added where something happens.
    n_starts : int, optional
        In R^n: starts of Newton's method for each list and period in the first round, 64 by
        default.
    progress : callable, optional
        Called now and then with the share of the work that is done, 0 to 1.
    partial : bool
        Whether Ctrl-C returns what has been found so far; ``unresolved`` says what was left out.

    Returns
    -------
    BifurcationList
        A sequence of `Bifurcation`, ascending, with the branches of orbits between them, the
        cascades, and what stayed ``unresolved``. For a model the border collisions carry
        their mechanism and block.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters; an unknown parameter; a range that is no
        interval or not allowed; a period or number of values that is not a whole number.

    Notes
    -----
    Complete lists of orbits at a grid of values, every orbit joined to its like at the next
    value or followed to where it ends; what ends it is solved for to rounding, and lists just
    below and above each bifurcation show what it concerns (docs/theory/bifurcations.md).

    In R^n nothing is complete: orbits are followed from lists that may miss some, changes of the
    set of attractors are bracketed by bisection (docs/theory/bifurcations-in-space.md).

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.0})
    >>> found = ss.bifurcations(f, "r", (2.9, 3.5), max_period=2)
    >>> [(b.kind, b.criticality, round(b.value, 9)) for b in found]
    [('flip', 'super', 3.0), ('flip', 'super', 3.449489743)]
    """
    work = Work(progress, partial)
    max_period = whole_number("max_period", max_period, 1, at_most=MOST_KEPT)
    found_map = map_of(system)
    if isinstance(found_map, FamilyND):
        not_for("a line", window=window is not None)
        ends = checked_range(found_map, parameter, range)
        numbers = {"n_lists": n_lists, "n_starts": n_starts}
        return bifurcations_nd(found_map, parameter, ends, max_period, **numbers, work=work)
    not_for("R^n", n_starts=n_starts is not None)
    f = line_family(found_map)
    lo, hi = checked_range(f, parameter, range)
    family = Family(f, parameter, window)
    survey = Survey(family, lo, hi, max_period, work.part(0.0, 0.5))
    count = N_LISTS if n_lists is None else n_lists
    survey.run(whole_number("n_lists", count, 3, at_most=MOST_KEPT))
    return bifurcations_of(survey, work)


def bifurcations_of(survey: Survey, work: Work) -> BifurcationList:
    """Locate and explain what a survey of a range has found."""
    with survey.resolved():
        return _Report(survey, work).made()


def explain_border(item: Bifurcation, f: MapFamily) -> Bifurcation:
    """Add the mechanism of the break of f, at any parameter value, that takes part, if one does."""
    condition = item.condition
    if isinstance(condition, Collision):
        borders = [condition.border, *(other.border for other in condition.others)]
    elif isinstance(condition, Connection):
        borders = [condition.critical]
    elif isinstance(condition, Contact):
        borders = [condition.border]
    else:
        return item
    at_value = f.replace(**{item.parameter: item.value})
    known = []
    for border in borders:
        if not isinstance(border, TrackedDiscontinuity):
            return item
        try:
            known.append(explanation(at_value, *border.at(at_value).interval))
        except ConditionLost:
            return item
    text = ", together with: ".join(text for text, _ in known)
    block = known[0][1] if len(known) == 1 else None
    if isinstance(condition, Connection):
        text = f"image {condition.k} of the break where {text} meets the unstable orbit"
    elif isinstance(condition, Contact):
        source = (
            f"image {condition.k} of the {condition.critical.kind} at {condition.critical.x:.9g}"
        )
        text = f"{source} meets the break where {text}"
    return replace(item, mechanism=text, block=block)


def _at_node(at: MapAt, node: Node) -> ParameterPoint:
    return parameter_point(at, node.q, node.orbits, node.fast)


def _look(at: MapAt, q: float, guesses: list[Floats]) -> Looked:
    """Find the attractors at a value, stable orbits near guesses included, or what is left out.

    None where the family ends before that value, which may lie a little beyond the range.
    """
    try:
        f = at(q)
    except ValueError:
        return None

    def found() -> ParameterPoint:
        return parameter_point(at, q, [solve_orbit(f, guess) for guess in guesses])

    return found_or_left_out(found, "attractors", q, q)


def _stable_near(curves: Iterable[Curve], q: float) -> list[Floats]:
    """Guess the orbits at a value that are stable on both sides of it on their curves."""
    found = []
    for curve in curves:
        past = curve.values >= q
        for k in np.flatnonzero((past[1:] != past[:-1]) & curve.stable[1:] & curve.stable[:-1]):
            share = (q - curve.values[k]) / (curve.values[k + 1] - curve.values[k])
            found.append(curve.points[k] + share * (curve.points[k + 1] - curve.points[k]))
    return found


def _told_once(items: Iterable[UnresolvedChange]) -> tuple[UnresolvedChange, ...]:
    return tuple(sorted(dict.fromkeys(items), key=lambda item: item.lo))


class _Report:
    """A survey turned into a list of bifurcations."""

    def __init__(self, survey: Survey, work: Work) -> None:
        self.survey, self.f, self.work = survey, survey.family.f, work
        self.unresolved: list[UnresolvedChange] = list(survey.unresolved)  # outside it, too
        self.values = sorted(event.value for event in survey.events)
        self.accumulations: list[float] = []
        self.looks: dict[float, ParameterPoint] = {}
        self.ahead: dict[float, Looked] = {}  # looks that may serve
        self.between: list[Look] = []  # of the search for crises

    def made(self) -> BifurcationList:
        """Return the list."""
        survey = self.survey
        concerned: dict[int, list[Concerned]] = {}
        for k, span in enumerate(survey.spans):
            if span.events:
                concerned[k], left_open = concerned_orbits(span)
                self.unresolved += left_open
        family, whole = survey.family, (survey.lo, survey.hi)
        found = [item for k, shares in concerned.items() for item in self._events(k, shares)]
        curves = self.part(lambda: orbit_curves(survey, concerned), "the curves") or ()
        tell = self.work.part(0.5, 0.65).tell
        chains = self._search(
            lambda: cascades(found, curves, family, whole, survey.max_period, tell), "the cascades"
        )
        later = [flip for chain in chains for flip in chain.flips if flip.in_cascade]
        # Beyond the last flip that was solved for come more, up to there.
        self.accumulations = [chain.accumulation for chain in chains]
        items, breaks = [*found, *later], list(self.values)
        self.values += [item.value for item in later]
        crises_found = self._search(
            lambda: self._crises(breaks, self._looks_beside(items, 1.0, chains)), "the crises"
        )
        self.values += [item.value for item in crises_found]
        full = self._search(lambda: self._with_attractors(items, chains), "attractors") or items
        ends = [end for curve in curves for end in curve.ends]
        left = [end.value for end in ends if end.reason == "end of domain"]  # or of the window
        aside = [*self.accumulations, *left]
        # Chaos that is seen beside an event only lies between no two values of the grid.
        looks = filter(self._inside, self.looks.values())
        again = unlike(looks, [*self.values, *aside], survey.max_period)
        crises_found += self._more_crises([(a.value, b.value) for a, b in again])
        unaccounted, outside = self._accounted(aside)
        # Nor does the chaos that the search for crises saw itself.
        if more := self._more_crises([(change.lo, change.hi) for change in unaccounted]):
            crises_found += more
            unaccounted, outside = self._accounted(aside)
        self.work.tell(1.0)
        new = dict(zip(map(id, items), full, strict=True))
        found = sorted([*full, *crises_found], key=lambda item: item.value)
        if hasattr(self.f, "explain_break"):
            found = [
                self.part(partial(explain_border, item, self.f), "a mechanism", item.value) or item
                for item in found
            ]
        told = [*self.unresolved, *unaccounted, *outside]
        left_open = [change for change in told if not change.is_outside]
        if survey.crowded:  # the same can be left open at each of hundreds of breaks
            left_open = joined_where_they_touch(left_open)
        return BifurcationList(
            bifurcations=tuple(found),
            parameter=survey.family.name,
            range=(survey.lo, survey.hi),
            parameters=dict(self.f.parameters),
            max_period=survey.max_period,
            window=survey.family.window,
            curves=curves,
            cascades=tuple(
                replace(chain, flips=tuple(new.get(id(flip), flip) for flip in chain.flips))
                for chain in chains
            ),
            unresolved=_told_once(left_open),
            outside=_told_once(joined_where_they_touch(c for c in told if c.is_outside)),
            n_lists=survey.n_nodes,
            looks=tuple(q for q in sorted(self.looks) if survey.lo <= q <= survey.hi),
        )

    def _accounted(
        self, aside: list[float]
    ) -> tuple[list[UnresolvedChange], list[UnresolvedChange]]:
        """Return what changes between looks without anything listed, and what was not asked for."""
        every_look = filter(self._inside, [*self.looks.values(), *self.between])
        return accounted(every_look, [*self.values, *aside], self.survey.max_period)

    def _seen_at(self, q: float) -> ParameterPoint:
        """Return the look at a value, made anew if the search for crises made it."""
        return self.looks.get(q) or parameter_point(self.survey.family.at, q)

    def _inside(self, look: Look) -> bool:
        """Whether a look is in the range: beside what is at its ends there are others."""
        return self.survey.lo <= look.value <= self.survey.hi

    def part(self, part: Callable[[], T], what: str, *at: float) -> T | None:
        """Do a part of the work at a value, or over the range; None, and told, if it fails."""
        lo, hi = (*at, *at) if at else (self.survey.lo, self.survey.hi)
        return attempted(part, what, lo, hi, self.unresolved, partial=self.work.partial)

    def _search(self, part: Callable[[], list[T]], what: str) -> list[T]:
        """Do a long part over the range; what Ctrl-C has cut short is not gone on with."""

        def unless_interrupted() -> list[T]:
            if not self.work.interrupted:
                with self.work.until_interrupted():
                    return part()
            raise KeyboardInterrupt

        return self.part(unless_interrupted, what) or []

    def _events(self, k: int, shares: list[Concerned]) -> Iterator[Bifurcation]:
        span, family = self.survey.spans[k], self.survey.family
        for event, share in zip(span.events, shares, strict=True):
            if passes_cut(event, family.whole(event.value)):
                continue
            item = self.part(
                partial(explained, event, span, share, family), f"a {event.kind}", event.value
            )
            if item is None:
                continue
            if item.kind == "flip" and 2 * item.period > self.survey.max_period:
                double = partial(with_double, item, family)
                item = self.part(double, "a doubled orbit", item.value) or item
            yield item

    def _with_attractors(
        self, items: list[Bifurcation], chains: list[Cascade]
    ) -> list[Bifurcation]:
        """Add the attractors on both sides; two neighbours that are close share those between."""
        full = self._beside(items, 1.0, chains)
        # Something else may be between, which was not asked for: nearer looks rule it out.
        doubtful = [item for item in full if item.disagreement]
        nearer = dict(zip(map(id, doubtful), self._beside(doubtful, NEARER), strict=True))
        return [nearer.get(id(item), item) for item in full]

    def _beside(
        self, items: list[Bifurcation], share: float, chains: Iterable[Cascade] = ()
    ) -> list[Bifurcation]:
        """Add the attractors at a share of the way to what is next; look beyond cascades, too."""
        jobs = self._looks_beside(items, share, chains)
        rest = {q: job for q, job in jobs.items() if q not in self.ahead}
        more = in_processes(call, rest.values(), self.work.part(0.8, 0.9).tell)
        self.ahead |= zip(rest, more, strict=True)
        for q in jobs:
            found = self.ahead[q]
            if isinstance(found, UnresolvedChange):
                self.unresolved.append(found)
            elif found is not None:
                self._looked_at([found])
        full = []
        for item in items:
            below, above = (self.looks.get(q) for q in self._sides(item.value, share))
            if below is not None and above is not None:
                item = with_attractors(item, below, above, self.survey.width)
            full.append(item)
        return full

    def _looks_beside(
        self, items: list[Bifurcation], share: float, chains: Iterable[Cascade]
    ) -> Jobs:
        """Return the looks at what is beside bifurcations and beyond cascades, by the value."""
        survey, curves = self.survey, self.survey.curves or ()
        places = {q for item in items for q in self._sides(item.value, share)}
        beyond = (2 * c.accumulation - c.values[:LAST_FLIP][-1] for c in chains)
        places |= {q for q in beyond if survey.lo < q < survey.hi}
        at = survey.family.at
        return {q: partial(_look, at, q, _stable_near(curves, q)) for q in sorted(places)}

    def _sides(self, value: float, share: float) -> tuple[float, float]:
        """Where, just below and above a value, attractors are looked at: clear of other events."""
        survey = self.survey
        stops = [survey.lo, *self.values, *self.accumulations, survey.hi]
        apart, widest = 1e-12 * survey.scale, BESIDE * survey.scale
        below = max((q for q in stops if q < value - apart), default=value - survey.scale)
        above = min((q for q in stops if q > value + apart), default=value + survey.scale)
        down, up = (min(widest, 0.5 * room) for room in (value - below, above - value))
        return value - share * down, value + share * up

    # ------------------------------------------------------------------ crises

    def _looked_at(self, points: Iterable[ParameterPoint]) -> None:
        self.looks |= {point.value: point for point in points}

    def _crises(self, breaks: list[float], looks: Jobs) -> list[Bifurcation]:
        """Find crises between the values of the grid."""
        survey, at = self.survey, self.survey.family.at
        tell = self.work.part(0.65, 0.7).tell
        grid = list(in_processes(partial(_at_node, at), survey.grid_nodes, tell))
        self._looked_at(grid)
        return self._crises_in(list(pairwise(grid)), breaks, looks)

    def _crises_in(
        self, intervals: Sequence[Sides], breaks: list[float], looks: Jobs
    ) -> list[Bifurcation]:
        """Find crises in intervals; most come from few of these: look elsewhere meanwhile."""
        survey, tell = self.survey, self.work.part(0.7, 0.8).tell
        most = LOOKS // 16 if survey.crowded else LOOKS
        search = CrisisSearch(survey.family.at, breaks, survey.max_period, most)
        parts = search.parts(intervals)
        results: Iterator[Any] = in_processes(call, [*parts, *looks.values()], tell)
        found = search.joined(intervals, islice(results, len(parts)))
        self.ahead |= zip(looks, results, strict=True)
        self.unresolved += [unexplained(*pair, survey.max_period) for pair in found.left_open]
        self.unresolved += [too_close(*pair) for pair in found.too_close]
        self.between += found.looks
        self._looked_at(side for event in found.events for side in event.sides)
        return [self._crisis(event) for event in found.events if not self._explained(event, breaks)]

    def _more_crises(self, ends: list[tuple[float, float]]) -> list[Bifurcation]:
        """Find crises between looks that differ though nothing is listed between."""

        def search() -> list[Bifurcation]:
            intervals = [(self._seen_at(lo), self._seen_at(hi)) for lo, hi in ends]
            return self._crises_in(intervals, self.values, {})

        more = self._search(search, "the crises") if ends else []
        self.values += [item.value for item in more]
        return more

    def _explained(self, event: CrisisEvent, breaks: list[float]) -> bool:
        """Whether a collision makes or ends the chaos, and the orbits that it meets there too."""
        condition = event.condition
        if isinstance(condition, Contact) and isinstance(condition.border, DomainEnd):
            return False  # beside orbits that leave there, too
        same = event.located.error + SAME_VALUE * self.survey.scale
        return any(abs(event.value - value) <= same for value in breaks)

    def _crisis(self, event: CrisisEvent) -> Bifurcation:
        below, above = self._sides(event.value, 1.0)
        return bifurcation_of(
            event.kind,
            event.located,
            self.survey.family.name,
            self.f,
            orbits_before=self._orbit_at(below, event),
            orbits_after=self._orbit_at(above, event),
            attractors_before=event.attractors_before,
            attractors_after=event.attractors_after,
            looks=(event.sides[0].value, event.sides[1].value),
        )

    def _orbit_at(self, q: float, event: CrisisEvent) -> tuple[PeriodicOrbit, ...]:
        """Return the unstable orbit that an attractor meets, at a value beside the crisis."""
        if isinstance(event.condition, Contact):
            return ()
        try:
            orbit = solve_orbit(self.survey.family.at(q), np.array(event.points))
        except ValueError:
            return ()  # the family ends there
        return (orbit,) if orbit.quality == "located" else ()
