"""Complete lists: every periodic orbit up to a period, by branch and bound over the domain.

Docs: proofs, complete lists.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from flint import arb

from stickslip.proofs.jet import Jet, outward, variables
from stickslip.proofs.newton import NoZero
from stickslip.proofs.orbit import proven_orbit
from stickslip.proofs.power import Setting, step
from stickslip.proofs.system import number
from stickslip.proofs.wave import Undecided

BOXES: Final = 32  # to start with
SPLIT_FIRST: Final = 1e-3  # wider boxes are halved rather than followed along all possibilities
POSSIBILITIES: Final = 64
NARROWEST: Final = 1e-9  # an interval that is undecided at this width is reported


@dataclass(frozen=True)
class _Known:
    period: int
    points: tuple[arb, ...]
    alone: arb


class Survey:
    """All periodic orbits up to a period, and the intervals of d that may hold another one."""

    def __init__(self, setting: Setting, max_period: int, digits: int) -> None:
        self.orbits: list[dict[str, Any]] = []  # entries of certificates
        self.undecided: list[tuple[float, float]] = []
        self._setting, self._digits = setting, digits
        self._known: list[_Known] = []
        values = setting.values
        end = number((1 + values["beta"]) / (1 + 2 * values["alpha"]))
        for period in range(1, max_period + 1):
            # Balls round outward, so that neighbours overlap and nothing lies between them.
            waiting = [end * arb(k, 1) / BOXES for k in range(1 - BOXES, BOXES, 2)]
            while waiting:
                box = waiting.pop()
                if self._settled(box, period):
                    continue
                if box.rad() < NARROWEST:
                    self.undecided.append(outward(box))
                    continue
                half = box.rad() / 2
                waiting += [box.mid() + sign * half + arb(0, half) for sign in (-1, 1)]
        self.orbits.sort(key=lambda o: (o["period"], float(o["points"][0].split()[0])))

    def _settled(self, box: arb, period: int) -> bool:
        """Whether an interval holds no orbit of a period, or only one that is known by now."""
        if any(orbit.period == period and orbit.alone.contains(box) for orbit in self._known):
            return True
        (d,) = variables([box.mid()], [box.rad()])
        values = self._values(d, period, bool(box.rad() < SPLIT_FIRST))
        if values is None:
            return False
        if all(not value.range.overlaps(box) for value in values):
            return True
        if len(values) > 1:
            return False
        (value,) = values
        rate = value.gradient[0] - 1
        if not rate.is_finite() or rate.contains(0):
            return False
        new = box.mid() - (value.centre - box.mid()) / rate
        if not new.overlaps(box):
            return True
        # f^p - d is monotone: at most one root here.
        if self._holds_one(box, period):
            return True
        return self._new_orbit(new.intersection(box), period) and self._holds_one(box, period)

    def _holds_one(self, box: arb, period: int) -> bool:
        """Whether a known orbit, of the period or a divisor, has a point in the interval."""
        orbits = (orbit for orbit in self._known if period % orbit.period == 0)
        return any(box.contains(x) for orbit in orbits for x in orbit.points)

    def _values(self, d: Jet, period: int, forks: bool) -> list[Jet] | None:
        """Return all values of f^period on a box, or None if they are not known."""
        values = [d]
        for _ in range(period):
            try:
                steps = (step(self._setting, x, forks=8 if forks else 0) for x in values)
                values = [piece.value for pieces in steps for piece in pieces]
            except Undecided:
                return None
            if len(values) > POSSIBILITIES:
                return None
        return values

    def _new_orbit(self, near: arb, period: int) -> bool:
        """Prove an orbit that may be near, and take it up."""
        setting, digits = self._setting, self._digits
        try:
            point, alone, entries = proven_orbit(setting, near, period, digits)
            points = [point]
            for _ in range(period - 1):
                (piece,) = step(setting, variables([points[-1].mid()], [points[-1].rad()])[0])
                points.append(piece.value.range)
            lowest = min(points, key=float)
            if lowest is not point:
                entries = proven_orbit(setting, lowest, period, digits)[2]
        except (Undecided, NoZero):
            return False
        self._known.append(_Known(period, tuple(points), alone))
        self.orbits.append(entries)
        return True
