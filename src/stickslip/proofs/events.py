"""The first event of a phase, proven to be the first; or every event that may be.

Docs: proofs, the first event.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from flint import arb

from stickslip.proofs.jet import Number, hull, outward, spread
from stickslip.proofs.system import Phase
from stickslip.proofs.taylor import TaylorStep
from stickslip.proofs.wave import Undecided, Wave, root

LONGEST: Final = 200.0  # a phase, in units of sqrt(m / k)
STEPS: Final = 1000
CAUTION: Final = 0.9  # share taken of a step that is proven to be safe
SHORTEST: Final = 1e-150  # time that is told from none
GROWTHS: Final = 40  # of a window, from the time scale of the signals
QUIET: Final = 8  # windows in which nothing happens
KNOWN: Final = 0.9  # share of a Taylor step that is used before the next one
VAGUE: Final = 0.6  # a distance below this share of its spread is not approached further
WORDS: Final = {  # of a question: what may happen, and what does where it is decided
    "graze": ("block {} may graze the belt velocity", "block {} grazes the belt velocity"),
    "tie": (
        "events of blocks {} may come in either order",
        "the events of blocks {} coincide",
    ),
    "rest": (
        "block {} comes to rest with its force about at the static limit",
        "block {} comes to rest with its force exactly at the static limit",
    ),
    "onset": (
        "both blocks reach their limits about together at the onset",
        "both blocks reach their static limits together at the onset",
    ),
}


@dataclass(frozen=True)
class Decision:
    """A question that a box leaves open."""

    # graze; tie: two events coincide; rest: a block lands with its needed force at the limit
    kind: str
    blocks: tuple[int, ...]  # from 1
    margin: Number  # its sign answers the question
    sign: int  # of the margin, for the answer that is followed here
    answer: str

    @property
    def question(self) -> str:
        """What may happen, in words."""
        return WORDS[self.kind][0].format(self._who)

    @property
    def mechanism(self) -> str:
        """What happens where the margin vanishes, in words."""
        return WORDS[self.kind][1].format(self._who)

    @property
    def _who(self) -> str:
        return " and ".join(map(str, self.blocks))


@dataclass(frozen=True)
class Event:
    """A signal reaches zero; or nothing happens for as long as the motion is known."""

    block: int | None  # None if nothing happens
    end: int  # as in `Phase.signals`
    time: Number  # since the start of the phase
    decisions: tuple[Decision, ...] = ()  # left open on the way to it


class Signal:
    """A signal with its derivatives and bounds, and its values at the time reached."""

    def __init__(self, block: int, end: int, wave: Wave) -> None:
        self.block, self.end, self.wave = block, end, wave
        self.slope = wave.derivative()
        self.bend = self.slope.derivative()
        self.bound, self.bound_3 = wave.largest(2), wave.largest(3)

    def reach(self, basis: Any, room: float) -> None:
        """Take values at a time; how long the wave is known after it."""
        self.g, self.rate = spread(self.wave.at(basis)), spread(self.slope.at(basis))
        self.room = room
        # A block released where F(0) = 1 starts with g = g' = 0 exactly: g / t^2 decides.
        self.tangent = self.g.is_zero() and self.rate.is_zero()
        self.curve = spread(self.bend.at(basis)) if self.tangent else arb(0)
        if not (self.g.is_finite() and self.rate.is_finite() and self.bound.is_finite()):
            raise Undecided("the box is too wide for the motion to be enclosed")

    @property
    def pending(self) -> bool:
        """Whether it may reach zero at once. It is never negative for what really happens."""
        return not self.g > 0 and not self.rate > 0

    def stays(self, h: arb | float) -> bool:
        """Whether it is proven positive on (s, s + h], being >= 0 at s: by a concave bound."""
        if not h <= self.room:
            return False
        if self.tangent:
            return bool(self.curve - self.bound_3 * h / 3 > 0)
        low = self.g.lower()
        return bool((low if low > 0 else arb(0)) + self.rate * h - self.bound * h * h / 2 > 0)

    def safe(self) -> float:
        """Longest step after which the same bound is positive, in floats: only a proposal."""
        if self.tangent:
            return min(self.room, 3 * float(self.curve.lower()) / float(self.bound_3))
        g, rate, bound = (
            max(float(self.g.lower()), 0.0),
            float(self.rate.lower()),
            float(self.bound),
        )
        if bound == 0.0:
            return LONGEST if rate >= 0 else -g / rate
        discriminant = rate * rate + 2 * bound * g
        return (
            (rate + discriminant**0.5) / bound
            if rate > 0
            else (2 * g / (discriminant**0.5 - rate) if g > 0 else 0.0)
        )

    def scale(self) -> float:
        """Time in which it may change by as much as it is away from zero."""
        away, rate = float(self.g.abs_upper()), float(self.rate.abs_upper())
        pace = rate + (float(self.bound) * away) ** 0.5
        return max(away / pace if pace > 0 else 0.0, SHORTEST)

    def crosses(self, s: arb, h: arb | float) -> bool:
        """Whether it falls through zero once in (s, s + h], for all parameters."""
        swing = arb(0, self.bound) * h
        return bool(self.rate + swing < 0 and spread(self.wave(s + h)) < 0)

    def dips(self, s: arb, h: arb | float) -> bool:
        """Whether it has one minimum in (s, s + h] and is positive at the end."""
        if not spread(self.bend(s)) - self.bound_3 * h > 0:
            return False
        return bool(spread(self.wave(s + h)) > 0 and spread(self.slope(s + h)) > 0)


def possible_events(phase: Phase | TaylorStep, *, at_touch: bool = False) -> list[Event]:
    """Return the first event of a phase; several if the box leaves open which it is.

    With `at_touch`, a block that may graze lands at the extremum of its velocity: so a block lands
    that just touches, and the states agree to first order there. Otherwise the time of landing is
    enclosed for the whole box, and gradients are lost.
    """
    signals = [Signal(*signal) for signal in phase.signals]
    s = arb(0)
    missed: tuple[Decision, ...] = ()
    found: list[Event] = []
    windows = 0
    for _ in range(STEPS):
        basis = signals[0].wave.basis(s)  # all waves of a phase have the same frequencies
        for signal in signals:
            signal.reach(basis, outward(phase.reach - s)[0])
        if (event := _clean(signals, s)) is not None:
            return [*found, _with(event, missed)]
        if s > KNOWN * phase.reach:
            return [*found, Event(None, 0, s, missed)]
        if (h := _safe_step(signals)) is not None:
            s = (s + h).mid()
        else:
            try:
                events, goes_on, s = _window(signals, s, at_touch)
            except Undecided:
                if s > 0 and phase.reach.is_finite():  # the next step sees further
                    return [*found, Event(None, 0, s, missed)]
                raise
            found += [_with(event, missed) for event in events]
            if goes_on is None:
                return found
            missed += goes_on
            windows += 1
            if windows > QUIET:
                raise Undecided("the box is too wide to tell the next event")
        if s > LONGEST:
            raise Undecided(f"no event within {LONGEST:g} time units")
    raise Undecided(f"no event proven in {STEPS} steps")


def _with(event: Event, before: tuple[Decision, ...]) -> Event:
    return Event(event.block, event.end, event.time, before + event.decisions)


def _safe_step(signals: list[Signal]) -> float | None:
    """Return a time in which nothing happens; None if the box leaves open too much for one."""
    steps = [signal.safe() for signal in signals]
    h = min(CAUTION * min(steps), signals[0].room)
    for signal, longest in zip(signals, steps, strict=True):
        blocks = not signal.rate > 0 and CAUTION * longest <= 2 * h
        if blocks and float(signal.g.lower()) < VAGUE * float(signal.g.rad()):
            return None
    for _ in range(8):
        if all(signal.stays(h) for signal in signals):
            return h
        h *= 0.5
    return None


def _clean(signals: list[Signal], s: arb) -> Event | None:
    """Return the event if one signal crosses while all others stay positive."""
    for signal in signals:
        if not (signal.g > 0 and signal.rate < 0):
            continue
        h = _beyond(signal)
        others = (other for other in signals if other is not signal)
        if signal.crosses(s, h) and all(x.stays(h) for x in others):
            return Event(signal.block, signal.end, root(signal.wave, hull(s, s + h)))
    return None


def _beyond(signal: Signal) -> float:
    """Propose a time by which a falling signal is negative on the whole box."""
    slowest = -float(signal.rate.upper())
    return 1.3 * float(signal.g.upper()) / slowest if slowest > 0 else 0.0


def _window(
    signals: list[Signal], s: arb, at_touch: bool
) -> tuple[list[Event], tuple[Decision, ...] | None, arb]:
    """Return the events that may come in a short time, what holds if none does, and its end."""
    # The time is short enough for each signal to be monotone or to have one minimum in it, and long
    # enough for each to be clear of zero at its end.
    h = max(
        CAUTION * min(x.safe() for x in signals),
        min((x.scale() for x in signals if not x.rate > 0), default=SHORTEST),
    )
    quiet = None
    for _ in range(GROWTHS):
        kinds = [_fate(x, s, h) for x in signals]
        if set(kinds) == {"stays"}:
            quiet = (s + h).mid()
        elif None not in kinds:
            return _fork(signals, kinds, s, h, at_touch)
        h *= 1.6
    if quiet is not None:
        return [], (), quiet
    raise Undecided("the box is too wide to tell the next event")


def _fate(x: Signal, s: arb, h: float) -> str | None:
    """How a signal goes through the window."""
    if x.stays(h):
        return "stays"
    if x.crosses(s, h):
        return "crosses"
    return "dips" if x.rate < 0 and x.dips(s, h) else None


def _fork(
    signals: list[Signal], kinds: list[str | None], s: arb, h: float, at_touch: bool
) -> tuple[list[Event], tuple[Decision, ...] | None, arb]:
    """Return what `_window` does, given how each signal goes through it."""
    crossing = [x for x, kind in zip(signals, kinds, strict=True) if kind == "crosses"]
    dipping = [x for x, kind in zip(signals, kinds, strict=True) if kind == "dips"]
    if len(crossing) + len(dipping) > 2 or len(dipping) > 1:
        raise Undecided("three events, or two grazes, may coincide")
    times = [root(x.wave, _start(x, s, h)) for x in crossing]
    end = (s + h).mid()
    if not dipping:
        asked = _tie(crossing, times) if len(crossing) == 2 else [()]
        events = zip(crossing, times, asked, strict=True)
        return [Event(x.block, x.end, t, question) for x, t, question in events], None, end
    (x,) = dipping
    touch, margin = _touch(x, s, h, at_touch)
    misses, touches = (
        (Decision("graze", (x.block + 1,), margin, sign, answer),)
        for sign, answer in ((1, "misses"), (-1, "touches"))
    )
    found = [Event(x.block, x.end, touch, touches)]
    found += [Event(y.block, y.end, t, misses) for y, t in zip(crossing, times, strict=True)]
    return found, None if crossing else misses, end


def _tie(pair: list[Signal], times: list[Number]) -> list[tuple[Decision, ...]]:
    """Ask which of two events comes first."""
    x, y = pair
    blocks = tuple(sorted({x.block + 1, y.block + 1}))
    margin = y.wave(times[0])
    return [
        (Decision("tie", blocks, margin, sign, _first(each)),) for each, sign in ((x, 1), (y, -1))
    ]


def _start(x: Signal, s: arb, h: float) -> arb:
    """Return a window with the root for all parameters, also those of the continuation."""
    if x.g > 0:
        return hull(s, s + h)
    back = 1e-300
    for _ in range(400):
        if spread(x.wave(s - back)) > 0 and spread(x.slope(hull(s - back, s + h))) < 0:
            return hull(s - back, s + h)
        back *= 8
        if back > 1:
            break
    raise Undecided("an event at the start of a phase is not transversal")


def _touch(x: Signal, s: arb, h: float, at_touch: bool) -> tuple[Number, Number]:
    """Return when a block lands that may graze, and the margin: the least slip speed."""
    bottom = root(x.slope, hull(s, s + h))
    margin = x.wave(bottom)
    if at_touch or isinstance(bottom, arb):
        return bottom, margin
    # Beyond the landing the signal falls by at least half its least bend times the time squared.
    first, last = s, bottom.range.upper()
    bend = spread(x.bend(hull(s, last)))
    if bend > 0:
        ahead = (-2 * spread(margin) / bend).nonnegative_part().sqrt()
        first = first.max((bottom.range - ahead).lower())
    return bottom.vague(hull(first, last)), margin


def _first(x: Signal) -> str:
    what = "is released" if x.end else "comes to rest"
    return f"block {x.block + 1} {what} first"
