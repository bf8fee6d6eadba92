"""Bifurcations of maps of R^n along a parameter: of followed orbits, and of sets of attractors."""

from __future__ import annotations

import functools
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, get_args

import numpy as np

from stickslip.analysis.attractors.attractors import N_STARTS, attractors
from stickslip.analysis.bifurcations.accounting import BESIDE, Look, accounted
from stickslip.analysis.bifurcations.bifurcation import (
    Bifurcation,
    BifurcationList,
    Coverage,
    UnresolvedChange,
    attempted,
    found_or_left_out,
)
from stickslip.analysis.bifurcations.normal_forms import coefficient
from stickslip.analysis.bifurcations.outcome import AttractorOutcome, OrbitOutcome, Outcome
from stickslip.analysis.continuation.continuation import follow_orbit
from stickslip.analysis.maps.protocol import apart, lengths, orbits, reduced, widths
from stickslip.analysis.orbits.orbits_nd import distinct_orbits, same_points, search_orbits
from stickslip.analysis.scales import FINE, ON_CURVE, PASSING, ROUNDS
from stickslip.analysis.work import Work
from stickslip.checks import MOST_KEPT, whole_number
from stickslip.numerics.processes import in_processes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent
    from stickslip.analysis.maps.protocol import FamilyND, Floats
    from stickslip.analysis.orbits.orbits_nd import OrbitListND, PeriodicOrbitND

N_LISTS: Final = 12
SHARE: Final = 0.3  # ... and of the way to the next event
CLOUD: Final = 48  # guesses about an orbit, ...
NEAREST: Final = 1e-5  # ... from this share of the domain to ...
NEAR: Final = 1e-2  # ... this share of it, or ...
REACH: Final = 4.0  # ... this times the root of the share of the range
NARROW: Final = 2e-4  # of the range: a change of the attractors so well bracketed is listed
LOOKING: Final = 24  # starts of each look at the attractors
KINDS: Final[dict[str, str]] = {
    "breakpoint": "border_collision",
    "gap": "enters_gap",
    "end of domain": "enters_gap",
    "period halves": "flip",
}


def _listed(
    f: FamilyND, name: str, max_period: int, n_starts: int, q: float
) -> OrbitListND | UnresolvedChange:
    """List orbits at a value of the parameter, or tell that this failed."""

    def found() -> OrbitListND:
        return search_orbits(f.replace(**{name: q}), max_period, None, n_starts)

    return found_or_left_out(found, "a list of orbits", q, q)


def _look(f: FamilyND, name: str, at: tuple[float, Floats]) -> Look | UnresolvedChange:
    """Find what starts lead to at a value of the parameter, or tell that this failed."""
    q, starts = at

    def found() -> Look:
        return Look(q, tuple(attractors(f.replace(**{name: q}), starts=starts)))

    return found_or_left_out(found, "attractors", q, q)


class OrbitSurvey:
    """All orbits that lists over a range lead to, followed to where they end."""

    def __init__(
        self, f: FamilyND, name: str, lo: float, hi: float, max_period: int, n_starts: int
    ) -> None:
        self.f, self.name, self.lo, self.hi = f, name, lo, hi
        self.max_period, self.n_starts = max_period, n_starts
        self.width = hi - lo
        self.size = widths(f)
        self.curves: list[Curve] = []
        self.unresolved: list[UnresolvedChange] = []
        self.events: list[Bifurcation] = []
        self.values = np.empty(0)  # of the parameter, at these
        self.coverage: Coverage | None = None
        self._late = np.zeros(3, dtype=int)  # of the last half of the lists, as `Coverage` has them
        self._branched = 0
        self._on_curve = functools.cache(self._solved_on_curve)  # curves are only added

    def at(self, q: float) -> FamilyND:
        """Return the map at a value of the parameter."""
        return self.f.replace(**{self.name: float(q)})

    def run(self, n_lists: int, work: Work) -> None:
        """Make the lists, follow what they hold and what flips lead to, gather the events."""
        # Values inside the range: at its ends an orbit may be just about to be born. The last half
        # of them lie between those of the first, whose orbits they should only find again.
        values = self.lo + self.width * (np.arange(n_lists) + 0.5) / n_lists
        first, last = values[::2].tolist(), values[1::2].tolist()
        search = functools.partial(_listed, self.f, self.name, self.max_period, self.n_starts)
        with work.until_interrupted():
            lists = in_processes(search, [*first, *last], work.tell)
            for k, (q, found) in enumerate(zip([*first, *last], lists, strict=True)):
                late = k >= len(first)
                if k == len(first):
                    self._branch_off_all()
                if isinstance(found, UnresolvedChange):
                    self.unresolved.append(found)
                else:
                    task = functools.partial(self._follow_new, found, q, late=late)
                    attempted(task, "a list of orbits", q, q, self.unresolved)
            self._branch_off_all()
        if work.interrupted:
            reason = "interrupted: lists of orbits left out, and what branches off curves"
            self.unresolved.append(UnresolvedChange(reason, self.lo, self.hi))
        self.coverage = Coverage(n_lists, self.n_starts, *self._late.tolist())
        self._gather()

    def _branch_off_all(self) -> None:
        """Follow what events and ends of all curves lead to, which may be more curves."""
        while self._branched < len(self.curves):
            self._branch_off(self.curves[self._branched])
            self._branched += 1

    def _branch_off(self, curve: Curve) -> None:
        """Follow what begins at the events and ends of a curve."""
        for item in curve.bifurcations:
            if item.kind == "flip" and 2 * len(item.points) <= self.max_period:
                self._branches_off(item, double=True)
        for end in curve.ends:
            if end.reason == "period halves":  # onto an orbit that no list may have shown
                half = replace(end, points=end.points[: len(end.points) // 2])
                self._branches_off(half, double=False)
            if end.reason == "breakpoint":
                self._branches_off(end, double=False)
                if len(end.points) <= self.max_period:
                    self._branches_off(end, double=True)
                self._return_to(end)

    def _follow_new(self, found: Sequence[PeriodicOrbitND], q: float, *, late: bool) -> None:
        """Follow the orbits of a list that no curve passes through."""
        known = [orbit for orbit in self.on_curves(q) if orbit.period <= self.max_period]
        new = [o for o in found if not any(same_points(self.f, k.points, o.points) for k in known)]
        for orbit in new:
            self._follow(orbit, q)
        if late:
            self._late += len(known), len(found) - len(new), len(new)

    def starts(self, q: float, others: Floats) -> Floats:
        """Points of the stable orbits that are known, too: few starts meet a small basin."""
        stable = [orbit.points[0] for orbit in self.on_curves(q) if orbit.stable]
        found = np.array([*others, *stable])
        return found[self.at(q).contains(found)]

    def on_curves(self, q: float, period: int | None = None) -> Iterator[PeriodicOrbitND]:
        """Orbits at a value through which curves pass, all or of one period."""
        for k, curve in enumerate(self.curves):
            if period in (None, curve.period):
                yield from self._on_curve(k, q)

    def _solved_on_curve(self, k: int, q: float) -> tuple[PeriodicOrbitND, ...]:
        values = self.curves[k].values
        inside = values.min() <= q <= values.max()
        return self.curves[k].all_at(**{self.name: q}) if inside else ()

    def _branches_off(self, event: CurveEvent | CurveEnd, *, double: bool) -> None:
        """Follow the orbits beside an event, on whichever side they are."""
        for q in self._sides(event.value):
            for orbit in self.near(event.points, event.value, q, double=double):
                self._follow(orbit, q)

    def _return_to(self, end: CurveEnd) -> None:
        """Follow orbits of any period that come back to a border from beyond a jump of the map."""
        rng = np.random.default_rng(0)
        for q in self._sides(end.value):
            f, shares = self.at(q), np.geomspace(NEAREST, NEAR, CLOUD)[:, None]
            ways = rng.normal(size=(CLOUD, self.f.dimension))
            x = end.points[end.index] + shares * self.size * ways
            paths = orbits(f, x, self.max_period)
            off = np.abs(apart(f, paths, x[:, None]) / self.size).max(axis=2)
            for p in range(1, self.max_period + 1):
                for orbit in distinct_orbits(f, paths[off[:, p] < PASSING, :p]):
                    self._follow(orbit, q)

    def _sides(self, value: float) -> list[float]:
        """Values just below and above one, as far as they are in the range."""
        off = BESIDE * self.width
        return [q for q in (value - off, value + off) if self.lo <= q <= self.hi]

    def _follow(self, orbit: PeriodicOrbitND, q: float) -> None:
        """Follow an orbit unless a curve passes through it."""
        known = self.on_curves(q, orbit.period)
        if any(same_points(self.f, one.points, orbit.points) for one in known):
            return
        curve = follow_orbit(orbit, self.at(q), self.name, (self.lo, self.hi))
        self.curves.append(curve)
        for end in curve.ends:
            if end.reason in ("step limit", "point limit"):
                reason = f"an orbit could not be followed on: {end.reason}"
                x = float(end.points[0, 0])
                self.unresolved.append(
                    UnresolvedChange(reason, end.value, end.value, orbit.period, x)
                )

    def near(
        self, points: Floats, value: float, q: float, *, double: bool
    ) -> list[PeriodicOrbitND]:
        """Orbits at a value close to those points (p, n) at another: of period p, or 2 p."""
        f, rng = self.at(q), np.random.default_rng(0)
        centre = np.tile(points, (1 + double, 1))
        reach = REACH * np.sqrt(abs(q - value) / self.width)
        shares = np.geomspace(NEAREST, reach, CLOUD)[:, None, None]
        guesses = centre + shares * self.size * rng.normal(size=(CLOUD, *centre.shape))
        found = distinct_orbits(f, reduced(f, np.concatenate([centre[None], guesses])))
        scaled = float(reach * (self.size / lengths(f)).max())
        return [orbit for orbit in found if same_points(f, centre, orbit.points, scaled)]

    # ------------------------------------------------------------------ events

    def _gather(self) -> None:
        """Describe each event once, by value, with the orbits on both sides."""
        found: list[tuple[Bifurcation, list[tuple[Curve, int]]]] = []
        for curve in sorted(self.curves, key=lambda curve: curve.period or 0):
            passed = [item for item in curve.bifurcations if item.kind != "border"]
            items = [(self._passed(item), item.row) for item in passed]
            for row, end in zip((0, len(curve) - 1), curve.ends, strict=True):
                items += [(self._ended(end), row)] if end.reason in KINDS else []
            for item, row in items:
                known = [places for other, places in found if self._same(item, other)]
                if not known:
                    found.append((item, []))
                    known = [found[-1][1]]
                known[0].append((curve, row))
        found.sort(key=lambda pair: pair[0].value)
        self.values = np.array([item.value for item, _ in found])
        for item, places in found:
            task = functools.partial(self._described, item, places)
            full = attempted(task, f"a {item.kind}", item.value, item.value, self.unresolved)
            self.events.append(full or item)

    def _same(self, one: Bifurcation, other: Bifurcation) -> bool:
        """Tell whether two ends or events are one; orbits of several periods meet a border."""
        off = abs(one.value - other.value) - FINE * self.width
        turns, rest = divmod(one.period, other.period)
        if one.kind != other.kind or off > one.error + other.error or rest:
            return False
        points = np.tile(other.points, (turns, 1))
        borders = one.kind == "border_collision"
        return (borders or turns == 1) and same_points(self.f, one.points, points, ON_CURVE)

    def _passed(self, item: CurveEvent) -> Bifurcation:
        note = f"rotation {item.rotation:.10g}" if item.kind == "neimark_sacker" else ""
        return self._event(item.kind, item, item.points, note)

    def _ended(self, end: CurveEnd) -> Bifurcation:
        kind, points, note = KINDS[end.reason], end.points, ""
        if kind == "flip":  # of the orbit that this one ends on
            points = points[: len(points) // 2]
        elif end.index is not None:
            met = "the end of the domain" if "domain" in end.reason else f"a {end.kind or 'gap'}"
            note = f"point {end.index + 1} of the orbit meets {met} of the map"
        text, block = end.border or ("", None)
        found = self._event(kind, end, points, note)
        return replace(found, mechanism=text, block=block)

    def _event(self, kind: Any, at: Any, points: Floats, note: str) -> Bifurcation:
        turned = np.roll(points, -int(np.argmin(points[:, 0])), axis=0)
        return Bifurcation(
            kind=kind,
            parameter=self.name,
            value=at.value,
            error=at.error,
            period=len(points),
            points=turned,
            interval=(at.value - at.error, at.value + at.error),
            multipliers=at.multipliers,
            note=note,
            system=self.f,
        )

    def clear_sides(self, value: float) -> tuple[float, float]:
        """Values just below and above an event, and far from all others."""
        away = np.abs(self.values - value)
        others = away[away > FINE * self.width]
        off = min(BESIDE * self.width, SHARE * others.min(initial=np.inf))
        return value - off, value + off

    def _described(self, item: Bifurcation, places: list[tuple[Curve, int]]) -> Bifurcation:
        """Add the orbits on both sides, and what the normal form or they themselves foretell."""
        sides = self.clear_sides(item.value)
        on = [self._beside(item, places, q) for q in sides]
        if item.kind == "flip" and all(o.period == item.period for o in (*on[0], *on[1])):
            doubles = [
                (size, k, orbit)
                for k, q in enumerate(sides)
                for single in on[k]
                for orbit in self.near(item.points, item.value, q, double=True)
                if (size := self._opening(orbit, single)) is not None
            ]
            if doubles:  # there is one, which shrinks onto the flip: others nearby do not
                _, k, orbit = min(doubles, key=lambda double: double[0])
                on[k].append(orbit)
        item = replace(item, orbits_before=tuple(on[0]), orbits_after=tuple(on[1]))
        if item.kind in ("flip", "neimark_sacker"):
            cubic = coefficient(self.at(item.value), item.points, item.kind)
            text = f"cubic coefficient {cubic.value:.8g} ± {cubic.error:.1g}"
            note = "; ".join(filter(None, (item.note, text)))
            return replace(item, criticality=cubic.criticality, note=note)
        return replace(item, outcome=_outcome(item)) if item.kind == "border_collision" else item

    def _beside(
        self, item: Bifurcation, places: list[tuple[Curve, int]], q: float
    ) -> list[PeriodicOrbitND]:
        """Orbits at q on the curves that pass through an event or end there."""
        if not self.lo <= q <= self.hi:
            return []
        ways = [(*place, step) for place in places for step in (1, -1)]
        found = list(filter(None, (self._along(*way, item.value, q) for way in ways)))
        return sorted(found, key=lambda orbit: orbit.period)

    def _along(
        self, curve: Curve, row: int, step: int, value: float, q: float
    ) -> PeriodicOrbitND | None:
        """Return the orbit at q that a curve leads to from a row; None if it leads elsewhere."""
        values, points = (
            each[row::step] if step > 0 else each[row::-1] for each in (curve.values, curve.points)
        )
        off = (values - value) * np.sign(q - value)
        inner = int(np.argmax(off >= abs(q - value)))
        if not inner or (off[1:inner] < -FINE * self.width).any():
            return None
        share = (q - values[inner - 1]) / (values[inner] - values[inner - 1])
        guess = points[inner - 1] + share * (points[inner] - points[inner - 1])
        found = distinct_orbits(self.at(q), guess[None])
        return found[0] if found else None

    def _opening(self, orbit: PeriodicOrbitND, single: PeriodicOrbitND) -> float | None:
        """Distance between the halves of an orbit that runs twice around another; else None."""
        one, other = np.split(orbit.points, 2)
        size = float(np.linalg.norm(apart(self.f, one, other) / self.size))
        middle = one - 0.5 * apart(self.f, one, other)
        turns = (np.roll(single.points, k, axis=0) for k in range(single.period))
        away = min(np.linalg.norm(apart(self.f, middle, turn) / self.size) for turn in turns)
        return size if away < 0.5 * size else None


def _outcome(item: Bifurcation) -> Outcome:
    """Say what becomes of the orbits at a border, from those seen on both sides."""
    before, after = (
        tuple(sum(o.period == item.period * k for o in orbits) for k in (1, 2))
        for orbits in (item.orbits_before, item.orbits_after)
    )
    jump = "jump" in item.note
    known: dict[tuple[Any, Any], OrbitOutcome] = {
        ((1, 0), (1, 0)): "persist",
        ((0, 0), (2, 0)): "born in pairs",
        ((2, 0), (0, 0)): "die in pairs",
        ((1, 0), (1, 1)): "period-doubled",
        ((1, 1), (1, 0)): "period-doubled",
    }
    if jump:
        known |= {((1, 0), (0, 0)): "lost at a jump", ((0, 0), (1, 0)): "born at a jump"}
    stable = any(orbit.stable for orbit in item.orbits_after)
    return Outcome(known.get((before, after), "undecided"), "periodic" if stable else "undecided")


def _with_attractors(outcome: Outcome, before: tuple[Any, ...], after: tuple[Any, ...]) -> Outcome:
    """Add the kind of the attractors that are new after a border collision, if it is one."""
    new = Counter((a.kind, a.period) for a in after)
    new -= Counter((a.kind, a.period) for a in before)
    kinds = {kind for kind, _ in new} | ({outcome.attractors} & {"periodic"})
    one: Any = kinds.pop() if len(kinds) == 1 else "undecided"
    return replace(outcome, attractors=one if one in get_args(AttractorOutcome) else "undecided")


# ------------------------------------------------------------------ attractors


def bifurcations_nd(
    f: FamilyND,
    name: str,
    ends: tuple[float, float],
    max_period: int,
    *,
    n_lists: int | None = None,
    n_starts: int | None = None,
    work: Work,
) -> BifurcationList:
    """Find bifurcations of a map of R^n; see `stickslip.bifurcations`."""
    lists = whole_number("n_lists", N_LISTS if n_lists is None else n_lists, at_most=MOST_KEPT)
    starts = whole_number("n_starts", N_STARTS if n_starts is None else n_starts, at_most=MOST_KEPT)
    survey = OrbitSurvey(f, name, *ends, max_period, starts)
    survey.run(lists, work.part(0.0, 0.5))
    looks = _Looks(survey)
    items, changes = survey.events, list[Bifurcation]()
    unresolved = outside = list[UnresolvedChange]()
    with work.until_interrupted():
        if work.interrupted:
            raise KeyboardInterrupt
        sides = [q for item in survey.events for q in survey.clear_sides(item.value)]
        looks.at([*np.linspace(*ends, lists), *sides], work.part(0.5, 0.8).tell)
        items = [looks.beside(item) for item in survey.events]
        changes, unresolved, outside = looks.changes(work.part(0.8, 1.0).tell)
    if work.interrupted:
        unresolved = [UnresolvedChange("interrupted: attractors left out", *ends)]
    return BifurcationList(
        bifurcations=tuple(sorted([*items, *changes], key=lambda item: item.value)),
        parameter=name,
        range=ends,
        parameters=dict(f.parameters),
        max_period=max_period,
        curves=tuple(survey.curves),
        unresolved=tuple(sorted([*survey.unresolved, *unresolved], key=lambda item: item.lo)),
        outside=tuple(outside),
        n_lists=lists,
        coverage=survey.coverage,
        looks=tuple(sorted(looks.known)),
    )


class _Looks:
    """What attracts at values of the parameter."""

    def __init__(self, survey: OrbitSurvey) -> None:
        self.survey = survey
        self.known: dict[float, Look] = {}

    def at(self, values: Iterable[float], tell: Callable[[float], None]) -> None:
        """Look at values inside the range that are not known."""
        survey = self.survey
        inside = (q for q in map(float, values) if survey.lo <= q <= survey.hi)
        new = [q for q in dict.fromkeys(inside) if q not in self.known]
        places = [(q, survey.starts(q, survey.at(q).spread(LOOKING))) for q in new]
        look = functools.partial(_look, survey.f, survey.name)
        for q, found in zip(new, in_processes(look, places, tell), strict=True):
            if isinstance(found, UnresolvedChange):
                survey.unresolved.append(found)
            else:
                self.known[q] = found

    def beside(self, item: Bifurcation) -> Bifurcation:
        """Add the attractors just below and just above an event."""
        sides = self.survey.clear_sides(item.value)
        before, after = (self.known[q].attractors if q in self.known else () for q in sides)
        outcome = item.outcome and _with_attractors(item.outcome, before, after)
        return replace(item, attractors_before=before, attractors_after=after, outcome=outcome)

    def changes(
        self, tell: Callable[[float], None]
    ) -> tuple[list[Bifurcation], list[UnresolvedChange], list[UnresolvedChange]]:
        """Bisect the changes that nothing located explains; those too many stay unresolved."""
        narrow, left, asked = NARROW * self.survey.width, ROUNDS, set[float]()
        while True:
            found, outside = accounted(
                self.known.values(), self.survey.values.tolist(), self.survey.max_period
            )
            wide = [item for item in found if item.hi - item.lo > narrow]
            widest = sorted(wide, key=lambda item: item.lo - item.hi)
            middles = [0.5 * (item.lo + item.hi) for item in widest]
            # A look that failed, or that shows neither side, divides its own change no further.
            middles = [q for q in middles if q not in asked][:left]
            if not middles:
                break
            self.at(middles, tell)
            asked.update(middles)
            left -= len(middles)
        changed = [self._change(item) for item in found if item.hi - item.lo <= narrow]
        return changed, wide, outside

    def _change(self, item: UnresolvedChange) -> Bifurcation:
        before, after = (self.known[q].attractors for q in (item.lo, item.hi))
        changed = [a for a in (*before, *after) if a.kind != "periodic"] or [*before, *after]
        return Bifurcation(
            kind="attractor_change",
            parameter=self.survey.name,
            value=0.5 * (item.lo + item.hi),
            error=0.5 * (item.hi - item.lo),
            period=0,
            points=changed[0].points[:1],
            attractors_before=before,
            attractors_after=after,
            quality="bracketed",
            interval=(item.lo, item.hi),
            note=f"evidence, by bisection: {item.reason.partition(':')[0]}",
            system=self.survey.f,
        )
