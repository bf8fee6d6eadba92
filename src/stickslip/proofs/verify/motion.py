"""Motion of two blocks from one global stick to the next, enclosed with little machinery."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Any, Final

from flint import arb, arb_series, ctx

from stickslip.proofs.verify.words import Refused, ball

# Of parameters: what is proven must be so of a system with dry friction, and take bounded time.
RANGES: Final = {
    "alpha": (0.0, 1e4),
    "beta": (1e-4, 1e4),
    "V": (1e-6, 1e4),
    "mu": (1e-6, 1 - 1e-6),  # at 0 and 1 a slip ends in an equality
    "gamma": (0.0, 1e4),
    "delta": (0.0, 1.0),
    "eta": (0.0, 1e4),
}
SOON: Final = 0.1  # between a landing and a turn, in units of sqrt(m / k)
MOST_OUTCOMES: Final = 64  # of a ball: more are of no use
GLYPHS: Final = {-1: "-", 0: ".", 1: "+"}


class Wave:
    """constant + rate t + sum of a cos(omega t) + b sin(omega t); series in d as coefficients."""

    def __init__(self, constant: Any, rate: Any, terms: list[tuple[Any, Any, Any]]) -> None:
        self.constant, self.rate, self.terms = constant, rate, terms

    def __call__(self, t: Any) -> Any:
        """Value at t."""
        value = self.constant + self.rate * t
        for omega, a, b in self.terms:
            angle = omega * t
            sine, cosine = _sin_cos(angle)
            value = value + a * cosine + b * sine
        return value

    def derivative(self) -> Wave:
        """Return the derivative."""
        return Wave(self.rate, arb(0), [(w, b * w, -(a * w)) for w, a, b in self.terms])

    def times(self, k: Any) -> Wave:
        """Multiply by k."""
        terms = [(w, a * k, b * k) for w, a, b in self.terms]
        return Wave(self.constant * k, self.rate * k, terms)

    def __add__(self, other: Wave) -> Wave:
        return Wave(
            self.constant + other.constant, self.rate + other.rate, self.terms + other.terms
        )

    def above(self, low: Any) -> Wave:
        """Subtract a level."""
        return Wave(self.constant - low, self.rate, self.terms)

    def range(self) -> Wave:
        """Forget the derivatives."""
        terms = [(flat(w), flat(a), flat(b)) for w, a, b in self.terms]
        return Wave(flat(self.constant), flat(self.rate), terms)

    def bound(self) -> arb:
        """Largest second derivative at any time."""
        return sum((w * w * (abs(a) + abs(b)) for w, a, b in self.terms), arb(0))


def flat(x: Any) -> arb:
    """Range of a series, or of a number."""
    return x[0] if isinstance(x, arb_series) else arb(x)


def _sin_cos(x: Any) -> tuple[Any, Any]:
    return x.sin_cos() if isinstance(x, arb) else (x.sin(), x.cos())


def _sharper(x: arb_series, y: arb_series) -> arb_series:
    """Intersect two enclosures of a value and its derivative."""
    first = [a.intersection(b) if a.is_finite() else b for a, b in ((x[k], y[k]) for k in (0, 1))]
    return arb_series([*first, *(x[k] for k in range(2, ctx.cap))])


class Signal:
    """What stays positive until an event of a block."""

    def __init__(self, block: int, end: int, wave: Wave) -> None:
        self.block, self.end, self.wave = block, end, wave
        self.range = wave.range()
        self.rate = self.range.derivative()
        self.bound = arb(0, self.range.bound().upper())

    def stays(self, t: arb, h: arb) -> bool:
        """Whether it is positive on (t, t + h], given that it is not negative at t."""
        rate = self.rate(t + h / 2) + self.bound * h / 2
        return bool(rate > 0) or bool(self.range(t + h / 2) + rate * arb(0, h.upper()) / 2 > 0)

    def falls(self, t: arb, h: arb) -> bool:
        """Whether it goes through zero once in (t, t + h]."""
        rate = self.rate(t + h / 2) + self.bound * h / 2
        return bool(rate < 0 and self.range(t + h) < 0 and self.range(t) > 0)

    def root(self, window: arb) -> arb_series:
        """When it goes through zero, with the derivatives in d."""
        while True:
            rate = self.rate(window)
            new = window.mid() - self.range(window.mid()) / rate
            new = new.intersection(window)
            if not new.rad() < 0.7 * window.rad():
                break
            window = new
        terms = [new]
        for k in range(1, ctx.cap):  # each round gives one more term
            terms.append(-self.wave(arb_series(terms))[k] / self.rate(new))
        return arb_series(terms)


class _Open(Exception):
    """More than one thing may happen, where one is asked for."""


class Motion:
    """Two blocks with Coulomb friction (eqs. 5a-10), parameters exact or `replaced`."""

    coarse: float = 1e-3  # wider intervals of d are halved before possibilities are listed
    law: tuple[str, ...] = ("mu",)  # its parameters, each with _1 and _2

    def __init__(self, values: dict[str, str], **replaced: Any) -> None:
        names = ["alpha", "beta", "V", *(f"{name}_{i}" for name in self.law for i in (1, 2))]
        if sorted([*values, *replaced]) != sorted(names):
            raise Refused(f"the system is not given by {', '.join(names)}")
        numbers = {name: ball(text) for name, text in values.items()} | replaced
        self.alpha, self.V = numbers["alpha"], numbers["V"]
        for name, each in numbers.items():
            number = flat(each)
            low, high = RANGES[name.partition("_")[0]]
            if not low <= number <= high:
                raise Refused(f"{name} = {number.str(12)} is not from {low} to {high}")
        self.limits = (arb(1), numbers["beta"])
        self.laws = [[numbers[f"{name}_{i}"] for name in self.law] for i in (1, 2)]
        self.strict = False
        self.reached = arb_series()  # the last value, as a series in d

    @property
    def end(self) -> arb:
        """Where the domain ends."""
        return (1 + self.limits[1]) / (1 + 2 * self.alpha)

    def inside(self, d: arb) -> bool:
        """Whether a ball is proven to lie in the domain."""
        return bool(-self.end <= d <= self.end)

    def boxes(self, n: int) -> list[arb]:
        """Cut the domain into intervals that overlap."""
        return [self.end * arb(k, 1) / n for k in range(1 - n, n, 2)]

    def outcomes(self, d: arb | arb_series) -> Iterator[tuple[str, arb, arb]]:
        """Yield itinerary, next d and its derivative: all that is possible from a ball."""
        for found, outcome in enumerate(self._outcomes(d)):
            if found == MOST_OUTCOMES:
                raise Refused("too much is possible from the ball")
            yield outcome

    def _outcomes(self, d: arb | arb_series) -> Iterator[tuple[str, arb, arb]]:
        # Below this step of time possibilities are listed: it is what a wide ball leaves open.
        self.shortest = (flat(d).rad() / 64).mid() + arb(2) ** (20 - ctx.prec // 2)
        x = d if isinstance(d, arb_series) else arb_series([d, 1])
        reach = (1 + self.alpha * x, self.limits[1] - (1 + self.alpha) * x)
        margin = flat(reach[1] - reach[0])
        for block in (0, 1):
            if not (margin < 0 if block == 0 else margin > 0):
                modes = (-1, 0) if block == 0 else (0, -1)
                state = ([reach[block], reach[block] + x], [self.V, self.V], modes)
                sure = bool(margin > 0 or margin < 0)
                yield from self._follow(state, [], sure)

    def step(self, d: arb) -> tuple[str, arb, arb]:
        """Return the one outcome from a ball; the value by the mean value theorem."""
        word, value, slope = self._one(d)
        if d.rad() > 0:
            value = value.intersection(self._one(d.mid())[1] + slope * (d - d.mid()))
        return word, value, slope

    def series(self, d: arb | arb_series) -> tuple[str, arb_series]:
        """Return itinerary and next d, as a power series in the distance from a thin ball."""
        # Or in what a series is in: d, and parameters if they were `replaced` by series.
        word, *_ = self._one(d)
        return word, self.reached

    def _one(self, d: arb | arb_series) -> tuple[str, arb, arb]:
        self.strict = True
        try:
            word, value, slope = next(self.outcomes(d))
        except _Open:
            raise Refused(f"the itinerary from d = {flat(d).str(12)} cannot be told") from None
        finally:
            self.strict = False
        return word, value, slope

    def _follow(self, state: Any, words: list[str], sure: bool) -> Iterator[Any]:
        if self.strict and not sure:
            raise _Open
        x, v, modes = state
        words = [*words, GLYPHS[modes[0]] + GLYPHS[modes[1]]]
        if modes == (0, 0):
            value = self.reached = x[1] - x[0]
            word = " ".join(w for i, w in enumerate(words) if i == 0 or w != words[i - 1])
            yield word, value[0], value[1]
            return
        if len(words) > 400:
            raise Refused("no global stick within 400 events")
        waves = self._waves(x, v, modes)
        for signal, t in self._first(self._signals(waves, modes)):
            y, u = [wave(t) for wave in waves], [wave.derivative()(t) for wave in waves]
            i = signal.block
            for j in (0, 1):
                if modes[j] == 0 or j == i:
                    u[j] = self.V
            for mode, certain in self._modes_after(signal, self._need(y, i)):
                after = (mode, modes[1]) if i == 0 else (modes[0], mode)
                state = (y, u, after)
                if certain and not (mode or signal.end):
                    state = self._turned(waves, signal, t, state)
                yield from self._follow(state, words, sure and certain)

    def _turned(self, waves: list[Wave], signal: Signal, t: arb_series, state: Any) -> Any:
        """Return the state when a block that landed at t would have turned, if that is soon."""
        # Just before a graze derivatives of t are large, and across it unknown: there they are
        # those of the motion without the landing, and of integrals of its velocity over the time
        # between.
        x, v, after = state
        i, j = signal.block, 1 - signal.block
        fall, bend = signal.rate(t[0]), signal.rate.derivative()(t[0])
        if not bend > 0 or not -fall < SOON * bend:
            return state
        start, h = t[0].lower(), (4 * t[0].rad() - 2 * fall / bend).upper()
        turning = Signal(i, 0, signal.wave.derivative())
        bend = turning.rate(start.union(start + h))
        if not (turning.range(start) < 0 < turning.range(start + h) and bend > 0):
            return state
        turn = turning.root(start.union(start + h))
        rest = turn - t
        deep = (-2 * signal.range(turn[0]) / bend).nonnegative_part().sqrt()
        shortest, longest = rest[0].nonnegative_part().lower(), rest[0].upper().min(deep.upper())
        if not shortest <= longest:
            return state
        rest[0] = shortest.union(longest)
        if after[j]:
            riding = self._waves(x, v, after)
            if not all(s.stays(arb(0), longest) for s in self._signals(riding, after)):
                return state
        else:
            riding = [Wave(each, self.V, []) for each in x]
        r = arb(0).union(longest)
        speed = (waves[i].derivative()(turn - r) - self.V) * rest[0]
        omega = (1 + self.alpha).sqrt()
        sine, cosine = _sin_cos(omega * r)
        pull = [-self.alpha * (1 - cosine) / (1 + self.alpha), -self.alpha * sine / omega]
        y, u = [wave(rest) for wave in riding], [self.V, self.V]
        y[i] = _sharper(y[i], waves[i](turn) - speed)
        if after[j]:
            y[j] = _sharper(y[j], waves[j](turn) + pull[0] * speed)
            u[j] = riding[j].derivative()(rest)
            u[j] = _sharper(u[j], waves[j].derivative()(turn) + pull[1] * speed)
        return y, u, after

    def _modes_after(self, signal: Signal, force: arb) -> list[tuple[int, bool]]:
        if signal.end:
            return [(-signal.end, True)]
        limit = flat(self.limits[signal.block])
        if force > limit or force < -limit:
            return [(-1 if force > 0 else 1, True)]
        if force < limit and force > -limit:
            return [(0, True)]
        return [(0, False), (-1 if force > 0 else 1, False)]

    def _need(self, x: list[Any], i: int) -> arb:
        return flat((1 + self.alpha) * x[i] - self.alpha * x[1 - i])

    def _waves(self, x: list[Any], v: list[Any], modes: tuple[int, int]) -> list[Wave]:
        alpha, V = self.alpha, self.V
        pull = [
            -m * limit * mu for m, limit, (mu,) in zip(modes, self.limits, self.laws, strict=True)
        ]
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

    def _first(self, signals: list[Signal]) -> Iterator[tuple[Signal, arb_series]]:
        """Yield the signal that reaches zero first and when; all that may, if it is not plain."""
        t, h, shortest = arb(0), arb(2) ** -4, self.shortest
        while t < 200:
            open_ = [s for s in signals if not s.stays(t, h)]
            if not open_:
                t, h = (t + h).mid(), h * 1.5 if h < 0.2 else h
            elif len(open_) == 1 and open_[0].falls(t, h):
                yield open_[0], open_[0].root(t.union(t + h))
                return
            elif h > shortest:
                h = h / 2
            else:
                if self.strict:
                    raise _Open
                clear = yield from self._possible(signals, t, shortest)
                if clear is None:
                    return
                t, shortest = clear, 2 * shortest  # a long graze is few events
        raise Refused("no event within 200 time units")

    def _possible(
        self, signals: list[Signal], t: arb, h: arb
    ) -> Generator[tuple[Signal, arb_series], None, arb | None]:
        """Yield all events of a short time; return its end, or None if there must be one."""
        while h < 0.5:
            ends = [s.range(t + h) for s in signals]
            plain = (
                s.stays(t, h) or end > 0 or end < 0 for s, end in zip(signals, ends, strict=True)
            )
            if all(plain):
                for s in (s for s in signals if not s.stays(t, h)):
                    # One that has passed zero in part of the ball did so just before.
                    around = (t - h).union(t + h)
                    through = s.range(t - h) > 0 > s.range(t + h) and s.rate(around) < 0
                    unknown = arb_series([t.union(t + h), arb(0, float("inf"))])
                    yield s, s.root(around) if through else unknown
                return None if any(end < 0 for end in ends) else (t + h).mid()
            h = h * 2
        raise Refused("the ball is too wide")
