"""Periodic orbits proven: existence, uniqueness, points, multiplier, stability."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from flint import arb

from stickslip.proofs.jet import Jet, variables
from stickslip.proofs.newton import zero
from stickslip.proofs.power import Setting, step
from stickslip.proofs.smooth import Falling
from stickslip.proofs.system import law_of
from stickslip.proofs.verify.words import rounded
from stickslip.proofs.wave import Undecided

RADII: Final = tuple(10.0**-k for k in range(4, 15))


def closing(setting: Setting, period: int) -> Callable[[list[Jet]], list[Jet]]:
    """Return f^period(d) - d as a function of a box, where the itinerary can be proven."""

    def equations(box: list[Jet]) -> list[Jet]:
        d, *parameters = box
        x = d
        for _ in range(period):
            (piece,) = step(setting, x, parameters)
            x = piece.value
        return [x - d]

    return equations


def proven_orbit(
    setting: Setting, near: arb, period: int, digits: int
) -> tuple[arb, arb, dict[str, Any]]:
    """Prove the orbit through a point: its point, the ball where it is alone, its entries."""
    target = arb(10) ** (-digits - 12)
    (point,), (box,) = zero(closing(setting, period), [near], RADII, target=target)
    # What the second program confirms: it follows law (9) without the mean value form.
    shares = (10**7, 10**8) if law_of(setting.values) is Falling else (100, 1000, 10000)
    for share in shares:
        alone = f"{float(box.rad()) / share:.0e}"
        ball = point + arb(0, 2 * arb(alone).upper())
        if box.contains_interior(ball):
            entries = _entries(setting, point, period, digits, alone)
            if not entries["stable"] or _contracts(setting, ball, period):
                return point, box, entries
    raise Undecided("the orbit is too near the end of the interval in which it is alone")


def _contracts(setting: Setting, ball: arb, period: int) -> bool:
    """Whether f^period brings all points of a ball closer to each other."""
    (x,) = variables([ball.mid()], [ball.rad()])
    (value,) = closing(setting, period)([x])
    return bool(abs(value.gradient[0] + 1) < 1)


def _entries(setting: Setting, point: arb, period: int, digits: int, alone: str) -> dict[str, Any]:
    """Describe an orbit whose existence near a point is proven."""
    (x,) = variables([point.mid()], [point.rad()])
    points, words = [], []
    for _ in range(period):
        points.append(x.range)
        (piece,) = step(setting, x)
        words.append(piece.itinerary)
        x = piece.value
    if any(a.overlaps(b) for i, a in enumerate(points) for b in points[:i]):
        raise Undecided("two of its points coincide: a shorter period returns there")
    multiplier = x.gradient[0]
    if not (abs(multiplier) < 1 or abs(multiplier) > 1):
        raise Undecided(f"the multiplier {multiplier} cannot be told from 1 in size")
    return {
        "period": period,
        "points": [rounded(each, digits) for each in points],
        "itinerary": words,
        "multiplier": rounded(multiplier, digits),
        "stable": bool(abs(multiplier) < 1),
        "alone": alone,
    }
