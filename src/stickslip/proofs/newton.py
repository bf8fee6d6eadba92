"""Interval Newton: boxes that are proven to hold one zero, or none.

Docs: proofs, existence and uniqueness.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from flint import arb, arb_mat, ctx

from stickslip.proofs.jet import Jet, precision, variables
from stickslip.proofs.wave import Undecided

ROUNDS: Final = 30
SEARCH_BITS: Final = 128  # until a zero is proven; its digits need more
POLISHING: Final = 6  # steps of Newton's method without proof
NEAR: Final = 1e-12  # a step so small that the next is none


class NoZero(Exception):
    """There is proven to be no zero in the box."""


def zero(
    equations: Callable[[list[Jet]], Sequence[Jet]],
    start: Sequence[arb],
    radii: Sequence[float],
    *,
    target: arb,
) -> tuple[list[arb], list[arb]]:
    """Prove that equations have one zero near a point: its enclosure, and where it is alone.

    `radii` are boxes to try around the start, the widest first; `target` is the radius asked for.
    `NoZero`: the widest box that could be decided holds none. `Undecided`: none could be decided.
    """
    reason = Undecided("no box was tried")
    for radius in radii:
        centres = [x.mid() for x in start]
        widths = [arb(radius)] * len(centres)
        box = [c + arb(0, w) for c, w in zip(centres, widths, strict=True)]
        try:
            with precision(min(ctx.prec, SEARCH_BITS)):
                new = _step(equations, centres, widths)
        except Undecided as error:
            reason = error
            continue
        if any(not a.overlaps(b) for a, b in zip(new, box, strict=True)):
            raise NoZero(f"there is none within {radius:.1g} of the place given")
        if all(b.contains_interior(a) for a, b in zip(new, box, strict=True)):
            return _refined(equations, new, target), box
        reason = Undecided(f"Newton's step leaves a box of radius {radius:.1g}")
    raise reason


def nearer(
    equations: Callable[[list[Jet]], Sequence[Jet]], start: list[arb], reach: float
) -> list[arb]:
    """Improve a starting point by Newton's method, without proof, no further than `reach`."""
    at, still = start, [arb(0)] * len(start)
    with precision(min(ctx.prec, SEARCH_BITS)):
        for _ in range(POLISHING):
            before = at
            try:
                at = [x.mid() for x in _step(equations, [x.mid() for x in before], still)]
            except Undecided:
                return start
            if not all(abs(x - y) <= reach for x, y in zip(at, start, strict=True)):
                return start
            if all(abs(x - y) <= NEAR for x, y in zip(at, before, strict=True)):
                break
    return at


def _step(
    equations: Callable[[list[Jet]], Sequence[Jet]], centres: list[arb], widths: list[arb]
) -> list[arb]:
    """Enclose all zeros of a box: centre - J(box)^-1 F(centre)."""
    values = equations(variables(centres, widths))
    matrix = arb_mat([list(value.gradient) for value in values])
    side = arb_mat([[value.centre] for value in values])
    try:
        move = matrix.solve(side)
    except ZeroDivisionError:
        raise Undecided("the derivative may vanish in the box") from None
    new = [c - move[i, 0] for i, c in enumerate(centres)]
    if not all(x.is_finite() for x in new):
        raise Undecided("the derivative may vanish in the box")
    return new


def _refined(
    equations: Callable[[list[Jet]], Sequence[Jet]], found: list[arb], target: arb
) -> list[arb]:
    """Contract an enclosure of the zero until it is narrow enough."""
    for _ in range(ROUNDS):
        if all(x.rad() <= target for x in found):
            return found
        new = _step(equations, [x.mid() for x in found], [x.rad() for x in found])
        found = [a.intersection(b) for a, b in zip(new, found, strict=True)]
    raise Undecided("the precision is too low for the digits asked for")
