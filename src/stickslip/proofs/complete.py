"""Complete lists: every periodic orbit up to a period, by branch and bound over the domain.

At one value of the parameters, or for every value of one in an interval: then orbits are branches.

Docs: proofs, complete lists.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from flint import arb

from stickslip.analysis.attractors.bands import merged
from stickslip.proofs.branch import Tube, in_tube
from stickslip.proofs.jet import Jet, outward
from stickslip.proofs.newton import NoZero
from stickslip.proofs.orbit import proven_orbit
from stickslip.proofs.power import Region, along, follow, step
from stickslip.proofs.verify.words import ball
from stickslip.proofs.wave import Undecided

BOXES: Final = 32  # to start with
POSSIBILITIES: Final = 64
NARROWEST: Final = 1e-9  # an interval that is undecided at this width is reported
MOST_UNDECIDED: Final = 10_000  # intervals: no certificate holds more


class Endless(Undecided):
    """Orbits may fill intervals, which no halving ends."""


@dataclass(frozen=True)
class _Known:
    """An orbit that is proven, or a branch."""

    period: int
    entries: dict[str, Any] = field(repr=False)

    def first(self, region: Region) -> arb:
        """Enclose the first point, for every value of the parameter in a region."""
        if "nodes" in self.entries:
            return in_tube(self.entries, *region.span)
        return ball(self.entries["points"][0])


class Survey:
    """All periodic orbits up to a period, and the intervals of d that may hold another one."""

    def __init__(self, region: Region, max_period: int, digits: int) -> None:
        self.undecided: list[tuple[float, float]] = []
        self._whole, self._digits = region, digits
        self._known: list[_Known] = []
        self._passed: dict[Any, list[arb]] = {}  # what `_points` has found
        if region.span:
            self._compare_ends(max_period)
        for period in range(1, max_period + 1):
            self._search(period)
        # of one period or several: an orbit may lie in either
        self.undecided = merged(np.array(self.undecided), 0.0).tolist()

    @property
    def orbits(self) -> list[dict[str, Any]]:
        """Entries of certificates."""
        known = sorted(self._known, key=lambda x: (x.period, float(x.first(self._whole))))
        return [x.entries for x in known]

    def _compare_ends(self, max_period: int) -> None:
        """Refuse at once what no list can be: other numbers of orbits at the two ends."""
        region = self._whole
        fixed = [replace(region, span=(p, p)).fixed for p in region.span]
        low, high = (len(Survey(Region(at), max_period, self._digits).orbits) for at in fixed)
        if low != high:
            name, (first, last) = region.setting.varied[0], map(float, region.span)
            raise Undecided(
                f"there are {low} orbits of period up to {max_period} at {name} = {first:.10g} and "
                f"{high} at {last:.10g}: their number changes"
            )

    def _search(self, period: int) -> None:
        """Find all orbits of a period, and the intervals that stay undecided."""
        left = 0
        waiting = [(self._whole, box) for box in self._whole.setting.boxes(BOXES)]
        while waiting:
            region, box = waiting.pop()
            if self._decided(region, box, period):
                continue
            if box.rad() >= NARROWEST:
                waiting += region.cut(box)
                continue
            if region.span:
                where = f"{region.setting.varied[0]} = {float(region.middle):.10g}"
                where = f"near d = {float(box.mid()):.10g}, {where}"
                raise Undecided(f"there may be another orbit of period {period} {where}")
            self.undecided.append(outward(box))
            left += 1
            if left > MOST_UNDECIDED:
                where = f"near {box.mid().str(6, radius=False)}"
                raise Endless(
                    f"too many intervals stay undecided {where}: orbits of period {period} may "
                    "fill them, or hardly move apart, or the map has no value there; a smaller "
                    "max_period, or another domain, may go"
                )

    def _decided(self, region: Region, box: arb, period: int) -> bool:
        """Whether an interval holds no orbit but those that are known; take up one that it does."""
        values = self._values(region, box, period)
        if values is not None and all(not value.range.overlaps(box) for value in values):
            return True
        known = self._points(region, period)
        if (near := next((x for x in known if x.overlaps(box)), None)) is not None:
            # Where f^p - d is monotone, the two together hold one orbit.
            return _rate(self._values(region, box.union(near), period)) is not None
        rate = _rate(values)
        if rate is None:
            return False
        assert values is not None
        new = box.mid() - _miss(values[0], box.mid()) / rate
        if new.overlaps(box):
            self._take_up(new.intersection(box).mid(), region, period)
            return False
        return True

    def _values(self, region: Region, box: arb, period: int) -> list[Jet] | None:
        """Return all values of f^period on an interval, or None if they are not known."""
        d, parameters = region.around(box)
        forks = 8 if box.rad() < region.setting.coarse else 0
        values = [d]
        for _ in range(period):
            try:
                steps = (step(region.setting, x, parameters, forks=forks) for x in values)
                values = [piece.value for pieces in steps for piece in pieces]
            except Undecided:
                return None
            if len(values) > POSSIBILITIES:
                return None
        return values

    def _points(self, region: Region, period: int) -> list[arb]:
        """Enclose all points of the known orbits of a period or a divisor."""
        asked = region.span, period, len(self._known)
        if asked not in self._passed:
            found = []
            for orbit in self._known:
                if period % orbit.period == 0:
                    start = region.around(orbit.first(region))
                    points, *_ = follow(region.setting, *start, orbit.period)
                    found += [x.range for x in points]
            self._passed[asked] = found
        return self._passed[asked]

    def _take_up(self, near: arb, region: Region, period: int) -> None:
        """Prove the orbit that may be near, and take it up if it is not known."""
        whole, fixed, p = self._whole, region.fixed, region.middle
        here = replace(region, span=(p, p)) if region.span else region
        try:
            point, _, entries = proven_orbit(fixed, near, period, self._digits)
            if any(point.overlaps(x) for x in self._points(here, period)):
                return
            lowest = min(along(fixed, point, period)[0], key=float)
            if lowest is not point:
                entries = proven_orbit(fixed, lowest, period, self._digits)[2]
        except (Undecided, NoZero):
            return
        if whole.span:
            low, high = whole.span
            tube = Tube(whole.setting, lowest, p, (low, high), period, self._digits)
            entries = tube.entries()
            if entries["lost"]:
                raise Undecided(
                    f"the orbit of period {period} near d = {float(lowest):.6g} is lost at "
                    f"{entries['lost'][0]['value']}: there the number of orbits changes"
                )
        self._known.append(_Known(period, entries))


def _rate(values: list[Jet] | None) -> arb | None:
    """Return the derivative of f^p(d) - d on an interval where it is proven to be monotone."""
    if values is None or len(values) > 1:
        return None
    rate = values[0].gradient[0] - 1
    return None if not rate.is_finite() or rate.contains(0) else rate


def _miss(value: Jet, middle: arb) -> arb:
    """Enclose f^p(d) - d in the middle of an interval, for all parameters of a region."""
    miss = value.centre - middle
    for slope, width in zip(value.gradient[1:], value.box[1:], strict=True):
        miss = miss + slope * width
    return miss
