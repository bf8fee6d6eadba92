"""Branches proven: an orbit for every value of a parameter, alone in a tube around a polygon.

Docs: proofs, branches.
"""

from __future__ import annotations

import itertools
from fractions import Fraction
from functools import reduce
from math import floor, log10
from typing import Any, Final

from flint import arb

from stickslip.proofs.jet import Jet, box_of, variables
from stickslip.proofs.jump import proven_border
from stickslip.proofs.newton import NoZero
from stickslip.proofs.orbit import closing
from stickslip.proofs.power import Setting, along, step
from stickslip.proofs.system import decimal, fraction, middle_of, number
from stickslip.proofs.wave import Undecided

FIRST: Final = 64  # steps over the range, to begin with
SHORTEST: Final = 1e-3  # of the range: the step at which the orbit may be about to be lost
NEARER: Final = 0.8  # of the distance to where it is lost, taken in one step
ABOUT: Final = 8  # steps around a point in which the jump is looked for at which it is
ENOUGH: Final = 1e-9  # of a step: a place known so well is a node
FINEST: Final = 6  # halvings of a box for one step of the map
MOST_STEPS: Final = 1500
GUARD: Final = 5  # digits, beyond those of a border, to which the branch goes on
SPARE_PLACES: Final = 8  # of nodes, beyond the distance between them
ROUNDS: Final = 12  # of Newton's method, without proof
SLIM: Final = (0.1, 0.02)  # radius of the tube, as a share of how far it runs in d
CAUTION: Final = 3  # times its radius: what is proven of the tube, for balls are wider than jets
FLAT: Final = 0.1  # a line of a smaller slope counts as one of this


def in_tube(entries: dict[str, Any], low: Fraction, high: Fraction) -> arb:
    """Enclose the first point of a branch between two values of the parameter."""
    nodes = [(Fraction(p), Fraction(d)) for p, d in entries["nodes"]]
    found = []
    for ((p, d), (q, e)), radius in zip(itertools.pairwise(nodes), entries["radii"], strict=True):
        if p <= high and q >= low:
            line = (number(d + (e - d) * (x - p) / (q - p)) for x in (max(p, low), min(q, high)))
            found += [x + arb(0, number(Fraction(radius)).upper()) for x in line]
    return reduce(arb.union, found)


class Tube:
    """A branch followed from one value of the varied parameter to both ends of a range."""

    def __init__(
        self, setting: Setting, near: arb, start: Fraction, ends: tuple[Fraction, Fraction],
        period: int, digits: int,
    ) -> None:  # fmt: skip
        self.setting, self.period, self.digits = setting, period, digits
        self._span, self._steps, self._slim = ends[1] - ends[0], 0, SLIM[0]
        self.lost: list[dict[str, Any]] = []
        d = self._point(start, near, self._span * Fraction(SHORTEST))
        _, self.words, slope = along(setting, d, period, number(start))
        self.stable = bool(abs(slope) < 1)
        first = (start, self._place(d, self._span / FIRST))
        sides = [self._walk(first, end) for end in ends]
        (nodes, radii), (onward, others) = sides
        self.nodes = [*nodes[::-1], first, *onward]
        self.radii = [*radii[::-1], *others]

    def entries(self) -> dict[str, Any]:
        """Describe the branch."""
        return {
            "parameter": self.setting.varied[0],
            "period": self.period,
            "itinerary": self.words,
            "stable": self.stable,
            "nodes": [[decimal(p), decimal(d)] for p, d in self.nodes],
            "radii": self.radii,
            "lost": self.lost,
        }

    def _walk(
        self, node: tuple[Fraction, Fraction], end: Fraction
    ) -> tuple[list[tuple[Fraction, Fraction]], list[str]]:
        """Follow the branch to a value of the parameter, or to where its orbit is lost."""
        nodes, radii = [], []
        h, grows, sought = self._span / FIRST, True, False
        look = self._span * Fraction(SHORTEST)
        slope = Fraction(0)
        while node[0] != end:
            self._steps += 1
            if self._steps > MOST_STEPS:
                raise Undecided(f"the branch is proven no further than {float(node[0])!r}")
            if h < look and not sought:
                try:
                    end, sought = self._end(node, end, h * (1 + abs(slope))), True
                except Undecided:
                    look *= Fraction(SHORTEST)
                    if look < self._span * Fraction(SHORTEST) ** 3:
                        raise
            away = end - node[0]
            if sought and abs(away) > 20 * self._unit:
                h = min(h, abs(away) * Fraction(NEARER))
            size = Fraction(f"{float(h):.1e}")
            p = end if abs(away) <= size else node[0] + (size if away > 0 else -size)
            try:
                d = self._point(p, number(node[1] + slope * (p - node[0])), abs(p - node[0]))
                new = (p, self._place(d, abs(p - node[0])))
                radius = self._proven(*sorted((node, new)))
            except Undecided:
                h, grows = min(h, abs(away)) / 2, False
                continue
            slope = (new[1] - node[1]) / (new[0] - node[0])
            nodes.append(new)
            radii.append(radius)
            node = new
            h, grows = h * Fraction(3, 2) if grows else h, True
        return nodes, radii

    @property
    def _unit(self) -> Fraction:
        """How far from a border the branch ends, in tenths."""
        return Fraction(1, 10 ** (self.digits + GUARD + 1))

    def _end(self, node: tuple[Fraction, Fraction], end: Fraction, reach: Fraction) -> Fraction:
        """Prove that the orbit is lost near a node; where its branch then ends."""
        p, x = node[0], number(node[1])
        reason: Exception = Undecided("no point of the orbit is near a break")
        for _ in range(self.period):
            try:
                if len(self._step(p, x + arb(0, number(ABOUT * reach).upper()), forks=1)) == 1:
                    raise Undecided(str(reason))
                found = [
                    proven_border(self.setting, x.mid(), number(p).mid(), self.period, digits)
                    for digits in (self.digits, self.digits + GUARD + 3)
                ]
            except (NoZero, Undecided) as error:
                reason = error
            else:
                value = fraction("value", found[1]["value"].split()[0])
                if not min(p, end) < value < max(p, end):
                    return end
                self.lost.append(found[0])
                side = -1 if end > p else 1
                return round(value / self._unit) * self._unit + side * 10 * self._unit
            (piece,) = self._step(p, x)
            x = piece.value.range
        raise Undecided(f"the branch is proven no further than {float(p)!r}: {reason}")

    def _step(self, p: Fraction, x: arb, forks: int = 0) -> list[Any]:
        d, q = box_of(x, number(p))
        return step(self.setting, d, [q], forks=forks)

    def _point(self, p: Fraction, near: arb, length: Fraction) -> arb:
        """Find the orbit's point by Newton's method, without proof."""
        x, enough, last = near.mid(), number(length * Fraction(ENOUGH)), arb("inf")
        for _ in range(ROUNDS):
            box = variables([x, number(p).mid()], [arb(0)] * 2)
            (miss,) = closing(self.setting, self.period)(box)
            move = miss.centre / miss.gradient[0]
            x = (x - move).mid()
            if abs(move) < enough:
                return x
            if not abs(move) < last:
                break
            last = abs(move)
        raise Undecided(f"no orbit is found near d = {float(near):.6g} at {float(p):.6g}")

    def _place(self, d: arb, length: Fraction) -> Fraction:
        """Round a point to what the distance between two nodes asks for."""
        unit = Fraction(1, 10 ** (SPARE_PLACES - floor(log10(length))))
        return round(middle_of(d) / unit) * unit

    def _image(self, x: Jet, q: Jet, word: str, left: int) -> Jet:
        """Return the map on a box that has one itinerary, if only in parts: near a graze."""
        try:
            (piece,) = step(self.setting, x, [q])
            if piece.itinerary != word:
                raise Undecided(f"the itinerary changes to {piece.itinerary!r}")
        except Undecided:
            if not left:
                raise
        else:
            found: Jet = piece.value
            return found
        halves = [self._image(*half, word, left - 1) for half in _halves(x, q)]
        still = [Jet(y.centre, y.centre, y.gradient, (arb(0),) * 2) for y in (x, q)]
        (middle,) = step(self.setting, still[0], still[1:])
        slopes = tuple(a.union(b) for a, b in zip(*(y.gradient for y in halves), strict=True))
        whole = halves[0].range.union(halves[1].range)
        return Jet(middle.value.range, whole, slopes, x.box).tight()

    def _proven(self, low: tuple[Fraction, Fraction], high: tuple[Fraction, Fraction]) -> str:
        """Prove that one orbit is in the tube between two nodes; the tube's radius."""
        # Wide tubes hold bent branches, slim ones fit beside a graze: what did last comes first.
        reason: Exception = Undecided("")
        for slim in sorted(SLIM, key=lambda each: each != self._slim):
            try:
                radius = self._alone(low, high, slim)
            except Undecided as error:
                reason = error
            else:
                self._slim = slim
                return radius
        raise reason

    def _alone(
        self, low: tuple[Fraction, Fraction], high: tuple[Fraction, Fraction], slim: float
    ) -> str:
        """Prove it of a tube as wide as a share of how far it runs."""
        # Coordinates: the distance from the line through the nodes, and the parameter.
        run, rise = high[0] - low[0], high[1] - low[1]
        slope = number(rise / run)
        radius = f"{slim * float(run) * max(abs(float(rise / run)), FLAT):.0e}"
        p, half = number((low[0] + high[0]) / 2), number(run / 2)
        across, q = variables(
            [arb(0), p.mid()], [CAUTION * number(Fraction(radius)), half + p.rad()]
        )
        d = across + (q - p) * slope + number((low[1] + high[1]) / 2)
        x, points = d, []
        for word in self.words:
            points.append(x.range)
            x = self._image(x, q, word, FINEST)
        miss = x - d
        rate, drift = miss.gradient
        if not (abs(rate + 1) < 1 if self.stable else abs(rate + 1) > 1):
            raise Undecided("the multiplier cannot be told from 1 in size")
        if not abs(miss.centre + drift * q.box[1]) < number(Fraction(radius)) * abs(rate):
            raise Undecided("Newton's step leaves the tube")
        if any(a.overlaps(b) for a, b in itertools.pairwise(sorted(points, key=arb.mid))):
            raise Undecided("two points of the orbit are not told apart")
        return radius


def _halves(x: Jet, q: Jet) -> list[tuple[Jet, Jet]]:
    """Cut a box of two coordinates across the one along which x spreads more."""
    across, along = (slope * side for slope, side in zip(x.gradient, x.box, strict=True))
    k = int(along.rad() > across.rad())
    half = x.box[k].rad() / 2
    box = tuple(arb(0, half) if i == k else side for i, side in enumerate(x.box))

    def moved(y: Jet, shift: arb) -> Jet:
        return Jet(y.centre + shift * y.gradient[k], y.range, y.gradient, box).tight()

    return [(moved(x, shift), moved(q, shift)) for shift in (-half, half)]
