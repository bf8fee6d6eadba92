"""One step of all lanes, from a law's series: Python that runs on arrays, or is written out.

Speeds are s = sign w >= 0; a force e of the contacts obeys e' = DRIFT + STIFF w + CROSS w_other +
DAMP w' + DRAG w_other' (`layout`). Rows of a block: 0 its speed, then what its law's series needs.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from types import ModuleType
from typing import Any, Final

from stickslip.mechanics.flow.dense import OFF, UNHEEDED
from stickslip.mechanics.flow.lanes import layout as at
from stickslip.mechanics.flow.lanes.layout import ORDER
from stickslip.mechanics.friction.series import STATIC_COLUMN, LawSeries
from stickslip.numerics.series import Lines, indented
from stickslip.numerics.targets import instantiate
from stickslip.numerics.vector import (
    LANES,
    Floats,
    Lanes,
    bits,
    from_bits,
    load,
    of_lanes,
    polynomial,
    select,
    store,
    written,
)

# Signals nearer zero than this are events: SLACK of `dense`, in units of the last place.
EPSILON: Final = 2.0**-52
SLACK: Final = 4.0 * EPSILON
LIMIT_SLACK: Final = 64.0 * EPSILON
# Of doubles as integers: the fraction's bits, the exponents of 1 and of 2^52, above which integers
# are the last bits.
FRACTION: Final = 2**52 - 1
ONE: Final = 1023 << 52
TWO_52: Final = 1075 << 52
EXPONENT_ZERO: Final = 2.0**52 + 1023.0
ROUNDER: Final = 1.5 * 2.0**52
FINITE: Final = 1e300
SHORTEST: Final = -40.0  # log2 of the shortest step

SPEED, FORCE, SIGN = (at.SPEED_1, at.SPEED_2), (at.FORCE_1, at.FORCE_2), (at.SIGN_1, at.SIGN_2)
D_SPEED, D_FORCE = (at.D_SPEED_1, at.D_SPEED_2), (at.D_FORCE_1, at.D_FORCE_2)
SERIES, D_SERIES = (at.SERIES_1, at.SERIES_2), (at.D_SERIES_1, at.D_SERIES_2)
FORCE_BEFORE = (at.FORCE_1_BEFORE, at.FORCE_2_BEFORE)
D_FORCE_BEFORE = (at.D_FORCE_1_BEFORE, at.D_FORCE_2_BEFORE)

Rows = dict[tuple[int, int], Lanes]  # coefficients, by row and order
Terms = dict[int, Lanes]  # coefficients of one series, by order


@lru_cache(maxsize=64)  # numba keeps all that is ever made for code
def lane_kernels(series: LawSeries, *, damped: bool = False, changing: bool = False) -> ModuleType:
    """Make the kernels of a law's steps, and ``SIZE`` of `taken`.

    Tangents go with the start, or with a parameter (`changing`), which may be a damper's.
    """
    steps = Steps(series, damped, changing)
    return instantiate(
        "stickslip.mechanics.flow.lanes._step_kernels",
        f"{series.key}-{LANES}" + "-damped" * damped + "-changing" * changing,
        SIZE=steps.size,
        write_step_one=written(partial(steps.step, 1)),
        write_step_both=written(partial(steps.step, 2)),
        write_tangent_one=written(partial(steps.tangent, 1)),
        write_tangent_both=written(partial(steps.tangent, 2)),
        write_turns_one=written(partial(steps.turns, 1)),
        write_turns_both=written(partial(steps.turns, 2)),
    )


@dataclass(frozen=True)
class Steps:
    """Steps of the motions under one law."""

    series: LawSeries
    damped: bool = False
    changing: bool = False

    # --- values ---------------------------------------------------------------------------

    def step(self, n: int, x: Floats, taken: Floats, p: Floats, q: Floats, c: Floats) -> None:
        """Step lanes of which the first block slips, or both do."""
        both, (p, q, c) = range(n), map(_OfModels, (p, q, c))
        sign = [load(x, SIGN[i]) for i in both]
        force = [load(x, FORCE[i]) for i in range(2)]
        rows, integral = self._speeds([load(x, SPEED[i]) for i in both], sign, force, (p, q), c)
        power = _power(c, load(x, at.LAST_TERM), rows, integral)
        halved = None if self.series.tells else load(x, at.HALVED)
        if halved is not None:
            halved = select(halved > 0.0, halved, 0.0)
        h = length(power if halved is None else power - halved)

        signals = [speed_signal(rows[i], h) for i in both]
        sizes, clear = [signal[0] for signal in signals], [signal[1] for signal in signals]
        end = [falling(h, speeds(rows[i]), 0) for i in both]
        path = [falling(h, integral[i], 1) * h for i in both]
        gained = [sign[i] * (end[i] - rows[i][0, 0]) for i in both]
        starts = [force[i] + c[at.DRIFT + i] * h for i in range(2)]
        force_end = self._forces(starts, sign, [(c, path, gained)])

        if n == 1:
            tail = signals[0][2]
            rider = self._rider(c, sign[0], rows[0], h, tail, clear[0], force[1], force_end[1])
            sizes.append(rider[0])
            sound = abs(end[0]) + abs(force_end[0]) < FINITE
            flag = select(clear[0], 0.0, 1.0) + select(rider[1], 0.0, 2.0)
            flag = flag + select(rider[2], 0.0, 4.0)
        else:
            sound = abs(end[0]) + abs(end[1]) + abs(force_end[0]) + abs(force_end[1]) < FINITE
            sound = sound & self._may_return(c, sign, rows, force)
            flag = select(clear[0], 0.0, 1.0) + select(clear[1], 0.0, 2.0)

        steps, time = load(x, at.STEPS) + 1.0, load(x, at.TIME)
        if halved is not None:
            # No step at all, and half of it next; the more steps go well, the longer again.
            followed = self._follows_laws(c, load(x, at.LAST_TERM), h, rows, (p, q))
            store(x, at.HALVED, halved + select(followed, -1.0, 1.0))
            h, flag = select(followed, h, 0.0), select(followed, flag, 0.0)
            sound = (sound | ~followed) & (halved < at.MOST_HALVINGS)
            end = [select(followed, end[i], rows[i][0, 0]) for i in both]
            force_end = [select(followed, force_end[i], force[i]) for i in range(2)]
        sound = sound & (power > SHORTEST) & (steps < at.MOST_STEPS)
        store(x, at.STEPS, steps)
        store(taken, at.FLAG, flag + select(sound, 0.0, 8.0))
        store(taken, at.LENGTH, h)
        store(taken, at.TIME_BEFORE, time)
        store(x, at.TIME, time + h)
        for i in range(2):
            store(taken, (at.SIZE_1, at.SIZE_2)[i], sizes[i])
            store(taken, FORCE_BEFORE[i], force[i])
            store(x, FORCE[i], force_end[i])
        for i in both:
            store(x, SPEED[i], end[i])
            self._keep(taken, i, rows[i])

    def _speeds(
        self, speed: Sequence[Lanes], sign: Sequence[Lanes], force: Sequence[Lanes],
        numbers: Sequence[Floats], c: Floats,
    ) -> tuple[list[Rows], list[Terms]]:  # fmt: skip
        """Series of the speeds, with their laws' rows, and of the speeds' integrals."""
        start = self._law(self.series.force.start)
        advance = self._law(self.series.force.advance)
        both = range(len(speed))
        rows: list[Rows] = [{(0, 0): speed[i]} for i in both]
        integral: list[Terms] = [{} for _ in both]
        loading_of = self._loadings(c, sign)

        def coefficient(i: int, k: int) -> Lanes:
            """Coefficient k + 1 of a speed: s' = -limit F(s) - sign e."""
            # What does not depend on the newest coefficient is multiplied out beforehand: the
            # recurrence is a chain of operations that wait for each other.
            (start if k == 0 else advance)(rows[i], numbers[i], k)
            if k == 0:
                at_rest = rows[i][0, 0] == 0.0
                rows[i][1, 0] = select(at_rest, numbers[i][STATIC_COLUMN], rows[i][1, 0])
                pull = -c[at.LIMIT + i] * rows[i][1, 0] - sign[i] * force[i]
                # From rest with F(0) = 1 a slip starts with zero acceleration.
                return select(at_rest & (abs(pull) <= SLACK * c[at.LIMIT + i]), 0.0, pull)
            loading = loading_of(i, k, integral, rows, 1.0 / (k + 1))
            if k == 1:
                loading = loading + sign[i] * (0.5 * c[at.DRIFT + i])
            return (-c[at.LIMIT + i] * (1.0 / (k + 1))) * rows[i][1, k] - loading

        for k in range(ORDER):
            newest = [coefficient(i, k) for i in both]
            for i in both:
                rows[i][0, k + 1] = newest[i]
                integral[i][k + 1] = rows[i][0, k] * (1.0 / (k + 1))
        return rows, integral

    def _follows_laws(
        self, c: Floats, last_term: Lanes, h: Lanes, rows: Sequence[Rows], numbers: Sequence[Floats]
    ) -> Lanes:
        """Whether the series of the laws are the laws, as far as places on the step tell."""
        law = self._law(self.series.force.start)
        follows: Any = h > 0.0
        for i, share in itertools.product(range(len(rows)), (0.5, 1.0)):
            t = h * share
            speed = falling(t, speeds(rows[i]), 0)
            there: Rows = {(0, 0): select(speed > 0.0, speed, 0.0)}
            law(there, numbers[i], 0)
            told = polynomial(t, *(rows[i][1, k] for k in range(ORDER - 1, -1, -1)))
            off = (abs(told - there[1, 0]) - UNHEEDED * abs(there[1, 0])) * (c[at.LIMIT + i] * h)
            # Beyond a landing the series goes on, which is looked at where it is.
            follows = follows & ((off <= OFF * length(last_term)) | (speed < 0.0))
        return follows

    def _rider(
        self, c: Floats, sign: Lanes, rows: Rows, h: Lanes, tail: Lanes, clear: Lanes,
        force: Lanes, force_end: Lanes,
    ) -> tuple[Lanes, Lanes, Lanes]:  # fmt: skip
        """Size of the terms of a rider's force, and whether it stays off both limits.

        e' = DRIFT + CROSS w + DRAG w': where it only grows, as next to a block that slips backward,
        its end decides; else both limits are bounded, the terms of degree 3 by the speed's.
        """
        cross, drag = c[at.CROSS + 1], c[at.DRAG + 1]
        linear = (c[at.DRIFT + 1] + cross * sign * rows[0, 0]) * h
        square = 0.5 * cross * sign * rows[0, 1] * h * h
        third = abs(rows[0, 2]) * h * h * 0.3333333333333334
        most = abs(cross) * h * (third + tail * 0.25)
        if self.damped:
            linear = linear + drag * sign * rows[0, 1] * h
            square = square + drag * sign * rows[0, 2] * h * h
            most = most + abs(drag) * tail
        size = abs(linear) + abs(square) + most
        near = LIMIT_SLACK * (c[at.LIMIT + 1] + size)
        down = select(linear < 0.0, linear, 0.0) + select(square < 0.0, square, 0.0) - most
        up = select(linear > 0.0, linear, 0.0) + select(square > 0.0, square, 0.0) + most
        grows = (c[at.LONE + 1] * sign >= 0.0) & clear
        above = c[at.LIMIT + 1] - select(grows, force_end, force + up) > near
        below = (c[at.LIMIT + 1] + force + down > near) | grows
        return size, above, below

    def _may_return(
        self, c: Floats, sign: Sequence[Lanes], rows: Sequence[Rows], force: Sequence[Lanes]
    ) -> Lanes:
        """Whether two blocks do not slip backward with too little energy to reach the belt."""
        y = [c[at.BELT] + sign[i] * rows[i][0, 0] for i in range(2)]
        r = [force[i] - c[at.STEADY + i] for i in range(2)]
        if self.damped:
            r = [r[i] - c[at.DAMP + i] * y[i] - c[at.DRAG + i] * y[1 - i] for i in range(2)]
        energy = c[at.MASS] * y[0] * y[0] + c[at.MASS + 1] * y[1] * y[1]
        energy = energy + c[at.SPRING_BOTH] * r[0] * r[1]
        energy = energy + c[at.SPRING] * r[0] * r[0] + c[at.SPRING + 1] * r[1] * r[1]
        return (sign[0] > 0.0) | (sign[1] > 0.0) | (energy >= c[at.FLOOR])

    # --- tangents -------------------------------------------------------------------------

    def tangent(self, n: int, x: Floats, taken: Floats, p: Floats, q: Floats, c: Floats) -> None:
        """Carry derivatives through the step that was taken last."""
        both, (p, q, c) = range(n), map(_OfModels, (p, q, c))
        sign = [load(x, SIGN[i]) for i in both]
        d_force = [load(x, D_FORCE[i]) for i in range(2)]
        rows = [self._kept(taken, i) for i in both]
        h = load(taken, at.LENGTH)
        force = [load(taken, FORCE_BEFORE[i]) for i in both]
        d_speed = [load(x, D_SPEED[i]) for i in both]
        d, d_integral = self._tangents(d_speed, d_force, rows, sign, force, (p, q), c)

        end = [falling(h, d[i], 0) for i in both]
        path = [falling(h, d_integral[i], 1) * h for i in both]
        gained = [sign[i] * (end[i] - d[i][0]) for i in both]
        gains: list[tuple[Any, Sequence[Lanes], Sequence[Lanes]]] = [(c, path, gained)]
        if self.changing:
            moved = [falling(h, integral_of(rows[i]), 1) * h for i in both]
            faster = [sign[i] * (load(x, SPEED[i]) - rows[i][0, 0]) for i in both]
            gains.append((_Change(c), moved, faster))
        force_end = self._forces(d_force, sign, gains)
        if self.changing:
            force_end = [force_end[i] + c[at.CHANGE + at.DRIFT + i] * h for i in range(2)]
        for i in both:
            store(x, D_SPEED[i], end[i])
            for k in range(ORDER + 1):
                store(taken, D_SERIES[i] + k * LANES, d[i][k])
        for i in range(2):
            store(taken, D_FORCE_BEFORE[i], d_force[i])
            store(x, D_FORCE[i], force_end[i])

    def _tangents(
        self, d_speed: Sequence[Lanes], d_force: Sequence[Lanes], rows: Sequence[Rows],
        sign: Sequence[Lanes], force: Sequence[Lanes], numbers: Sequence[Floats], c: Floats,
    ) -> tuple[list[Terms], list[Terms]]:  # fmt: skip
        """Series of the speeds' derivatives, and of the integrals of these."""
        parts = [self.series.slope, *[self.series.change] * self.changing]
        start = self._law([line for part in parts for line in part.start])
        advance = self._law([line for part in parts for line in part.advance])
        both = range(len(d_speed))
        d: list[Terms] = [{0: d_speed[i]} for i in both]
        d_integral: list[Terms] = [{} for _ in both]
        integral = [integral_of(rows[i]) for i in both if self.changing]
        loading_of = self._loadings(c, sign)
        # With a parameter the equations change, too: the force's part of -L' F is
        # (L' / L) (s' + sign e), which leaves of their numbers' changes what follows.
        scaled = [c[at.CHANGE + at.LIMIT + i] / c[at.LIMIT + i] for i in both if self.changing]
        left = _Left(c, scaled)
        moved_loading = self._loadings(left, sign)

        slope: list[list[Any]] = [[], []]  # of the accelerations in the speeds
        for i, k in itertools.product(both, range(ORDER)):
            (start if k == 0 else advance)(rows[i], numbers[i], k)
            slope[i].append(-c[at.LIMIT + i] * rows[i][2, k])
        sums: list[list[Any]] = [[0.0] * ORDER for _ in both]

        def coefficient(i: int, k: int) -> Lanes:
            """Coefficient k + 1 of a speed's derivative: the newest one comes in last."""
            found = sums[i][k]
            if self.changing:
                found = found - c[at.LIMIT + i] * rows[i][self.series.change_row, k]
                if k == 0:
                    found = found + scaled[i] * (sign[i] * force[i])
                else:
                    found = found + moved_loading(i, k, integral, rows)
                    if k == 1:
                        found = found + sign[i] * left[at.DRIFT + i]
            if k == 0:
                found = found - sign[i] * d_force[i]
            else:
                found = found - loading_of(i, k, d_integral, [{(0, k): d[j][k]} for j in both])
            found = (found + slope[i][0] * d[i][k]) * (1.0 / (k + 1))
            return found + scaled[i] * rows[i][0, k + 1] if self.changing else found

        for k in range(ORDER):
            newest = [coefficient(i, k) for i in both]
            for i in both:
                # All sums that need it take it at once: it stays in a register, and so do they.
                for later in range(k + 1, ORDER):
                    sums[i][later] += slope[i][later - k] * d[i][k]
                d[i][k + 1] = newest[i]
                d_integral[i][k + 1] = d[i][k] * (1.0 / (k + 1))
        return d, d_integral

    # --- margins --------------------------------------------------------------------------

    def turns(self, n: int, x: Floats, taken: Floats, c: Floats) -> None:
        """Flag lanes in which a speed, or a rider's force, may turn back on the last step."""
        both, c = range(n), _OfModels(c)
        sign, rows = [load(x, SIGN[i]) for i in both], [self._kept(taken, i) for i in both]
        shapes = [_shape(each, load(taken, at.LENGTH)) for each in rows]
        extreme = shapes[0].may_turn_up | shapes[-1].may_turn_up
        if n == 1:
            extreme = extreme | self._rider_turns(c, sign[0], rows[0], shapes[0], load(x, SPEED[0]))
        store(taken, at.FLAG, load(taken, at.FLAG) + select(extreme, float(at.EXTREME), 0.0))

    def _rider_turns(
        self, c: Floats, sign: Lanes, rows: Rows, shape: _Shape, speed_end: Lanes
    ) -> Lanes:
        """Whether a rider's force may turn back: where its rate vanishes."""
        # The rate turns where the speed does.
        cross, drag = c[at.CROSS + 1], c[at.DRAG + 1]
        rate = c[at.DRIFT + 1] + cross * sign * rows[0, 0]
        rate_end = c[at.DRIFT + 1] + cross * sign * speed_end
        monotone = shape.rises | shape.falls
        if self.damped:
            rate = rate + drag * sign * rows[0, 1]
            rate_end = rate_end + drag * sign * shape.end
            monotone = monotone & (shape.convex | shape.concave)
        return (rate * rate_end < 0.0) | ~monotone

    # --- both -----------------------------------------------------------------------------

    def _loadings(self, c: Any, sign: Sequence[Lanes]) -> Callable[..., Lanes]:
        """How to compute a share of coefficient k of sign e, from speeds and their integrals."""
        unlike = sign[0] * sign[1] if len(sign) == 2 else None

        def loading(
            i: int, k: int, integral: Sequence[Terms], rows: Sequence[Rows], share: float = 1.0
        ) -> Lanes:
            total = (c[at.STIFF + i] * share) * integral[i][k]
            if self.damped:
                total = total + (c[at.DAMP + i] * share) * rows[i][0, k]
            if unlike is not None:
                total = total + (c[at.CROSS + i] * unlike * share) * integral[1 - i][k]
                if self.damped:
                    total = total + (c[at.DRAG + i] * unlike * share) * rows[1 - i][0, k]
            return total

        return loading

    def _forces(
        self,
        starts: Sequence[Lanes],
        sign: Sequence[Lanes],
        gains: Sequence[tuple[Any, Sequence[Lanes], Sequence[Lanes]]],
    ) -> list[Lanes]:
        """Return the forces at the end: numbers, and the integrals and speeds they multiply."""
        ends = list(starts)
        for i in range(2):
            for j in (i, 1 - i):
                if j < len(sign):
                    stiff, damp = (at.STIFF, at.DAMP) if i == j else (at.CROSS, at.DRAG)
                    for c, integral, gained in gains:
                        ends[i] = ends[i] + sign[j] * (c[stiff + i] * integral[j])
                        if self.damped:
                            ends[i] = ends[i] + c[damp + i] * gained[j]
        return ends

    def _keep(self, taken: Floats, i: int, rows: Rows) -> None:
        """Keep what tangents and events need of a block's series."""
        for k in range(ORDER + 1):
            store(taken, SERIES[i] + k * LANES, rows[0, k])
        for row in self.kept_rows:
            for k in range(ORDER):
                store(taken, self._place(i, row) + k * LANES, rows[row, k])

    def _kept(self, taken: Floats, i: int) -> Rows:
        rows = {(0, k): load(taken, SERIES[i] + k * LANES) for k in range(ORDER + 1)}
        for row in self.kept_rows:
            for k in range(ORDER):
                rows[row, k] = load(taken, self._place(i, row) + k * LANES)
        return rows

    def _law(self, lines: Lines) -> Callable[[Rows, Floats, int], None]:
        """Make a function of the text that computes coefficient k of the rows of a law."""
        scope: dict[str, Any] = {"math": of_lanes}
        exec("\n".join(["def law(rows, p, k):", *indented([*lines, "return"])]), scope)
        law: Callable[[Rows, Floats, int], None] = scope["law"]
        return law

    @cached_property
    def kept_rows(self) -> list[int]:
        """Rows of the force's series that the slope's reads."""
        text = "\n".join(self.series.slope.start + self.series.slope.advance)
        own = set(re.findall(r"^ *rows\[(\d+), [0k]\] =", text, re.MULTILINE))
        return sorted(map(int, set(re.findall(r"rows\[(\d+), ", text)) - own - {"0"}))

    @property
    def size(self) -> int:
        """Size of the array of what a step has taken."""
        return self._place(2, None)

    def _place(self, i: int, row: int | None) -> int:
        """Where a block's kept rows begin, or one of them."""
        before = i * len(self.kept_rows) + (0 if row is None else self.kept_rows.index(row))
        return at.LAW_ROWS + before * ORDER * LANES


class _OfModels:
    """Numbers of models, each lane with its own."""

    def __init__(self, rows: Floats) -> None:
        self.rows = rows

    def __getitem__(self, place: int) -> Lanes:
        return load(self.rows, place * at.PLACES)


class _Change:
    """How the numbers of the contacts change with a parameter."""

    def __init__(self, c: Floats) -> None:
        self.c = c

    def __getitem__(self, place: int) -> Lanes:
        return self.c[at.CHANGE + place]


class _Left(_Change):
    """What scaling the limit leaves of the change, the other way."""

    def __init__(self, c: Floats, scaled: Sequence[Lanes]) -> None:
        super().__init__(c)
        self.scaled = scaled

    def __getitem__(self, place: int) -> Lanes:
        return self.scaled[place % 2] * self.c[place] - super().__getitem__(place)


def speeds(rows: Rows) -> Terms:
    """Coefficients of a speed."""
    return {k: rows[0, k] for k in range(ORDER + 1)}


def integral_of(rows: Rows) -> Terms:
    """Coefficients of a speed's integral."""
    return {k + 1: rows[0, k] * (1.0 / (k + 1)) for k in range(ORDER)}


def _power(c: Floats, last_term: Lanes, rows: Sequence[Rows], integral: Sequence[Terms]) -> Lanes:
    """log2 of the step on which the larger of the last two terms of each series is small."""
    power: Any = 0.0
    for k in range(ORDER - 1, ORDER + 1):
        for i in range(len(rows)):
            size_s = abs(rows[i][0, k])
            size_e = c[at.STIFF + i] * abs(integral[i][k])
            size = select(size_s > size_e, size_s, size_e)
            root = logarithm_of_ratio(last_term, size) * (1.0 / k)
            power = select(root < power, root, power)
    return power


def falling(t: Lanes, terms: Terms, last: int) -> Lanes:
    """Value of a polynomial of these coefficients, down to one, over the power of that."""
    return polynomial(t, *(terms[k] for k in range(ORDER, last - 1, -1)))


def logarithm_of_ratio(last_term: Lanes, size: Lanes) -> Lanes:
    """log2 of a last term over a size, within 0.01, which is nothing after the root is taken."""
    size_bits = bits(size)
    exponent = from_bits(size_bits >> 52 | TWO_52) - EXPONENT_ZERO
    fraction = from_bits(size_bits & FRACTION | ONE) - 1.0
    return last_term - exponent - fraction * (1.3465 - 0.3465 * fraction)


def length(power: Lanes) -> Lanes:
    """2^power, at most the longest step."""
    power = select(power > SHORTEST, power, SHORTEST)
    shifted = power + ROUNDER
    rest = power - (shifted - ROUNDER)
    fraction = 1.0 + rest * (0.69315 + rest * (0.2402 + rest * 0.0555))
    h = from_bits((bits(shifted) + 1023) << 52) * fraction
    return select(h < at.LONGEST_STEP, h, at.LONGEST_STEP)


@dataclass(frozen=True)
class _Shape:
    """What is certain of a speed on a step, its slope at the end, and whether it may turn up."""

    rises: Lanes
    falls: Lanes
    convex: Lanes
    concave: Lanes
    end: Lanes
    may_turn_up: Lanes


def _shape(rows: Rows, h: Lanes) -> _Shape:
    """Bound slope and curvature on a step by their first terms and the sizes of the rest."""
    slope = {k: k * s for k, s in speeds(rows).items()}
    end = falling(h, slope, 1)
    rest = falling(h, {k: abs(s) for k, s in slope.items()}, 3) * h
    bent = falling(h, {k: (k - 1) * abs(s) for k, s in slope.items()}, 3) * h
    start, curvature = rows[0, 1], 2.0 * rows[0, 2]
    convex, concave = curvature >= bent, curvature <= -bent
    linear, rest = start + curvature * h, rest * h
    rises = (
        ((start > rest) & (linear > rest)) | (convex & (start >= 0.0)) | (concave & (end >= 0.0))
    )
    down = ((start < -rest) & (linear < -rest)) | (convex & (end <= 0.0))
    falls = down | (concave & (start <= 0.0))
    return _Shape(rises, falls, convex, concave, end, ~(rises | falls | concave))


def speed_signal(rows: Rows, h: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """Size of a speed's terms, whether it provably stays above zero, its terms of degree 3 on."""
    tail = falling(h, {k: abs(s) for k, s in speeds(rows).items()}, 3) * h * h * h
    linear = rows[0, 1] * h
    square = rows[0, 2] * h * h
    size = abs(linear) + abs(square) + tail
    rounding = SLACK + 2.0 * EPSILON * (abs(rows[0, 0]) + size)
    least = select(linear < 0.0, linear, 0.0) + select(square < 0.0, square, 0.0) - tail
    inside = rows[0, 0] + least > rounding
    leaves = (linear >= 0.0) & (square >= 0.0) & (linear + square > tail)
    at_rest = rows[0, 0] == 0.0
    return size, (at_rest & leaves) | ~at_rest & inside, tail
