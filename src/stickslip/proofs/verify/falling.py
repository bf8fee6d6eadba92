"""Motion under law (9): Taylor polynomials, with remainders on boxes that Picard proves to hold it.

The certifier bounds the whole tail instead.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from flint import arb, arb_series, ctx

from stickslip.proofs.verify.motion import GLYPHS, Motion, Signal, flat
from stickslip.proofs.verify.words import Refused

SHORTEST: Final = 2.0**-12  # a step
MOST_STEPS: Final = 5000


class Piece:
    """A polynomial in time with series in d as coefficients, for 0 <= t <= length."""

    def __init__(self, terms: list[Any], length: arb) -> None:
        self.terms, self.length = terms, length

    def __call__(self, t: Any) -> Any:
        """Value at t."""
        value = self.terms[-1]
        for c in self.terms[-2::-1]:
            value = value * t + c
        return value

    def derivative(self) -> Piece:
        """Return the derivative."""
        return Piece([c * k for k, c in enumerate(self.terms)][1:], self.length)

    def times(self, k: Any) -> Piece:
        """Multiply by k."""
        return Piece([c * k for c in self.terms], self.length)

    def __add__(self, other: Piece) -> Piece:
        return Piece([a + b for a, b in zip(self.terms, other.terms, strict=True)], self.length)

    def above(self, low: Any) -> Piece:
        """Subtract a level."""
        return Piece([self.terms[0] - low, *self.terms[1:]], self.length)

    def range(self) -> Piece:
        """Forget the derivatives in d."""
        return Piece([flat(c) for c in self.terms], self.length)

    def bound(self) -> arb:
        """Largest second derivative on the step."""
        bend = self.derivative().derivative()
        return sum((abs(c) * self.length**k for k, c in enumerate(bend.terms)), arb(0))


class FallingMotion(Motion):
    """Two blocks with law (9), parameters exact."""

    law = ("gamma", "delta", "eta")

    def __init__(self, values: dict[str, str], **replaced: arb) -> None:
        super().__init__(values, **replaced)
        self.order = ctx.prec // 4
        self.length = arb(2) ** -4  # of the next step, to begin with

    def _follow(self, state: Any, words: list[str], sure: bool) -> Iterator[Any]:
        """Follow Taylor steps to the next event, and so on to global stick."""
        x, v, modes = state
        if not sure:
            raise Refused("which block is released first cannot be told")
        words = [GLYPHS[modes[0]] + GLYPHS[modes[1]]]
        released: int | None = 0 if modes[0] else 1
        for _ in range(MOST_STEPS):
            if modes == (0, 0):
                value = self.reached = x[1] - x[0]
                yield " ".join(words), value[0], value[1]
                return
            pieces, length = self._expand(x, v, modes, released)
            signals = self._signals(pieces, modes)  # type: ignore[arg-type]
            event = self._first_on(signals, length, released)
            t = length if event is None else event[1]
            x = [piece(t) for piece in pieces]
            v = [piece.derivative()(t) if modes[i] else self.V for i, piece in enumerate(pieces)]
            released = None
            if event is None:
                continue
            signal = event[0]
            i = signal.block
            v[i] = self.V
            ((mode, certain),) = self._modes_after(signal, self._need(x, i))[:1]
            if not certain:
                raise Refused(f"block {i + 1} lands with its force about at the static limit")
            released = i if signal.end else None
            modes = (mode, modes[1]) if i == 0 else (modes[0], mode)
            word = GLYPHS[modes[0]] + GLYPHS[modes[1]]
            if word != words[-1]:
                words.append(word)
        raise Refused(f"no global stick within {MOST_STEPS} steps")

    def _first_on(
        self, signals: list[Signal], length: arb, released: int | None
    ) -> tuple[Signal, arb_series] | None:
        """Return the first event on a step, proven to be the first; None if there is none."""
        t, h = arb(0), length
        while t < length:
            open_ = [s for s in signals if not self._stays(s, t, h, released)]
            if not open_:
                t = (t + h).mid()
                h = (length - t).mid()
            elif len(open_) == 1 and open_[0].falls(t, h):
                return open_[0], open_[0].root(t.union(t + h))
            elif h > self.shortest:
                h = (h / 2).mid()
            elif t > 0:
                raise Refused("the next event cannot be told")
            else:
                raise Refused("the start of a slip cannot be told")
        return None

    def _stays(self, s: Signal, t: arb, h: arb, released: int | None) -> bool:
        if t == 0 and s.block == released and not s.end:
            # g = g' = 0 at the start: g'' > 0 on the step is enough.
            return bool(s.rate.derivative()(h / 2 + arb(0, (h / 2).upper())) > 0)
        return s.stays(t, h)

    def _rates(self, x: list[Any], v: list[Any], modes: tuple[int, int]) -> list[Any]:
        """Return the accelerations."""
        found = []
        for i, mode in enumerate(modes):
            if not mode:
                found.append(arb_series([0]))
                continue
            gamma, delta, eta = self.laws[i]
            s = (v[i] - self.V) * mode
            force = (1 - delta) / (1 + gamma * s) + delta + eta * s * s
            need = (1 + self.alpha) * x[i] - self.alpha * x[1 - i]
            found.append(force * (-mode * self.limits[i]) - need)
        return found

    def _regular(self, v: list[Any], modes: tuple[int, int]) -> bool:
        """Whether the law is defined on a box: 1 + gamma s > 0."""
        pairs = zip(v, modes, self.laws, strict=True)
        return all(1 + law[0] * mode * (flat(u) - self.V) > 0 for u, mode, law in pairs if mode)

    def _box(self, x: list[Any], v: list[Any], modes: tuple[int, int], h: arb) -> Any:
        """Return where positions and velocities are proven to stay for a time h."""
        span = arb(0).union(h)
        box = [*x, *v]
        for _ in range(12):
            wide = [_wider(b) for b in box]
            if not self._regular(wide[2:], modes):
                return None
            rates = [*wide[2:], *self._rates(wide[:2], wide[2:], modes)]
            new = [a + r * span for a, r in zip([*x, *v], rates, strict=True)]
            if all(_within(a, b) for a, b in zip(new, wide, strict=True)):
                return new[:2], new[2:]
            box = new
        return None

    def _terms(
        self, x: list[Any], v: list[Any], modes: tuple[int, int], released: int | None, order: int
    ) -> list[list[Any]]:
        """Return the Taylor coefficients of both positions."""
        terms = [[x[i], v[i]] for i in (0, 1)]
        speeds: list[list[Any]] = [[], []]
        shares: list[list[Any]] = [[], []]  # 1 / (1 + gamma s)
        for k in range(order - 1):
            for i, mode in enumerate(modes):
                if not mode:
                    terms[i].append(arb_series([0]))
                    continue
                gamma, delta, eta = self.laws[i]
                s = terms[i][k + 1] * ((k + 1) * mode)
                speeds[i].append(s - self.V * mode if k == 0 else s)
                s, r = speeds[i], shares[i]
                r.append(1 / (1 + gamma * s[0]) if k == 0 else -gamma * r[0] * _dot(s[1:], r))
                force = (1 - delta) * r[k] + (delta if k == 0 else 0)
                if not eta.is_zero():
                    force = force + eta * _dot(s, s)
                need = (1 + self.alpha) * terms[i][k] - self.alpha * terms[1 - i][k]
                rate = force * (-mode * self.limits[i]) - need
                if k == 0 and i == released:
                    rate = arb_series([0])
                terms[i].append(rate / ((k + 1) * (k + 2)))
        return terms

    def _expand(
        self, x: list[Any], v: list[Any], modes: tuple[int, int], released: int | None
    ) -> tuple[list[Piece], arb]:
        """Return both positions as polynomials that enclose them, and for how long."""
        x, v = [arb_series(a) if isinstance(a, arb) else a for a in x], [_series(a) for a in v]
        terms = self._terms(x, v, modes, released, self.order)
        h = self.length
        while h > SHORTEST:
            box = self._box(x, v, modes, h)
            if box is not None:
                last = [c[-1] for c in self._terms(box[0], box[1], modes, None, self.order + 1)]
                worst = max(float((abs(flat(c)) * h ** (self.order + 1)).upper()) for c in last)
                if worst < 2.0 ** (-0.7 * ctx.prec):
                    self.length = (h * 1.2).mid()
                    return [Piece([*t, c], h) for t, c in zip(terms, last, strict=True)], h
            h = (h * 0.7).mid()
        raise Refused("the ball is too wide for a Taylor step")


def _series(x: Any) -> arb_series:
    return x if isinstance(x, arb_series) else arb_series([x])


def _dot(xs: list[Any], ys: list[Any]) -> Any:
    return sum((a * b for a, b in zip(xs, ys[::-1], strict=True)), arb_series([0]))


def _wider(x: Any) -> arb_series:
    margins = [c.rad() * 0.2 + abs(c) * 1e-6 + 1e-30 for c in _parts(x)]
    return arb_series([c + arb(0, m.upper()) for c, m in zip(_parts(x), margins, strict=True)])


def _parts(x: Any) -> list[arb]:
    return [x[k] for k in range(ctx.cap)]


def _within(a: Any, b: Any) -> bool:
    return all(q.contains(p) for p, q in zip(_parts(a), _parts(b), strict=True))
