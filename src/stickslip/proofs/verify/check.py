"""Check what certificates claim."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, Final

from flint import arb, arb_series, ctx

from stickslip.proofs.verify.falling import FallingMotion
from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import KEYS, SCHEMA, Refused, ball, rounded, statement

__all__ = ["Refused", "check", "check_text"]

COARSE: Final = 1e-3  # wider intervals of d are halved before possibilities are listed
NARROWEST: Final = 1e-9  # an interval of d, before it counts as undecided


def _motion(values: dict[str, str], **replaced: arb) -> Motion:
    """Return the motion of a system under the law that its parameters tell."""
    falling = "gamma_1" in {*values, *replaced}
    return (FallingMotion if falling else Motion)(values, **replaced)


def _matches(name: str, text: str, found: arb, digits: int) -> None:
    """Refuse a decimal that is not the value found, rounded to its last digit."""
    try:
        expected = rounded(found, digits)
    except ValueError as error:
        raise Refused(f"{name} cannot be checked: {error}") from None
    if text != expected:
        raise Refused(f"{name} is stated as {text}, and is {expected}")


def _orbit(motion: Motion, c: dict[str, Any], digits: int) -> arb:
    """Check an orbit; return the ball around its first point in which it is alone."""
    points = [ball(text) for text in c["points"]]
    if not (len(points) == len(c["itinerary"]) == c["period"] >= 1):
        raise Refused(
            f"{len(points)} points and {len(c['itinerary'])} itineraries are given for "
            f"period {c['period']}"
        )
    tight, _ = _branch(motion, c["itinerary"], points[0].mid(), 3, arb(10) ** (-digits - 20))
    x, slope = tight, arb(1)
    for k, text in enumerate(c["points"]):
        _matches(f"points[{k}]", text, x, digits)
        _, x, rate = motion.step(x)
        slope *= rate
    _matches("multiplier", c["multiplier"], slope, digits)
    if any(a.overlaps(b) for i, a in enumerate(points) for b in points[:i]):
        raise Refused("two points of the orbit coincide: the period is not minimal")
    if c["stable"] is not bool(abs(slope) < 1):
        raise Refused(f"stable is stated as {c['stable']}, the multiplier is {slope.str(12)}")
    alone = tight.mid() + ball(f"0 +/- {c['alone']}")
    _, slope = _power(motion, alone.mid() + 2 * (alone - alone.mid()), c["itinerary"])
    if (slope - 1).contains(0):
        raise Refused(f"the orbit is not shown to be alone within {c['alone']}")
    if c["stable"] and not abs(slope) < 1:
        raise Refused(f"the orbit is not shown to attract all points within {c['alone']}")
    return alone


def _power(motion: Motion, x: arb, words: list[str]) -> tuple[arb, arb]:
    """F^p of a ball and its derivative, along an itinerary."""
    slope = arb(1)
    for word in words:
        found, x, rate = motion.step(x)
        slope *= rate
        if found != word:
            raise Refused(f"the itinerary is stated as {word!r} and is {found!r}")
    return x, slope


def _bisected(
    motion: Motion, low: arb, high: arb, words: list[str], digits: int
) -> tuple[arb, arb]:
    """Close in on where the itinerary changes from the one to the other."""
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


def _jump(motion: Motion, c: dict[str, Any], digits: int) -> None:
    stated = ball(c["d"])
    low, high = (stated.mid() + sign * 3 * stated.rad() for sign in (-1, 1))
    words = [c["itinerary_left"], c["itinerary_right"]]
    low, high = _bisected(motion, low.mid(), high.mid(), words, digits)
    _matches("d", c["d"], low.union(high), digits)
    for name, x in (("left", low), ("right", high)):
        _matches(name, c[name], motion.step(x)[1], digits)


def _border(values: dict[str, str], c: dict[str, Any], digits: int) -> None:
    """Check at which value of the parameter the jump's one-sided image returns to it."""
    names = _names(c["parameter"])
    stated = ball(c["value"])
    low, high = (stated.mid() + sign * stated.rad() for sign in (-1, 1))
    a, b = (_miss(values, names, p, c, digits)[0] for p in (low, high))
    if not a * b < 0:
        raise Refused(f"value is stated as {c['value']}, but nothing changes there")
    between = (low - a * (high - low) / (b - a)).mid()
    _, points, beyond = _miss(values, names, between, c, digits)
    if beyond != c["itinerary_beyond"]:
        raise Refused(
            f"the itinerary beyond is stated as {c['itinerary_beyond']!r}, and is {beyond!r}"
        )
    for k, (text, x) in enumerate(zip(c["points"], points, strict=True)):
        _matches(f"points[{k}]", text, x + arb(0, arb(10) ** (-digits - 8)), digits)


def _names(parameter: str) -> tuple[str, ...]:
    """Names in the system that a varied parameter stands for."""
    both = parameter in ("mu", "gamma", "delta", "eta")
    return (f"{parameter}_1", f"{parameter}_2") if both else (parameter,)


def _fold(values: dict[str, str], c: dict[str, Any], digits: int) -> None:
    """Check where the extremum of f^period(d) - d passes 0, and how it bends there."""
    p, x, rate = _passed(values, c, digits, _extremum, "two orbits do not meet")
    series = _critical(values, c, digits, p, x, 2)
    curvature = 2 * series[2]
    _matches("curvature", c["curvature"], curvature, digits)
    if (c["exists"] == "above") is not bool(rate * curvature < 0):
        raise Refused("the side of the fold is not that of its coefficients")


def _flip(values: dict[str, str], c: dict[str, Any], digits: int) -> None:
    """Check where the multiplier along the orbit's branch passes -1, how, and how it doubles."""
    p, x, rate = _passed(values, c, digits, _flipped, "the multiplier does not pass -1")
    series = _critical(values, c, digits, p, x, 3)
    _matches("rate", c["rate"], rate, digits)
    cubic = series[3] + series[2] ** 2
    _matches("cubic", c["cubic"], cubic, digits)
    sides = [bool(rate > 0), bool(rate * cubic < 0)]
    if [c["stable"] == "above", c["doubled"] == "above"] != sides:
        raise Refused("the sides of the flip are not those of its coefficients")


def _passed(
    values: dict[str, str],
    c: dict[str, Any],
    digits: int,
    tell: Callable[[Motion, list[str], arb, arb], tuple[arb, arb]],
    otherwise: str,
) -> tuple[arb, arb, arb]:
    """Enclose where a condition passes 0: parameter, point, and the derivative somewhere there.

    `tell` encloses the point and the condition at one value of the parameter, given a point nearby.
    """
    stated = ball(c["value"])
    x, wide = ball(c["points"][0]).mid(), arb(10) ** (-digits - 4)
    low, high = ((stated.mid() + sign * stated.rad()).mid() for sign in (-1, 1))

    def at(p: arb, x: arb, radius: arb) -> tuple[arb, arb]:
        motion = _motion(values, **dict.fromkeys(_names(c["parameter"]), p))
        return tell(motion, c["itinerary"], x, radius)

    found = [at(p, x, wide * arb(10) ** -15) for p in (low, high)]
    (_, a), (_, b) = found
    if not a * b < 0:
        raise Refused(f"value is stated as {c['value']}, but {otherwise} there")
    for width in (wide, wide * arb(10) ** -8, wide * arb(10) ** -22):
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
            raise Refused(f"the place of the {c['claim']} cannot be told to its last digit")
    return low.union(high), found[0][0].union(found[1][0]), (b - a) / (high - low)


def _critical(
    values: dict[str, str], c: dict[str, Any], digits: int, p: arb, x: arb, order: int
) -> arb_series:
    """Check value and points at a fold or flip; return the power series of f^period in d."""
    _matches("value", c["value"], p, digits)
    motion = _motion(values, **dict.fromkeys(_names(c["parameter"]), p))
    points, series = _series(motion, c["itinerary"], x, order)
    for k, (text, point) in enumerate(zip(c["points"], points, strict=True)):
        _matches(f"points[{k}]", text, point, digits)
    if any(a.overlaps(b) for i, a in enumerate(points) for b in points[:i]):
        raise Refused("two points of the orbit coincide: the period is not minimal")
    return series


def _flipped(motion: Motion, words: list[str], x: arb, radius: arb) -> tuple[arb, arb]:
    """Enclose the orbit's point near x, and its multiplier + 1."""
    x, slope = _branch(motion, words, x, 3, radius)
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


def _branch(motion: Motion, words: list[str], x: arb, rounds: int, radius: arb) -> tuple[arb, arb]:
    """Enclose the first point of an orbit near x, and its multiplier, by Newton's method."""
    for _ in range(rounds):
        end, slope = _power(motion, x, words)
        x = (x - (end - x) / (slope - 1)).mid()
    near = x + arb(0, radius.upper())
    end, _ = _power(motion, x, words)
    _, slope = _power(motion, near, words)
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


def _miss(
    values: dict[str, str], names: tuple[str, ...], p: arb, c: dict[str, Any], digits: int
) -> tuple[arb, list[arb], str]:
    """How far f^p of the jump's one side misses the jump; the points; the other side's word."""
    motion = _motion(values, **dict.fromkeys(names, p))
    near, word = ball(c["points"][0]).mid(), c["itinerary"][0]
    reach = arb(10) ** (8 - digits)
    sides = [motion.step((near + sign * reach).mid())[0] for sign in (-1, 1)]
    if sides.count(word) != 1:
        raise Refused(f"no jump ends the itinerary {word!r} at d = {c['points'][0]}")
    ends = _bisected(motion, (near - reach).mid(), (near + reach).mid(), sides, digits)
    x = ends[sides.index(word)]
    points = [x]
    for each in c["itinerary"]:
        found, y, _ = motion.step(points[-1])
        if found != each:
            raise Refused(f"the itinerary is stated as {each!r} and is {found!r}")
        points.append(y)
    return points[-1] - x, points[:-1], sides[1 - sides.index(word)]


def _list(motion: Motion, c: dict[str, Any], digits: int) -> None:
    known = []
    for orbit in c["orbits"]:
        if set(orbit) != KEYS["orbit"]:
            raise Refused("an orbit of the list is not complete")
        _orbit(motion, orbit, digits)
        known += [(orbit["period"], ball(text)) for text in orbit["points"]]
    ctx.prec = 128  # the intervals are wide
    open_ = []
    for period in range(1, c["max_period"] + 1):
        waiting = [motion.end * arb(k, 2) / 64 for k in range(-62, 64, 4)]
        roots = [x for p, x in known if period % p == 0]
        while waiting:
            box = waiting.pop()
            if _settled(motion, box, period, roots):
                continue
            if box.rad() < NARROWEST:
                open_.append(box)
                continue
            half = box.rad() / 2
            waiting += [box.mid() + sign * half + arb(0, half) for sign in (-1, 1)]
    stated = [ball(low).union(ball(high)) for low, high in c["undecided"]]
    for box in open_:
        if not any(s.contains(box) for s in stated):
            raise Refused(f"an orbit may have been missed near d = {box.str(12)}")


def _settled(motion: Motion, box: arb, period: int, roots: list[arb]) -> bool:
    """Whether an interval holds no orbit of the period, or one that is known and alone."""
    try:
        value, slope = box, arb(1)
        for _ in range(period):
            _, value, rate = motion.step(value)
            slope *= rate
    except Refused:
        return bool(box.rad() < COARSE) and _impossible(motion, box, period)
    if not value.overlaps(box):
        return True
    if (slope - 1).contains(0):
        return False
    end = box.mid()
    for _ in range(period):
        end = motion.step(end)[1]
    new = box.mid() - (end - box.mid()) / (slope - 1)
    return not new.overlaps(box) or any(box.contains(root) for root in roots)


def _impossible(motion: Motion, box: arb, period: int) -> bool:
    """Whether no itinerary that is possible leads back into the interval."""
    balls = [box]
    try:
        for _ in range(period):
            balls = [value for x in balls for _, value, _ in motion.outcomes(x)]
            if len(balls) > 64:
                return False
    except Refused:
        return False
    return not any(value.overlaps(box) for value in balls)


def check(c: Any) -> str:
    """Check a certificate; return its statement.

    Raises
    ------
    Refused
        It does not hold.
    """
    if not isinstance(c, dict) or c.get("schema") != SCHEMA or c.get("claim") not in KEYS:
        raise Refused(f"not a certificate of the schema {SCHEMA}")
    if set(c) != KEYS[c["claim"]] | {"schema", "claim", "system", "digits", "statement"}:
        raise Refused("entries are missing or unknown")
    digits = c["digits"]
    if type(digits) is not int or not 5 <= digits <= 1000:
        raise Refused(f"digits = {digits!r} is not a whole number from 5 to 1000")
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = 10 * digits + 100, 2
    if c["claim"] in ("flip", "fold"):  # differences lose as many digits as they have
        ctx.prec = 12 * digits + 330
    try:
        if c["claim"] in ("border", "flip", "fold"):
            {"border": _border, "flip": _flip, "fold": _fold}[c["claim"]](c["system"], c, digits)
        else:
            motion = _motion(c["system"])
            {"orbit": _orbit, "jump": _jump, "list": _list}[c["claim"]](motion, c, digits)
        if c["statement"] != statement(c):
            raise Refused("the statement is not what the numbers say")
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise Refused(f"an entry is not of its form: {error}") from None
    finally:
        ctx.prec, ctx.cap = before
    return statement(c)


def check_text(text: str) -> str:
    """Check a certificate as it stands in a file; see `check`."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Refused(f"not JSON: {error}") from None
    return check(document)
