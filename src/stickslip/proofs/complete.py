"""Complete lists: every periodic orbit up to a period, by branch and bound over the domain.

Docs: proofs, complete lists.
"""

from __future__ import annotations

from dataclasses import dataclass, field
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


@dataclass
class Survey:
    """What a search of the domain found."""

    # entries of certificates, by period and smallest point
    orbits: list[dict[str, Any]] = field(default_factory=list)
    # intervals of d that may hold another orbit
    undecided: list[tuple[float, float]] = field(default_factory=list)
    boxes: int = 0  # intervals that were looked at


@dataclass(frozen=True)
class _Known:
    period: int
    points: tuple[arb, ...]
    alone: arb


def survey(setting: Setting, max_period: int, digits: int, *, narrowest: float = 1e-9) -> Survey:
    """Find all periodic orbits up to a period, or intervals, as narrow as asked, of more."""
    found = Survey()
    known: list[_Known] = []
    values = setting.values
    end = number((1 + values["beta"]) / (1 + 2 * values["alpha"]))
    for period in range(1, max_period + 1):
        # Balls round outward, so that neighbours overlap and nothing lies between them.
        waiting = [end * arb(k, 1) / BOXES for k in range(1 - BOXES, BOXES, 2)]
        while waiting:
            box = waiting.pop()
            found.boxes += 1
            if _settled(setting, box, period, known, found, digits):
                continue
            if box.rad() < narrowest:
                found.undecided.append(outward(box))
                continue
            half = box.rad() / 2
            waiting += [box.mid() + sign * half + arb(0, half) for sign in (-1, 1)]
    found.orbits.sort(key=lambda o: (o["period"], float(o["points"][0].split()[0])))
    return found


def _settled(
    setting: Setting,
    box: arb,
    period: int,
    known: list[_Known],
    found: Survey,
    digits: int,
) -> bool:
    """Whether an interval holds no orbit of a period, or only one that is known by now."""
    if any(orbit.period == period and orbit.alone.contains(box) for orbit in known):
        return True
    (d,) = variables([box.mid()], [box.rad()])
    values = _values(setting, d, period, bool(box.rad() < SPLIT_FIRST))
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
    if _holds_one(box, period, known):
        return True
    near = new.intersection(box)
    return _new_orbit(setting, near, period, known, found, digits) and _holds_one(
        box, period, known
    )


def _holds_one(box: arb, period: int, known: list[_Known]) -> bool:
    """Whether a known orbit, of the period or a divisor, has a point in the interval."""
    orbits = (orbit for orbit in known if period % orbit.period == 0)
    return any(box.contains(x) for orbit in orbits for x in orbit.points)


def _values(setting: Setting, d: Jet, period: int, forks: bool) -> list[Jet] | None:
    """Return all values of f^period on a box, or None if they are not known."""
    values = [d]
    for _ in range(period):
        try:
            pieces = [p for x in values for p in step(setting, x, forks=8 if forks else 0)]
        except Undecided:
            return None
        if len(pieces) > POSSIBILITIES:
            return None
        values = [piece.value for piece in pieces]
    return values


def _new_orbit(
    setting: Setting, near: arb, period: int, known: list[_Known], found: Survey, digits: int
) -> bool:
    """Prove an orbit that may be near, and take it up."""
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
    known.append(_Known(period, tuple(points), alone))
    found.orbits.append(entries)
    return True
