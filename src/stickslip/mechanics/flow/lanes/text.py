"""The text of one step of all lanes, generated from a law's formula."""

# Recurrences are loops over the order, which `unrolling` writes out. `step_one` and `tangent_one`
# move motions of which one block slips, `step_both` and `tangent_both` those of which both do.

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import partial
from textwrap import dedent, indent
from types import ModuleType
from typing import Any

from stickslip.mechanics.flow.lanes import layout
from stickslip.mechanics.friction.series import STATIC_COLUMN, LawSeries
from stickslip.numerics.series import Lines, indented
from stickslip.numerics.targets import generated_module
from stickslip.numerics.unrolling import unrolled
from stickslip.numerics.vector import LANES

HEADER = '''\
"""One step of many lanes, generated from a law; see stickslip.mechanics.flow.lanes.text."""

import math

from stickslip.numerics.vector import (
    bits, from_bits, load, polynomial, products, select, store, wide_vectors,
)
from stickslip.numerics.targets import kernel
'''

# Signals nearer zero than this are events: SLACK of `dense`, in units of the last place.
EPSILON = 2.0**-52
NUMBERS = {name: value for name, value in vars(layout).items() if isinstance(value, int | float)}
NUMBERS |= {
    "STATIC": STATIC_COLUMN,
    "EPSILON": EPSILON,
    "SLACK": 4.0 * EPSILON,
    "LIMIT_SLACK": 64.0 * EPSILON,
    "FRACTION": 2**52 - 1,
    "ONE": 1023 << 52,  # exponent of 1.0
    "TWO_52": 1075 << 52,  # exponent of 2^52, where integers are the last bits
    "EXPONENT_ZERO": 2.0**52 + 1023.0,
    "ROUNDER": 1.5 * 2.0**52,
    "FINITE": 1e300,
    "SHORTEST": -40.0,  # log2 of the shortest step
}

# --- values -------------------------------------------------------------------------------------

LOAD = """
sign_{i} = load(x, SIGN_{n})
force_{i} = load(x, FORCE_{n})
rows{i}[0, 0] = load(x, SPEED_{n})
"""

# Coefficient k + 1 of a speed: s' = -limit F(s) - sign e; a slip from rest with F(0) = 1 starts
# with zero acceleration. y_(k+1) = s_k / (k+1) are the coefficients of the integral of s. What
# does not depend on the newest coefficient is multiplied out beforehand: the recurrence is a
# chain of operations that wait for each other.
COEFFICIENT = """
if k == 0:
{start}
    rows{i}[1, 0] = select(rows{i}[0, 0] == 0.0, {law}[STATIC], rows{i}[1, 0])
    pull = -c[LIMIT + {i}] * rows{i}[1, 0] - sign_{i} * force_{i}
    at_limit = (rows{i}[0, 0] == 0.0) & (abs(pull) <= SLACK * c[LIMIT + {i}])
    next_{i} = select(at_limit, 0.0, pull)
else:
{advance}
    loading = {loading}
    if k == 1:
        loading = loading + sign_{i} * (0.5 * c[DRIFT + {i}])
    next_{i} = (-c[LIMIT + {i}] * (1.0 / (k + 1))) * rows{i}[1, k] - loading
"""
STORE = """
rows{i}[0, k + 1] = next_{i}
y{i}[k + 1] = rows{i}[0, k] * (1.0 / (k + 1))
"""

# log2 of the larger of the last coefficients; within 0.01, which is nothing after the root.
LOGARITHM = """
size_s = abs(rows{i}[0, k])
size_e = c[STIFF + {i}] * abs(y{i}[k])
size = select(size_s > size_e, size_s, size_e)
size_bits = bits(size)
exponent = from_bits(size_bits >> 52 | TWO_52) - EXPONENT_ZERO
fraction = from_bits(size_bits & FRACTION | ONE) - 1.0
root = (log_rtol - exponent - fraction * (1.3465 - 0.3465 * fraction)) * (1.0 / k)
power = select(root < power, root, power)
"""
# h = 2^power
LENGTH = """
power = select(power > SHORTEST, power, SHORTEST)
shifted = power + ROUNDER
rest = power - (shifted - ROUNDER)
fraction = 1.0 + rest * (0.69315 + rest * (0.2402 + rest * 0.0555))
h = from_bits((bits(shifted) + 1023) << 52) * fraction
h = select(h < LONGEST_STEP, h, LONGEST_STEP)
"""

# Terms of degree 3 and more, and whether a speed provably stays above zero: `first_contact`.
SPEED_SIGNAL = """
tail_{i} = polynomial(h, {sizes}) * h * h * h
linear = rows{i}[0, 1] * h
square = rows{i}[0, 2] * h * h
size_{i} = abs(linear) + abs(square) + tail_{i}
rounding = SLACK + 2.0 * EPSILON * (abs(rows{i}[0, 0]) + size_{i})
least = select(linear < 0.0, linear, 0.0) + select(square < 0.0, square, 0.0) - tail_{i}
inside = rows{i}[0, 0] + least > rounding
leaves = (linear >= 0.0) & (square >= 0.0) & (linear + square > tail_{i})
at_rest = rows{i}[0, 0] == 0.0
clear_{i} = (at_rest & leaves) | ~at_rest & inside
"""
SPEED_END = """
end_{i} = polynomial(h, {speeds})
integral_{i} = polynomial(h, {integrals}) * h
gained_{i} = sign_{i} * (end_{i} - rows{i}[0, 0])
"""

# A rider's force e' = DRIFT + CROSS w + DRAG w': where it only grows, as next to a block that slips
# backward, its end decides; else both limits are bounded, the terms of degree 3 by the speed's.
RIDER_SIGNAL = """
linear = (c[DRIFT + 1] + c[CROSS + 1] * sign_0 * rows0[0, 0]) * h
square = 0.5 * c[CROSS + 1] * sign_0 * rows0[0, 1] * h * h
tail = abs(c[CROSS + 1]) * h * (abs(rows0[0, 2]) * h * h * 0.3333333333333334 + tail_0 * 0.25)
{damping}
size_1 = abs(linear) + abs(square) + tail
near = LIMIT_SLACK * (c[LIMIT + 1] + size_1)
down = select(linear < 0.0, linear, 0.0) + select(square < 0.0, square, 0.0) - tail
up = select(linear > 0.0, linear, 0.0) + select(square > 0.0, square, 0.0) + tail
grows = (c[LONE + 1] * sign_0 >= 0.0) & clear_0
highest = select(grows, force_end_1, force_1 + up)
above = c[LIMIT + 1] - highest > near
below = (c[LIMIT + 1] + force_1 + down > near) | grows
"""
RIDER_DAMPING = """
linear = linear + c[DRAG + 1] * sign_0 * rows0[0, 1] * h
square = square + c[DRAG + 1] * sign_0 * rows0[0, 2] * h * h
tail = tail + abs(c[DRAG + 1]) * tail_0
"""

ONE = """
{load}
force_1 = load(x, FORCE_2)
for k in range(ORDER):
{coefficients}
power = 0.0
for k in range(ORDER - 1, ORDER + 1):
{logarithms}
{length}
{signals}
{ends}
{forces}
{rider}
sound = abs(end_0) + abs(force_end_0) < FINITE
"""
ONE_FLAGS = """
flag = select(clear_0, 0.0, 1.0) + select(above, 0.0, 2.0) + select(below, 0.0, 4.0)
"""

BOTH = """
{load}
unlike = sign_0 * sign_1
for k in range(ORDER):
{coefficients}
power = 0.0
for k in range(ORDER - 1, ORDER + 1):
{logarithms}
{length}
{signals}
{ends}
{forces}
sound = abs(end_0) + abs(end_1) + abs(force_end_0) + abs(force_end_1) < FINITE
"""
# Energy of two blocks that slip backward: too little to reach the belt?
BOTH_FLAGS = """
y_1 = c[BELT] + sign_0 * rows0[0, 0]
y_2 = c[BELT] + sign_1 * rows1[0, 0]
r_1 = force_0 - c[STEADY]
r_2 = force_1 - c[STEADY + 1]
{damping}
energy = c[MASS] * y_1 * y_1 + c[MASS + 1] * y_2 * y_2 + c[SPRING_BOTH] * r_1 * r_2
energy = energy + c[SPRING] * r_1 * r_1 + c[SPRING + 1] * r_2 * r_2
sound = sound & ((sign_0 > 0.0) | (sign_1 > 0.0) | (energy >= c[FLOOR]))
flag = select(clear_0, 0.0, 1.0) + select(clear_1, 0.0, 2.0)
"""
SLIDING_DAMPING = """
r_1 = r_1 - c[DAMP] * y_1 - c[DRAG] * y_2
r_2 = r_2 - c[DAMP + 1] * y_2 - c[DRAG + 1] * y_1
"""
FINISH = """
steps = load(x, STEPS) + 1.0
sound = sound & (power > SHORTEST) & (steps < MOST_STEPS)
time = load(x, TIME)
store(x, STEPS, steps)
store(taken, FLAG, flag + select(sound, 0.0, 8.0))
store(taken, LENGTH, h)
store(taken, TIME_BEFORE, time)
store(taken, SIZE_1, size_0)
store(taken, SIZE_2, size_1)
store(x, TIME, time + h)
store(taken, FORCE_1_BEFORE, force_0)
store(taken, FORCE_2_BEFORE, force_1)
store(x, FORCE_1, force_end_0)
store(x, FORCE_2, force_end_1)
"""
KEEP = """
store(x, SPEED_{n}, end_{i})
for k in range(ORDER + 1):
    store(taken, SERIES_{n} + k * LANES, rows{i}[0, k])
"""
KEEP_ROW = """
for k in range(ORDER):
    store(taken, LAW_ROWS + {place} * LANES + k * LANES, rows{i}[{row}, k])
"""

# --- tangents -----------------------------------------------------------------------------------

KNOWN = """
sign_{i} = load(x, SIGN_{n})
d_force_{i} = load(x, D_FORCE_{n})
d{i}[0] = load(x, D_SPEED_{n})
for k in range(ORDER):
    rows{i}[0, k] = load(taken, SERIES_{n} + k * LANES)
"""
KNOWN_ROW = """
for k in range(ORDER):
    rows{i}[{row}, k] = load(taken, LAW_ROWS + {place} * LANES + k * LANES)
"""
D_COEFFICIENT = """
if k == 0:
{start}
else:
{advance}
changed = 0.0
for j in range(k, -1, -1):
    changed += rows{i}[2, j] * d{i}[k - j]
if k == 0:
    loading = sign_{i} * d_force_{i}
else:
    loading = {loading}
{moved}
next_{i} = (-c[LIMIT + {i}] * (1.0 / (k + 1))) * changed - loading
"""
# With a parameter the equations change, too: the force's part of -L' F is (L' / L) (s' + sign e).
D_MOVED_START = """
rows{i}[0, ORDER] = load(taken, SERIES_{n} + ORDER * LANES)
scaled_{i} = c[CHANGE + LIMIT + {i}] / c[LIMIT + {i}]
"""
D_MOVED_NUMBER = """
left_{name}_{i} = scaled_{i} * c[{name} + {i}] - c[CHANGE + {name} + {i}]
"""
D_MOVED = """
y{i}[k + 1] = rows{i}[0, k] * (1.0 / (k + 1))
changed = changed + rows{i}[{row}, k]
loading = loading - scaled_{i} * rows{i}[0, k + 1]
if k == 0:
    loading = loading - scaled_{i} * (sign_{i} * load(taken, FORCE_{n}_BEFORE))
else:
    loading = loading - ({left})
    if k == 1:
        loading = loading - sign_{i} * (0.5 * left_DRIFT_{i})
"""
D_MOVED_END = """
path_{i} = polynomial(h, {integrals}) * h
faster_{i} = sign_{i} * (load(x, SPEED_{n}) - rows{i}[0, 0])
"""
D_STORE = """
d{i}[k + 1] = next_{i}
z{i}[k + 1] = d{i}[k] * (1.0 / (k + 1))
"""
D_END = """
end_{i} = polynomial(h, {tangents})
integral_{i} = polynomial(h, {tangent_integrals}) * h
gained_{i} = sign_{i} * (end_{i} - d{i}[0])
turning_{i} = polynomial(h, {slopes})
extreme_{i} = (load(taken, SERIES_{n} + LANES) < 0.0) & (turning_{i} > 0.0)
store(x, D_SPEED_{n}, end_{i})
for k in range(ORDER + 1):
    store(taken, D_SERIES_{n} + k * LANES, d{i}[k])
"""
D_ONE = """
{known}
d_force_1 = load(x, D_FORCE_2)
h = load(taken, LENGTH)
for k in range(ORDER):
{coefficients}
{ends}
rate = c[DRIFT + 1] + c[CROSS + 1] * sign_0 * rows0[0, 0]
rate_end = c[DRIFT + 1] + c[CROSS + 1] * sign_0 * load(x, SPEED_1)
{damping}
extreme = extreme_0 | (rate * rate_end < 0.0)
"""
D_ONE_DAMPING = """
rate = rate + c[DRAG + 1] * sign_0 * rows0[0, 1]
rate_end = rate_end + c[DRAG + 1] * sign_0 * turning_0
"""
D_BOTH = """
{known}
unlike = sign_0 * sign_1
h = load(taken, LENGTH)
for k in range(ORDER):
{coefficients}
{ends}
extreme = extreme_0 | extreme_1
"""
D_FINISH = """
{forces}
store(taken, D_FORCE_1_BEFORE, d_force_0)
store(taken, D_FORCE_2_BEFORE, d_force_1)
store(x, D_FORCE_1, force_end_0)
store(x, D_FORCE_2, force_end_1)
store(taken, FLAG, load(taken, FLAG) + select(extreme, 16.0, 0.0))
"""


ARGUMENTS = "x, taken, p, q, c, log_rtol"


def lanes_text(series: LawSeries, *, damped: bool) -> str:
    """Write the module of the four kernels for one law."""
    writer = _Writer(series, damped)
    steps = [writer.step(n) for n in (1, 2)] + [writer.tangent(n) for n in (1, 2)]
    return "\n".join([HEADER, f"SIZE = {writer.size}\n", *steps])


def changing_text(series: LawSeries) -> str:
    """Write the module of the tangents with a parameter's change, which may be a damper's."""
    writer = _Writer(series, damped=True, changing=True)
    return "\n".join([HEADER, *(writer.tangent(n) for n in (1, 2))])


class _Writer:
    """Fills the templates above with the text of a law's series."""

    def __init__(self, series: LawSeries, damped: bool, changing: bool = False) -> None:
        self.law, self.damped, self.changing = series.force, damped, changing
        self.law_tangent = [series.slope, *[series.change] * changing]
        self.change_row = series.change_row
        text = "\n".join(series.slope.start + series.slope.advance)
        written = set(re.findall(r"^ *rows\[(\d+), [0k]\] =", text, re.MULTILINE))
        read = set(re.findall(r"rows\[(\d+), ", text))
        self.kept_rows = sorted(map(int, read - written - {"0"}))
        starts = series.force.start + series.slope.start + series.change.start
        self.calls = sorted(set(_calls(starts)))
        self.size = layout.LAW_ROWS + LANES * 2 * (
            len(self.kept_rows) * layout.ORDER + len(self.calls)
        )

    def step(self, n: int) -> str:
        """Kernel `step_one` or `step_both`."""
        blocks = range(n)
        advance = _joined(
            _filled(
                COEFFICIENT,
                i,
                start=self._start(self.law.start, i),
                advance=_of_block(self.law.advance, i),
                loading=self._loading("y{i}[k]", "rows{i}[0, k]", i, n),
            )
            for i in blocks
        ) + _joined(_filled(STORE, i) for i in blocks)
        body = (ONE if n == 1 else BOTH).format(
            load=_joined(_filled(LOAD, i) for i in blocks),
            coefficients=indent(advance, "    "),
            logarithms=indent(_joined(_filled(LOGARITHM, i) for i in blocks), "    "),
            length=LENGTH,
            signals=_joined(_filled(SPEED_SIGNAL, i) for i in blocks),
            ends=_joined(_filled(SPEED_END, i) for i in blocks),
            rider=RIDER_SIGNAL.format(damping=self._if_damped(RIDER_DAMPING)),
            forces=self._forces("force_{i} + c[DRIFT + {i}] * h", n),
        )
        body += ONE_FLAGS if n == 1 else BOTH_FLAGS.format(damping=self._if_damped(SLIDING_DAMPING))
        body += FINISH
        body += _joined(_filled(KEEP, i) for i in blocks)
        body += self._rows(KEEP_ROW, n)
        name = f"step_{'one' if n == 1 else 'both'}"
        return self._kernel(name, self.law.start, "x[SPEED_{n} + lane]", body, n)

    def tangent(self, n: int) -> str:
        """Kernel `tangent_one` or `tangent_both`."""
        blocks = range(n)
        start = [line for series in self.law_tangent for line in series.start]
        onward = [line for series in self.law_tangent for line in series.advance]
        advance = _joined(
            _filled(
                D_COEFFICIENT,
                i,
                start=self._start(start, i),
                advance=_of_block(onward, i),
                loading=self._loading("z{i}[k]", "d{i}[k]", i, n),
                moved=self._if_changing(D_MOVED, i, row=self.change_row, left=self._left(i, n)),
            )
            for i in blocks
        ) + _joined(_filled(D_STORE, i) for i in blocks)
        known = [_filled(KNOWN, i) + self._moved_numbers(i) for i in blocks]
        body = (D_ONE if n == 1 else D_BOTH).format(
            known=_joined(known) + self._rows(KNOWN_ROW, n),
            coefficients=indent(advance, "    "),
            ends=_joined(_filled(D_END, i) + self._if_changing(D_MOVED_END, i) for i in blocks),
            damping=self._if_damped(D_ONE_DAMPING),
        ) + D_FINISH.format(forces=self._forces("d_force_{i}", n, self.changing))
        name = f"tangent_{'one' if n == 1 else 'both'}"
        return self._kernel(name, start, "taken[SERIES_{n} + lane]", body, n)

    def _if_changing(self, template: str, i: int, **parts: Any) -> str:
        return _filled(template, i, **parts) if self.changing else ""

    def _moved_numbers(self, i: int) -> str:
        """Numbers of the equations' change: what scaling the limit leaves of it."""
        names = ["STIFF", "CROSS", "DRIFT"] + ["DAMP", "DRAG"] * self.damped
        each = [self._if_changing(D_MOVED_NUMBER, i, name=name) for name in names]
        return self._if_changing(D_MOVED_START, i) + _joined(each)

    def _left(self, i: int, n: int) -> str:
        return self._loading("y{i}[k]", "rows{i}[0, k]", i, n, "left_{name}_{i}")

    def _if_damped(self, text: str) -> str:
        return text if self.damped else ""

    def _loading(
        self, integral: str, speed: str, i: int, n: int, number: str = "c[{name} + {i}]"
    ) -> str:
        """Coefficient k of sign e over k + 1, from the speeds and their integrals."""
        pairs = [("STIFF", "CROSS", integral)]
        pairs += [("DAMP", "DRAG", speed)] if self.damped else []

        def term(name: str, factor: str, of: str) -> str:
            return f"({number.format(name=name, i=i)}{factor} * (1.0 / (k + 1))) * {of}"

        terms = [term(own, "", of.format(i=i)) for own, _, of in pairs]
        if n == 2:
            terms += [term(other, " * unlike", of.format(i=1 - i)) for _, other, of in pairs]
        return " + ".join(terms)

    def _forces(self, start: str, n: int, changing: bool = False) -> str:
        """Write the forces at the end, from what speeds and their integrals have gained."""
        lines = []
        for i in range(2):
            text = f"force_end_{i} = " + start.format(i=i)
            for j in (i, 1 - i):
                if j < n:
                    stiff, damp = ("STIFF", "DAMP") if i == j else ("CROSS", "DRAG")
                    text += f" + sign_{j} * (c[{stiff} + {i}] * integral_{j})"
                    text += self._if_damped(f" + c[{damp} + {i}] * gained_{j}")
                    if changing:
                        text += f" + sign_{j} * (c[CHANGE + {stiff} + {i}] * path_{j})"
                        text += self._if_damped(f" + c[CHANGE + {damp} + {i}] * faster_{j}")
            text += f" + c[CHANGE + DRIFT + {i}] * h" if changing else ""
            lines.append(text)
        return _joined(lines)

    def _rows(self, template: str, n: int) -> str:
        """Rows of the law that the tangents look at, of every block."""
        places = [(i, row) for i in range(n) for row in self.kept_rows]
        return _joined(
            template.format(i=i, row=row, place=place * layout.ORDER)
            for place, (i, row) in enumerate(places)
        )

    def _kernel(self, name: str, start: Lines, speed: str, body: str, n: int) -> str:
        """Write a kernel: constants, calls that stay scalar in loops of their own, the step."""
        steps = [self._call_loop(start, i, speed) for i in range(n) if _calls(start)]
        steps.append(_written_out(body))
        columns = sorted({name for step in steps for line in step for name in _columns(line)})
        lines = [f"{column} = {column[0]}[{column[2:]}]" for column in columns]
        lines += ["wide_vectors()"]
        lines += [line for step in steps for line in step]
        return "\n".join(
            ["", "@kernel(fused=True)", f"def {name}({ARGUMENTS}):", *indented(lines), ""]
        )

    def _call_loop(self, start: Lines, i: int, speed: str) -> Lines:
        load = f"rows{i}[0, 0] = {speed.format(n=i + 1)}"
        stores = [f"taken[{self._place(name, i)} + lane] = {name}" for name in _calls(start)]
        body = _written_out("\n".join([load, dedent(_of_block(start, i)), *stores]))
        return [f"for lane in range({LANES}):", *indented(body)]

    def _place(self, name: str, i: int) -> int:
        """Offset where the result of a call is kept."""
        calls = 2 * len(self.kept_rows) * layout.ORDER + i * len(self.calls)
        return layout.LAW_ROWS + LANES * (calls + self.calls.index(name))

    def _start(self, lines: Lines, i: int) -> str:
        """Coefficient 0, with what a call gave taken from where it is kept."""
        changed = [
            f"{name} = load(taken, {self._place(name, i)})"
            if (name := line.split(" = ")[0]) in self.calls and "math." in line
            else line
            for line in lines
        ]
        return _of_block(changed, i)


def _calls(lines: Lines) -> list[str]:
    """Names that are set by a function of `math`, which lanes do not have."""
    return [line.split(" = ")[0] for line in lines if "= math." in line]


def _columns(line: str) -> list[str]:
    return re.findall(r"\b[pqc]_\d+\b", line)


def _of_block(lines: Lines, i: int) -> str:
    """Text of the law for one block, indented below a condition."""
    text = "\n".join(indented(lines)).replace("rows[", f"rows{i}[")
    return text if i == 0 else re.sub(r"\bp\[", "q[", text)


def _filled(template: str, i: int, **parts: str) -> str:
    return template.format(i=i, n=i + 1, law="pq"[i], **_coefficients(i), **parts)


def _coefficients(i: int) -> dict[str, str]:
    """Arguments of `polynomial`, the highest power first."""
    order = layout.ORDER

    def falling(text: str, first: int, last: int) -> str:
        return ", ".join(text.format(i=i, n=i + 1, k=k) for k in range(first, last - 1, -1))

    return {
        "speeds": falling("rows{i}[0, {k}]", order, 0),
        "sizes": falling("abs(rows{i}[0, {k}])", order, 3),
        "integrals": falling("y{i}[{k}]", order, 1),
        "tangents": falling("d{i}[{k}]", order, 0),
        "tangent_integrals": falling("z{i}[{k}]", order, 1),
        "slopes": falling("{k} * load(taken, SERIES_{n} + {k} * LANES)", order, 1),
    }


def _joined(parts: Iterable[str]) -> str:
    return "\n".join(parts)


def _written_out(body: str) -> Lines:
    local = [f"{name}{i}" for name in ("rows", "y", "d", "z") for i in range(2)]
    return unrolled(body, NUMBERS, local, fixed=("p", "q", "c"))


def lane_kernels(series: LawSeries, *, damped: bool = False) -> ModuleType:
    """Make ``step_one``, ``step_both``, ``tangent_one``, ``tangent_both`` and ``SIZE``."""
    key = f"{series.key}_damped" if damped else series.key
    return generated_module("lanes", key, partial(lanes_text, series, damped=damped))


def changing_kernels(series: LawSeries) -> ModuleType:
    """Make ``tangent_one`` and ``tangent_both`` with a parameter's change."""
    return generated_module("changing", series.key, partial(changing_text, series))
