"""A second program that checks certificates again: small, and with nothing of the first in it.

It follows positions and velocities (the certifier: relative velocities and needed forces), finds
first events by halving time steps (the certifier: by the longest safe step), takes derivatives by
power series in d (the certifier: by jets), and finds a jump by bisecting the itinerary (the
certifier: by Newton's method for the condition of the event). All in flint's ball arithmetic.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from fractions import Fraction
from math import floor, log10
from typing import Any, Final

from flint import arb, arb_series, ctx, fmpq

__all__ = ["Refused", "check", "check_text", "rounded", "statement"]

SCHEMA: Final = "stickslip-certificate-1"
GLYPHS: Final = {-1: "-", 0: ".", 1: "+"}
SHORTEST: Final = 1e-4  # a step of time, before possibilities are listed instead
NARROWEST: Final = 1e-9  # an interval of d, before it counts as undecided
KEYS: Final = {
    "orbit": {"period", "points", "itinerary", "multiplier", "stable", "alone"},
    "jump": {"d", "left", "right", "itinerary_left", "itinerary_right", "mechanism"},
    "border": {
        "parameter", "value", "period", "points", "itinerary", "itinerary_beyond", "exists",
        "mechanism",
    },
    "list": {"max_period", "orbits", "undecided"},
}


class Refused(Exception):
    """The certificate does not hold; the message says what was found."""


# ---------------------------------------------------------------- motion


class Wave:
    """constant + rate t + sum of a cos(omega t) + b sin(omega t); series in d as coefficients."""

    def __init__(self, constant: Any, rate: Any, terms: list[tuple[Any, Any, Any]]) -> None:
        self.constant, self.rate, self.terms = constant, rate, terms

    def __call__(self, t: Any) -> Any:
        value = self.constant + self.rate * t
        for omega, a, b in self.terms:
            angle = omega * t
            sine, cosine = (
                angle.sin_cos() if isinstance(angle, arb) else (angle.sin(), angle.cos())
            )
            value = value + a * cosine + b * sine
        return value

    def derivative(self) -> Wave:
        return Wave(self.rate, arb(0), [(w, b * w, -(a * w)) for w, a, b in self.terms])

    def times(self, k: Any) -> Wave:
        terms = [(w, a * k, b * k) for w, a, b in self.terms]
        return Wave(self.constant * k, self.rate * k, terms)

    def __add__(self, other: Wave) -> Wave:
        return Wave(
            self.constant + other.constant, self.rate + other.rate, self.terms + other.terms
        )

    def above(self, low: Any) -> Wave:
        return Wave(self.constant - low, self.rate, self.terms)

    def bound(self) -> arb:
        """Largest second derivative at any time."""
        swings = (w * w * (abs(flat(a)) + abs(flat(b))) for w, a, b in self.terms)
        return sum(swings, arb(0))


def flat(x: Any) -> arb:
    """Range of a series, or of a number."""
    return x[0] if isinstance(x, arb_series) else arb(x)


class Signal:
    """What stays positive until an event of a block."""

    def __init__(self, block: int, end: int, wave: Wave) -> None:
        self.block, self.end, self.wave, self.slope = block, end, wave, wave.derivative()
        self.bound = arb(0, wave.bound().upper())

    def stays(self, t: arb, h: arb) -> bool:
        """Whether it is positive on (t, t + h], given that it is not negative at t."""
        rate = flat(self.slope(t + h / 2)) + self.bound * h / 2
        if rate > 0:
            return True
        return bool(flat(self.wave(t + h / 2)) + rate * arb(0, h.upper()) / 2 > 0)

    def falls(self, t: arb, h: arb) -> bool:
        """Whether it goes through zero once in (t, t + h]."""
        rate = flat(self.slope(t + h / 2)) + self.bound * h / 2
        return bool(rate < 0 and flat(self.wave(t + h)) < 0 and flat(self.wave(t)) > 0)

    def root(self, t: arb, h: arb) -> arb_series:
        """When it falls through zero, with the derivative in d."""
        window = t.union(t + h)
        while True:
            rate = flat(self.slope(window))
            new = window.mid() - flat(self.wave(window.mid())) / rate
            new = new.intersection(window)
            if not new.rad() < 0.7 * window.rad():
                break
            window = new
        return arb_series([new, -self.wave(new)[1] / rate])


class Motion:
    """Two blocks with Coulomb friction (eqs. 5a-10), parameters exact."""

    def __init__(self, values: dict[str, str], **replaced: arb) -> None:
        if set(values) != {"alpha", "beta", "V", "mu_1", "mu_2"}:
            raise Refused("the system is not given by alpha, beta, V, mu_1 and mu_2")
        numbers = {name: ball(text) for name, text in values.items()} | replaced
        self.alpha, self.V = numbers["alpha"], numbers["V"]
        if not (self.alpha >= 0 and self.V > 0 and numbers["beta"] > 0):
            raise Refused("a parameter is out of range")
        self.limits = (arb(1), numbers["beta"])
        self.mu = (numbers["mu_1"], numbers["mu_2"])

    @property
    def end(self) -> arb:
        """Where the domain ends."""
        return (1 + self.limits[1]) / (1 + 2 * self.alpha)

    def outcomes(self, d: arb) -> Iterator[tuple[str, arb, arb | None]]:
        """Yield itinerary, next d and its derivative: all that is possible from a ball."""
        x = arb_series([d, 1])
        reach = (1 + self.alpha * x, self.limits[1] - (1 + self.alpha) * x)
        margin = flat(reach[1] - reach[0])
        for block in (0, 1):
            if not (margin < 0 if block == 0 else margin > 0):
                modes = (-1, 0) if block == 0 else (0, -1)
                state = ([reach[block], reach[block] + x], [self.V, self.V], modes)
                sure = bool(margin > 0 or margin < 0)
                yield from self._follow(state, [], sure)

    def step(self, d: arb) -> tuple[str, arb, arb]:
        """The one outcome from a ball; the value by the mean value theorem."""
        found = list(self.outcomes(d))
        if len(found) != 1 or found[0][2] is None:
            raise Refused(f"the itinerary from d = {d.str(12)} cannot be told")
        word, value, slope = found[0]
        if d.rad() > 0:
            value = value.intersection(self.step(d.mid())[1] + slope * (d - d.mid()))
        return word, value, slope

    def _follow(self, state: Any, words: list[str], sure: bool) -> Iterator[Any]:
        x, v, modes = state
        words = [*words, GLYPHS[modes[0]] + GLYPHS[modes[1]]]
        if modes == (0, 0):
            value = x[1] - x[0]
            word = " ".join(w for i, w in enumerate(words) if i == 0 or w != words[i - 1])
            yield word, value[0], value[1] if sure else None
            return
        if len(words) > 400:
            raise Refused("no global stick within 400 events")
        waves = self._waves(x, v, modes)
        for signal, t in self._first(self._signals(waves, modes), sure):
            known = sure and isinstance(t, arb_series)
            y, u = [wave(t) for wave in waves], [wave.derivative()(t) for wave in waves]
            i = signal.block
            for j in (0, 1):
                if modes[j] == 0 or j == i:
                    u[j] = self.V
            if not known:
                y = [arb_series([flat(a), arb(0, float("inf"))]) for a in y]
                u = [arb_series([flat(a), arb(0, float("inf"))]) for a in u]
            for mode, certain in self._modes_after(signal, self._need(y, i)):
                after = (mode, modes[1]) if i == 0 else (modes[0], mode)
                yield from self._follow((y, u, after), words, known and certain)

    def _modes_after(self, signal: Signal, force: arb) -> list[tuple[int, bool]]:
        if signal.end:
            return [(-signal.end, True)]
        limit = self.limits[signal.block]
        if force > limit or force < -limit:
            return [(-1 if force > 0 else 1, True)]
        if force < limit and force > -limit:
            return [(0, True)]
        return [(0, False), (-1 if force > 0 else 1, False)]

    def _need(self, x: list[Any], i: int) -> arb:
        return flat((1 + self.alpha) * x[i] - self.alpha * x[1 - i])

    def _waves(self, x: list[Any], v: list[Any], modes: tuple[int, int]) -> list[Wave]:
        alpha, V = self.alpha, self.V
        pull = [-m * limit * mu for m, limit, mu in zip(modes, self.limits, self.mu, strict=True)]
        if modes[0] and modes[1]:
            omega = (1 + 2 * alpha).sqrt()
            c, r = pull[0] + pull[1], (pull[1] - pull[0]) / (1 + 2 * alpha)
            total = Wave(c, arb(0), [(arb(1), x[0] + x[1] - c, v[0] + v[1])])
            gap = Wave(r, arb(0), [(omega, x[1] - x[0] - r, (v[1] - v[0]) / omega)])
            return [(total + gap.times(sign)).times(arb(0.5)) for sign in (-1, 1)]
        i = 0 if modes[0] else 1
        omega, drift = (1 + alpha).sqrt(), alpha * V / (1 + alpha)
        c = (pull[i] + alpha * x[1 - i]) / (1 + alpha)
        slip = Wave(c, drift, [(omega, x[i] - c, (v[i] - drift) / omega)])
        ride = Wave(x[1 - i], V, [])
        return [slip, ride] if i == 0 else [ride, slip]

    def _signals(self, waves: list[Wave], modes: tuple[int, int]) -> list[Signal]:
        found = []
        for i in (0, 1):
            if modes[i]:
                speed = waves[i].derivative().above(self.V)
                found.append(Signal(i, 0, speed.times(modes[i])))
            else:
                for end in (1, -1):
                    force = waves[i].times(1 + self.alpha) + waves[1 - i].times(-self.alpha)
                    found.append(Signal(i, end, force.times(-end).above(-self.limits[i])))
        return found

    def _first(self, signals: list[Signal], sure: bool) -> Iterator[tuple[Signal, Any]]:
        """Yield the signal that reaches zero first and when; all that may, if it is not plain."""
        t, h = arb(0), arb(2) ** -4
        while t < 200:
            open_ = [s for s in signals if not s.stays(t, h)]
            if not open_:
                t, h = (t + h).mid(), h * 1.5 if h < 0.2 else h
            elif sure and len(open_) == 1 and open_[0].falls(t, h):
                yield open_[0], open_[0].root(t, h)
                return
            elif h > SHORTEST or (sure and h > arb(2) ** (20 - ctx.prec // 2)):
                h = h / 2
            else:
                t = yield from self._possible(signals, t)
                if t is None:
                    return
                h = arb(SHORTEST)
        raise Refused("no event within 200 time units")

    def _possible(self, signals: list[Signal], t: arb) -> Iterator[Any]:
        """Yield all events of a short time; return its end, or None if there must be one."""
        h = arb(SHORTEST)
        while h < 0.5:
            ends = [flat(s.wave(t + h)) for s in signals]
            plain = (s.stays(t, h) or end > 0 or end < 0 for s, end in zip(signals, ends, strict=True))
            if all(plain):
                for s in (s for s in signals if not s.stays(t, h)):
                    yield s, t.union(t + h)
                return None if any(end < 0 for end in ends) else (t + h).mid()
            h = h * 1.5
        raise Refused("the ball is too wide")


# ---------------------------------------------------------------- claims


def ball(text: str) -> arb:
    """Read ``decimal``, ``p/q`` or ``decimal +/- radius`` exactly."""
    try:
        middle, _, radius = text.partition(" +/- ")
        exact, width = Fraction(middle), Fraction(radius or 0)
    except (ValueError, AttributeError, ZeroDivisionError):
        raise Refused(f"{text!r} is not a number") from None
    if width < 0:
        raise Refused(f"{text!r} has a negative radius")
    ends = [arb(fmpq(x.numerator, x.denominator)) for x in (exact - width, exact + width)]
    return ends[0].union(ends[1]) if width else ends[0]


def rounded(x: arb, digits: int) -> str:
    """Write a ball as ``decimal +/- radius``, the radius half a unit of the last digit.

    The decimal has `digits` significant digits, or up to three more where the last could not be
    told: so a number has one form only.

    Raises
    ------
    ValueError
        The ball is wider than that.
    """
    mantissa, exponent = x.mid().man_exp()
    middle = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    mantissa, exponent = x.rad().man_exp()
    radius = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    size = floor(log10(abs(middle))) if middle else 0
    for places in range(max(digits - 1 - size, 1), digits + 4 - size):
        unit = Fraction(10) ** -places
        nearest = round(middle / unit)
        if abs(middle - nearest * unit) + radius <= unit * Fraction(45, 100):
            text = str(abs(nearest)).rjust(places + 1, "0")
            sign = "-" if nearest < 0 else ""
            return f"{sign}{text[:-places]}.{text[-places:]} +/- 5e-{places + 1}"
    raise ValueError(f"{x} has fewer than {digits} digits")


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
        raise Refused(f"{len(points)} points and {len(c['itinerary'])} itineraries are given for "
                      f"period {c['period']}")
    tight = points[0]
    for _ in range(2):  # the second time from what the first proved
        value, slope = _power(motion, tight, c["itinerary"])
        end, _ = _power(motion, tight.mid(), c["itinerary"])
        if (slope - 1).contains(0):
            raise Refused("the multiplier cannot be told from 1")
        new = tight.mid() - (end - tight.mid()) / (slope - 1)
        if not tight.contains_interior(new):
            what = "may be" if new.overlaps(tight) else "is"
            raise Refused(f"points[0] is stated as {c['points'][0]}, but the orbit {what} at "
                          f"{new.str(digits + 3, radius=False)}")
        tight = new
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
    alone = points[0].mid() + ball(f"0 +/- {c['alone']}")
    if (_power(motion, alone, c["itinerary"])[1] - 1).contains(0):
        raise Refused(f"the orbit is not shown to be alone within {c['alone']}")
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


def _bisected(motion: Motion, low: arb, high: arb, words: list[str], digits: int) -> tuple[arb, arb]:
    """Close in on where the itinerary changes from the one to the other."""
    for x, word in ((low, words[0]), (high, words[1])):
        if (found := motion.step(x)[0]) != word:
            raise Refused(f"the itinerary at {x.str(digits, radius=False)} is stated as {word!r} "
                          f"and is {found!r}")
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
    """The one-sided image of the jump returns to the jump at one value of the parameter."""
    names = {"mu": ("mu_1", "mu_2")}.get(c["parameter"], (c["parameter"],))
    stated = ball(c["value"])
    low, high = (stated.mid() + sign * stated.rad() for sign in (-1, 1))
    a, b = (_miss(values, names, p, c, digits)[0] for p in (low, high))
    if not a * b < 0:
        raise Refused(f"value is stated as {c['value']}, but nothing changes there")
    between = (low - a * (high - low) / (b - a)).mid()
    _, points, beyond = _miss(values, names, between, c, digits)
    if beyond != c["itinerary_beyond"]:
        raise Refused(f"the itinerary beyond is stated as {c['itinerary_beyond']!r}, and is {beyond!r}")
    for k, (text, x) in enumerate(zip(c["points"], points, strict=True)):
        _matches(f"points[{k}]", text, x + arb(0, arb(10) ** (-digits - 8)), digits)


def _miss(
    values: dict[str, str], names: tuple[str, ...], p: arb, c: dict[str, Any], digits: int
) -> tuple[arb, list[arb], str]:
    """How far f^p of the jump's one side misses the jump; the points; the other side's word."""
    motion = Motion(values, **dict.fromkeys(names, p))
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
        return _impossible(motion, box, period)
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


# ---------------------------------------------------------------- documents


def statement(c: dict[str, Any]) -> str:
    """What a certificate says, in words: made from its data, so that the two cannot differ."""
    system = ", ".join(f"{name} = {value}" for name, value in c["system"].items())
    head = f"Two blocks with Coulomb friction, {system} (exact numbers). "
    return head + {
        "orbit": _orbit_words, "jump": _jump_words, "border": _border_words, "list": _list_words
    }[c["claim"]](c)


def _orbit_words(c: dict[str, Any]) -> str:
    kind = "asymptotically stable" if c["stable"] else "unstable"
    return (
        f"The event map has a periodic orbit of minimal period {c['period']} through "
        f"d = {c['points'][0]}. Within {c['alone']} of this point there is no other periodic point "
        f"of that period. Its multiplier is {c['multiplier']}: the orbit is {kind}."
    )


def _jump_words(c: dict[str, Any]) -> str:
    return (
        f"The event map jumps at d = {c['d']}: {c['mechanism']}. To the left the itinerary is "
        f"{c['itinerary_left']!r} and f tends to {c['left']}; to the right it is "
        f"{c['itinerary_right']!r} and f tends to {c['right']}."
    )


def _border_words(c: dict[str, Any]) -> str:
    return (
        f"As {c['parameter']} varies, the periodic orbit of period {c['period']} with the "
        f"itinerary {' | '.join(c['itinerary'])} reaches a jump of the event map at "
        f"{c['parameter']} = {c['value']}, with the point d = {c['points'][0]}: {c['mechanism']}. "
        f"It crosses the jump transversally: near that value the orbit exists "
        f"{c['exists']} it and not on the other side, where the itinerary of this point would be "
        f"{c['itinerary_beyond']!r}."
    )


def _list_words(c: dict[str, Any]) -> str:
    places = ", ".join(f"{o['points'][0]} (period {o['period']})" for o in c["orbits"])
    tail = f" Undecided: {c['undecided']}." if c["undecided"] else ""
    return (
        f"The event map has exactly {len(c['orbits'])} periodic orbits of period up to "
        f"{c['max_period']} on its whole domain, outside the undecided intervals: {places}.{tail}"
    ).replace(", outside the undecided intervals" if not c["undecided"] else "\0", "")


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
    try:
        if c["claim"] == "border":
            _border(c["system"], c, digits)
        else:
            motion = Motion(c["system"])
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
    except ValueError as error:
        raise Refused(f"not JSON: {error}") from None
    return check(document)


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as stream:
        print(check_text(stream.read()))
