"""Check what certificates claim."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import reduce
from typing import Any, Final

from flint import arb, arb_series, ctx

from stickslip.proofs.verify.branch import check_branch, in_tube
from stickslip.proofs.verify.cover import check_basins, check_curves, check_no_other
from stickslip.proofs.verify.expansion import check_expansion
from stickslip.proofs.verify.falling import FallingMotion
from stickslip.proofs.verify.formulas import FormulaMotion
from stickslip.proofs.verify.horseshoe import check_horseshoe
from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import (
    Basins,
    Border,
    Branch,
    Certificate,
    CertificateOfFormulas,
    Curves,
    Expansion,
    Flip,
    Fold,
    Formulas,
    Horseshoe,
    Jump,
    List,
    Orbit,
    Refused,
    Varied,
    ball,
    check_apart,
    followed,
    read,
    rounded,
)

WIDE_BITS: Final = 128  # where intervals are wide
MOST_PARTS: Final = 20_000  # of an interval beside a jump
LEAST: Final = 1e-6  # of the distance from it: a part
GROWTH: Final = 1.03  # of parts, from one to the next
NARROWEST: Final = 1e-12  # an interval of d, before it counts as undecided


def _motion(values: dict[str, str] | Formulas, **replaced: arb) -> Any:
    """Return the motion of a system under the law that its parameters tell; or a map."""
    if isinstance(values, Formulas):
        return FormulaMotion(values)
    falling = "gamma_1" in {*values, *replaced}
    return (FallingMotion if falling else Motion)(values, **replaced)


def _matches(name: str, text: str, found: arb, digits: int) -> None:
    """Refuse a decimal that is not the value found, rounded to its last digit."""
    try:
        expected = rounded(found, digits)
    except (ValueError, OverflowError) as error:
        raise Refused(f"{name} cannot be checked: {error}") from None
    if text != expected:
        raise Refused(f"{name} is stated as {text}, and is {expected}")


def _orbit(motion: Motion, c: Orbit, digits: int) -> None:
    """Check an orbit: where it is, how far it is alone, and what it does to what is near."""
    points = [ball(text) for text in c.points]
    tight, _ = _branch(motion, c.itinerary, points[0].mid(), arb(10) ** (-digits - 20))
    found, _, slope = followed(motion, tight, c.itinerary)
    for k, (text, x) in enumerate(zip(c.points, found, strict=True)):
        _matches(f"points[{k}]", text, x, digits)
    _matches("multiplier", c.multiplier, slope, digits)
    _distinct(points)
    if not (abs(slope) < 1 if c.stable else abs(slope) > 1):
        raise Refused(f"stable is stated as {c.stable}, the multiplier is {slope.str(12)}")
    alone = ball(c.alone)
    if not tight.rad() < alone / 2:
        raise Refused(f"alone = {c.alone} is less than the orbit is known to")
    *_, slope = followed(motion, tight.mid() + arb(0, (2 * alone).upper()), c.itinerary)
    if (slope - 1).contains(0):
        raise Refused(f"the orbit is not shown to be alone within {c.alone}")
    if c.stable and not abs(slope) < 1:
        raise Refused(f"the orbit is not shown to attract all points within {c.alone}")


def _distinct(points: list[arb]) -> None:
    """Refuse points of which two may be one: of an orbit, or of a list of orbits."""
    check_apart(points, "two points coincide: a period is not minimal, or an orbit is listed twice")


def _bisected(
    motion: Motion, low: arb, high: arb, words: list[str], digits: int
) -> tuple[arb, arb]:
    """Close in on where the itinerary changes from the one to the other."""
    if words[0] == words[1]:
        raise Refused(f"the itinerary is stated as {words[0]!r} on both sides")
    for x, word in ((low, words[0]), (high, words[1])):
        if (found := motion.step(x)[0]) != word:
            raise Refused(
                f"the itinerary at {x.str(digits, radius=False)} is stated as {word!r} "
                f"and is {found!r}"
            )
    while high - low > arb(10) ** (-digits - 14):
        middle = (low + (high - low) * arb(0.4375)).mid()
        found = motion.step(middle)[0]
        if found not in words:
            raise Refused(f"a third itinerary, {found!r}, lies between the two")
        low, high = (middle, high) if found == words[0] else (low, middle)
    return low, high


def _jump(motion: Motion, c: Jump, digits: int) -> None:
    """Check a jump: both sides, and that the map is not continuous between them."""
    stated = ball(c.d)
    low, high = (stated.mid() + sign * 3 * stated.rad() for sign in (-1, 1))
    words = [c.itinerary_left, c.itinerary_right]
    low, high = _bisected(motion, low.mid(), high.mid(), words, digits)
    _matches("d", c.d, low.union(high), digits)
    for name, text, x in (("left", c.left, low), ("right", c.right, high)):
        _matches(name, text, motion.step(x)[1], digits)
    _discontinuous(motion, low, high)


def _discontinuous(motion: Motion, low: arb, high: arb) -> None:
    """Refuse unless f leaves out a value between those at two points."""
    a, b = (motion.step(x)[1] for x in (low, high))
    between = ((a + b) / 2).mid()
    taken = [value for _, value, _ in motion.outcomes(low.union(high))]
    if not (a < between < b or b < between < a) or any(x.contains(between) for x in taken):
        raise Refused(f"no jump is shown at d = {low.str(12, radius=False)}")


class _Side:
    """The jump near the orbit's first point, at one value of the parameter."""

    # Its `ends` have the stated itineraries, `edge` is the one on the orbit's side, and `miss` is
    # how far f^period of `edge` misses it.

    def __init__(self, motion: Motion, c: Border, digits: int) -> None:
        stated, reach = ball(c.points[0]), ball(c.reach).mid()
        low, high = (stated.mid() - reach).mid(), (stated.mid() + reach).mid()
        words = [motion.step(x)[0] for x in (low, high)]
        if sorted(words) != sorted([c.itinerary[0], c.itinerary_beyond]):
            raise Refused(
                f"around d = {c.points[0]} the itineraries are stated as {c.itinerary[0]!r} and "
                f"{c.itinerary_beyond!r}, and are {words[0]!r} and {words[1]!r}"
            )
        self.motion = motion
        self.ends = _bisected(motion, low, high, words, digits)
        self.edge = self.ends[words.index(c.itinerary[0])]
        self.miss = followed(motion, self.edge, c.itinerary)[1] - self.edge


def _border(values: dict[str, str], c: Border, digits: int) -> tuple[arb, list[arb]]:
    """Check that the orbit is there on one side of a parameter value, and lost on the other."""
    # Returns the parameter on the side where it is, and its points there.
    # Where the jump's one-sided image returns to it only says where to look.
    stated = ball(c.value)
    low, high = ((stated.mid() + sign * stated.rad()).mid() for sign in (-1, 1))
    sides = [_Side(_at(values, c, p), c, digits) for p in (low, high)]
    if not sides[0].miss * sides[1].miss < 0:
        raise Refused(f"value is stated as {c.value}, but nothing changes there")
    for width in (arb(10) ** (-digits - 4), 2 * arb(10) ** (-digits - 5)):
        a, b = (side.miss for side in sides)
        root = (low - a * (high - low) / (b - a)).mid()  # of the secant
        low, high = (root - width).mid(), (root + width).mid()
        if not (stated.contains(low) and stated.contains(high)):
            raise Refused(f"value is stated as {c.value}, and is {root.str(digits, radius=False)}")
        sides = [_Side(_at(values, c, p), c, digits) for p in (low, high)]
    there, without = sides if c.exists == "below" else sides[::-1]
    x, _ = _branch(there.motion, c.itinerary, there.edge, arb(10) ** (-digits - 20))
    points, *_ = followed(there.motion, x, c.itinerary)
    for k, (text, x) in enumerate(zip(c.points, points, strict=True)):
        if not ball(text).contains(x):
            raise Refused(f"points[{k}] is stated as {text}, and is {x.str(digits)}")
    _distinct(points)
    for side in sides:
        _discontinuous(side.motion, *side.ends)
    _lost(without, c, digits)
    return low if c.exists == "below" else high, points


def _lost(side: _Side, c: Border, digits: int) -> None:
    """Refuse unless no orbit with the itinerary has a point near the jump."""
    # From the edge on, f^period(d) - d is monotone and goes away from 0, or has another itinerary.
    motion, word = side.motion, c.itinerary[0]
    low, high = _narrowed(motion, *side.ends, word, arb(10) ** (-3 * digits - 4))
    left = motion.step(low)[0] == word
    near, reach = ball(c.points[0]).mid(), ball(c.reach)
    ends = [((near - reach).lower(), low), ((near + reach).upper(), high)]
    here, there = ends if left else ends[::-1]
    gap = low.union(high)
    if any(told == word for told, _, _ in _parts(motion, *there, gap.mid())):
        raise Refused(f"the itinerary {word!r} is on both sides of the jump")
    found = _parts(motion, *here, gap.mid())
    if any(told != word for told, _, _ in found):
        raise Refused(f"the itinerary is not {word!r} on all of one side of the jump")
    value = reduce(arb.union, (x for _, x, _ in found))
    slope = reduce(arb.union, (rate for _, _, rate in found))
    *_, rate = followed(motion, value, c.itinerary[1:])
    edge = low if left else high
    miss = followed(motion, edge, c.itinerary)[1] - edge
    if not miss * (slope * rate - 1) * (-1 if left else 1) > 0:
        raise Refused(f"the orbit is not shown to be lost: {edge.str(digits)} comes near itself")
    for told, value, _ in motion.outcomes(gap):
        if told == word and followed(motion, value, c.itinerary[1:])[1].overlaps(gap):
            raise Refused(f"the orbit is not shown to be lost: one may pass d = {gap.str(digits)}")


def _narrowed(motion: Motion, low: arb, high: arb, word: str, width: arb) -> tuple[arb, arb]:
    """Close in on where an itinerary ends that one of two points has."""
    first = motion.step(low)[0] == word
    while high - low > width:
        middle = (low + (high - low) * arb(0.4375)).mid()
        same = (motion.step(middle)[0] == word) is first
        low, high = (middle, high) if same else (low, middle)
    return low, high


def _parts(motion: Motion, far: arb, near: arb, jump: arb) -> list[tuple[str, arb, arb]]:
    """Return what the map does on parts that cover an interval up to nearly a jump."""
    # They shrink with the distance: a part that is too wide takes ten times longer to refuse.
    found, share = [], arb(0.25)
    while far != near:
        to = (far + (jump - far) * share).mid()
        if abs(to - jump) <= abs(near - jump):
            to = near
        try:
            found.append(motion.step(far.union(to)))
        except Refused:
            if share < LEAST or len(found) > MOST_PARTS:
                raise
            share = (share * 0.6).mid()
        else:
            far, share = to, (share * GROWTH).mid()
    return found


def _along(values: dict[str, str], c: Branch, digits: int) -> None:
    """Check a branch, and that it goes on to where its orbit is said to be lost."""
    check_branch(values, _names(c.parameter), c)
    for border in c.lost:
        end = c.nodes[-1 if border.exists == "below" else 0][0]
        if not ball(border.value).contains(ball(end)):
            raise Refused(f"the branch ends at {end} and is lost at {border.value}")
        p, points = _border(values, border, digits)
        if not any(in_tube(c, p, x) for x in points):
            raise Refused(f"the orbit lost at {border.value} is not shown to be that of the branch")


def _at(values: dict[str, str], c: Varied, p: arb) -> Motion:
    """Return the motion at a value of the varied parameter."""
    return _motion(values, **dict.fromkeys(_names(c.parameter), p))


def _names(parameter: str) -> tuple[str, ...]:
    """Names in the system that a varied parameter stands for."""
    both = parameter in ("mu", "gamma", "delta", "eta")
    return (f"{parameter}_1", f"{parameter}_2") if both else (parameter,)


def _side(sign: arb) -> str:
    """Where something is that is above a value if a number is positive, below if negative."""
    if sign.contains(0):
        raise Refused("a coefficient of the normal form cannot be told from 0")
    return "above" if sign > 0 else "below"


def _fold(values: dict[str, str], c: Fold, digits: int) -> None:
    """Check where the extremum of f^period(d) - d passes 0, and how it bends there."""
    p, x, rate = _passed(values, c, digits, _extremum, "two orbits do not meet")
    series = _critical(values, c, digits, p, x, 2)
    curvature = 2 * series[2]
    _matches("curvature", c.curvature, curvature, digits)
    if c.exists != _side(-rate * curvature):
        raise Refused("the side of the fold is not that of its coefficients")


def _flip(values: dict[str, str], c: Flip, digits: int) -> None:
    """Check where the multiplier along the orbit's branch passes -1, how, and how it doubles."""
    p, x, rate = _passed(values, c, digits, _flipped, "the multiplier does not pass -1")
    series = _critical(values, c, digits, p, x, 3)
    _matches("rate", c.rate, rate, digits)
    cubic = series[3] + series[2] ** 2
    _matches("cubic", c.cubic, cubic, digits)
    if (c.stable, c.doubled) != (_side(rate), _side(-rate * cubic)):
        raise Refused("the sides of the flip are not those of its coefficients")


def _passed(
    values: dict[str, str],
    c: Varied,
    digits: int,
    tell: Callable[[Motion, list[str], arb, arb], tuple[arb, arb]],
    otherwise: str,
) -> tuple[arb, arb, arb]:
    """Enclose where a condition passes 0: parameter, point, and the derivative somewhere there."""
    # `tell` encloses the point and the condition at one value of the parameter, or for all values
    # in a ball, given a point nearby.
    stated = ball(c.value)
    x, wide = ball(c.points[0]).mid(), arb(10) ** (-digits - 4)
    low, high = ((stated.mid() + sign * stated.rad()).mid() for sign in (-1, 1))

    def at(p: arb, x: arb, radius: arb) -> tuple[arb, arb]:
        return tell(_at(values, c, p), c.itinerary, x, radius)

    found = [at(p, x, wide * arb(10) ** -15) for p in (low, high)]
    (_, a), (_, b) = found
    if not a * b < 0:
        raise Refused(f"value is stated as {c.value}, but {otherwise} there")
    for narrowed in (0, 8, 22, 30):
        width = wide * arb(10) ** -narrowed
        share = (a / (a - b)).mid()  # of the secant; what follows proves what it found
        root = (low + share * (high - low)).mid()
        drift = (found[1][0] - found[0][0]) / (high - low)
        starts = [
            (p, (found[0][0] + drift * (p - low)).mid())
            for p in ((root - width).mid(), (root + width).mid())
        ]
        (low, _), (high, _) = starts
        radius = width * arb(10) ** (-digits - 22)
        found = [at(p, x, radius) for p, x in starts]
        (_, a), (_, b) = found
        if not a * b < 0:
            raise Refused("the place of the bifurcation cannot be told to its last digit")
    # One curve joins the two ends, along which the condition passes 0.
    between, ends = low.union(high), found[0][0].union(found[1][0])
    x, _ = at(between, ends.mid(), width * arb(10) ** 14)
    return between, x, (b - a) / (high - low)


def _critical(
    values: dict[str, str], c: Varied, digits: int, p: arb, x: arb, order: int
) -> arb_series:
    """Check value and points at a fold or flip; return the power series of f^period in d."""
    _matches("value", c.value, p, digits)
    points, series = _series(_at(values, c, p), c.itinerary, x, order)
    for k, (text, point) in enumerate(zip(c.points, points, strict=True)):
        _matches(f"points[{k}]", text, point, digits)
    _distinct(points)
    return series


def _flipped(motion: Motion, words: list[str], x: arb, radius: arb) -> tuple[arb, arb]:
    """Enclose the orbit's point near x, and its multiplier + 1."""
    x, slope = _branch(motion, words, x, radius)
    return x, slope + 1


def _extremum(motion: Motion, words: list[str], x: arb, radius: arb) -> tuple[arb, arb]:
    """Enclose the point near x where (f^p)' = 1, and f^p(d) - d there."""
    for _ in range(8):  # Newton's steps without proof; what follows proves where they led
        _, here = _series(motion, words, x, 2)
        move = (here[1] - 1) / (2 * here[2])
        if abs(move) < radius / 4:
            break
        x = (x - move).mid()
    near = x + arb(0, radius.upper())
    _, around = _series(motion, words, near, 2)
    new = x - (here[1] - 1) / (2 * around[2])
    if not near.contains_interior(new):
        raise Refused(f"no extremum is shown near d = {x.str(12, radius=False)}")
    return new, here[0] - x + (around[1] - 1) * (new - x)


def _branch(motion: Motion, words: list[str], x: arb, radius: arb) -> tuple[arb, arb]:
    """Enclose the first point of an orbit near x, and its multiplier, by Newton's method."""
    for _ in range(3):  # without proof; what follows proves where they led
        _, end, slope = followed(motion, x, words)
        x = (x - (end - x) / (slope - 1)).mid()
    near = x + arb(0, radius.upper())
    _, end, _ = followed(motion, x, words)
    *_, slope = followed(motion, near, words)
    new = x - (end - x) / (slope - 1)
    if not near.contains_interior(new):
        raise Refused(f"no such orbit is shown near d = {x.str(12, radius=False)}")
    return new, slope


def _series(motion: Motion, words: list[str], x: arb, order: int) -> tuple[list[arb], arb_series]:
    """Return the orbit's points, and the power series of f^period in d up to an order."""
    ctx.cap, before = order + 1, ctx.cap
    points, total = [], arb_series([x, 1])
    for word in words:
        points.append(total[0])
        shift = arb_series([0, *(total[k] for k in range(1, order + 1))])
        found, series = motion.series(total[0])
        if found != word:
            raise Refused(f"the itinerary is stated as {word!r} and is {found!r}")
        total = series(shift)
    ctx.cap = before
    return points, total


def _list(motion: Motion, c: List, digits: int) -> None:
    """Check each orbit of a list, and that there is no other."""
    known = [(orbit.period, ball(text)) for orbit in c.orbits for text in orbit.points]
    _distinct([x for _, x in known])
    for orbit in c.orbits:
        _orbit(motion, orbit, digits)
    ctx.prec = WIDE_BITS
    stated = [ball(low).union(ball(high)) for low, high in c.undecided]
    for period in range(1, c.max_period + 1):
        roots = [x for p, x in known if period % p == 0]
        check_no_other(motion, motion.boxes(32), period, roots, NARROWEST, stated=stated)


def check(document: Any) -> Certificate | CertificateOfFormulas:
    """Check a certificate, or raise `Refused`: every word of its statement is then proven."""
    c = read(document)
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = 10 * c.digits + 100, 2
    if isinstance(c.theorem, Flip | Fold):  # differences lose as many digits as they have
        ctx.prec = 12 * c.digits + 330
    if isinstance(c.theorem, Curves | Basins | Horseshoe | Expansion):
        ctx.prec = WIDE_BITS
    try:
        match c.theorem:
            case Orbit():
                _orbit(_motion(c.system), c.theorem, c.digits)
            case Jump():
                _jump(_motion(c.system), c.theorem, c.digits)
            case List():
                _list(_motion(c.system), c.theorem, c.digits)
            case Border():
                _border(c.system, c.theorem, c.digits)
            case Branch():
                _along(c.system, c.theorem, c.digits)
            case Curves():
                check_curves(c.system, _names(c.theorem.parameter), c.theorem)
            case Basins():
                varied = _names(c.theorem.parameter) if c.theorem.parameter else ()
                check_basins(c.system, varied, c.theorem)
            case Horseshoe():
                check_horseshoe(_motion(c.system), c.theorem)
            case Expansion():
                check_expansion(c.system, c.theorem)
            case Fold():
                _fold(c.system, c.theorem, c.digits)
            case Flip():
                _flip(c.system, c.theorem, c.digits)
    finally:
        ctx.prec, ctx.cap = before
    if document.get("statement") != c.statement():
        raise Refused("the statement is not what the numbers say")
    return c


def check_text(text: str) -> Certificate | CertificateOfFormulas:
    """Check a certificate as it stands in a file; see `check`."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Refused(f"not JSON: {error}") from None
    return check(document)
