"""Periodic orbits proven, their stability, and the parameter values at which they fold or flip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

from flint import arb

from stickslip.proofs.germ import Germ, germ
from stickslip.proofs.jet import Jet, box_of, precision
from stickslip.proofs.newton import nearer, zero
from stickslip.proofs.power import MapSetting, Setting, follow
from stickslip.proofs.verify.words import rounded
from stickslip.proofs.wave import Undecided

RADII: Final = tuple(10.0**-k for k in range(4, 15))
MULTIPLIERS: Final = {"fold": 1, "flip": -1}
CRITICAL_RADII: Final = tuple(10.0**-k for k in range(5, 20, 3))
FORM_BITS: Final = 112  # beyond the digits of the normal form


def closing(setting: MapSetting, period: int) -> Callable[[list[Jet]], list[Jet]]:
    """Return f^period(d) - d as a function of a box, where the itinerary can be proven."""

    def equations(box: list[Jet]) -> list[Jet]:
        d, *parameters = box
        *_, end = follow(setting, d, parameters, period)
        return [end - d]

    return equations


def proven_orbit(
    setting: MapSetting, near: arb, period: int, digits: int
) -> tuple[arb, arb, dict[str, Any]]:
    """Prove the orbit through a point: its point, the ball where it is alone, its entries."""
    target = arb(10) ** (-digits - 12)
    (point,), (box,) = zero(closing(setting, period), [near], RADII, target=target)
    for share in setting.shares:
        alone = f"{float(box.rad()) / share:.0e}"
        ball = point + arb(0, 2 * arb(alone).upper())
        if box.contains_interior(ball):
            entries = _entries(setting, point, period, digits, alone)
            if not entries["stable"] or _contracts(setting, ball, period):
                return point, box, entries
    raise Undecided("the orbit is too near the end of the interval in which it is alone")


def _contracts(setting: MapSetting, ball: arb, period: int) -> bool:
    """Whether f^period brings all points of a ball closer to each other."""
    (x,) = box_of(ball)
    (value,) = closing(setting, period)([x])
    return bool(abs(value.gradient[0] + 1) < 1)


def _entries(
    setting: MapSetting, point: arb, period: int, digits: int, alone: str
) -> dict[str, Any]:
    """Describe an orbit whose existence near a point is proven."""
    (x,) = box_of(point)
    places, words, end = follow(setting, x, (), period)
    points = [each.range for each in places]
    if any(a.overlaps(b) for i, a in enumerate(points) for b in points[:i]):
        raise Undecided("two of its points coincide: a shorter period returns there")
    multiplier = end.gradient[0]
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


def proven_critical(
    kind: str, setting: Setting, near: arb, value: arb, period: int, digits: int
) -> dict[str, Any]:
    """Prove that an orbit folds or flips (`kind`) at one value of the varied parameter."""
    # `near` and `value` are a point of the orbit and the parameter, nearly.
    multiplier = MULTIPLIERS[kind]

    def equations(box: list[Jet]) -> list[Jet]:
        end, slope, *_ = _round(setting, box, period, 1)[2].coefficients
        return [end - box[0], slope - multiplier]

    start = nearer(equations, [near, value], CRITICAL_RADII[0])
    found, _ = zero(equations, start, CRITICAL_RADII, target=arb(10) ** (-digits - 12))
    box = box_of(*found)
    with precision(4 * digits + FORM_BITS):
        starts, words, end = _round(setting, box, period, 1 if kind == "fold" else 3)
    points = [start.coefficients[0].range for start in starts]
    if any(a.overlaps(b) for i, a in enumerate(points) for b in points[:i]):
        raise Undecided("two points of the orbit coincide: a shorter period returns there")
    told = _fold(end) if kind == "fold" else _flip(end)
    return {
        "parameter": setting.varied[0],
        "value": rounded(found[1], digits),
        "period": period,
        "points": [rounded(x, digits) for x in points],
        "itinerary": words,
        **{name: x if isinstance(x, str) else rounded(x, digits) for name, x in told.items()},
    }


def _round(
    setting: MapSetting, box: Sequence[Jet], period: int, order: int
) -> tuple[list[Germ], list[str], Germ]:
    """Follow an orbit once, with derivatives in its first point up to an order."""
    d, *parameters = box
    return follow(setting, germ(d, order), parameters, period)


def _fold(end: Germ) -> dict[str, arb | str]:
    """Say on which side the two orbits exist: (q - q_0) f_q f'' < 0."""
    curvature = end.coefficients[1].gradient[0]
    push = end.coefficients[0].gradient[1]
    return {"curvature": curvature, "exists": _side(-push * curvature)}


def _flip(end: Germ) -> dict[str, arb | str]:
    """Say where the orbit is stable, and where one of twice the period is."""
    # The multiplier leaves -1 at a rate r; the orbit is stable where r (q - q_0) > 0, and the other
    # exists where c r (q - q_0) < 0.
    value, slope, bend, third = end.coefficients
    drift = value.gradient[1] / (1 - value.gradient[0])  # of the point along the branch
    rate = slope.gradient[1] + slope.gradient[0] * drift
    cubic = third.range + bend.range**2
    return {
        "rate": rate,
        "cubic": cubic,
        "stable": _side(rate),
        "doubled": _side(-rate * cubic),
    }


def _side(sign: arb) -> str:
    if sign > 0:
        return "above"
    if sign < 0:
        return "below"
    raise Undecided("a coefficient of the normal form cannot be told from 0")
