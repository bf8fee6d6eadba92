"""The text of a module of friction kernels, generated from the laws' formulas."""

# Rows of a series: 0 the speed s, 1 the force, 2 dF/ds, dF/d(parameter), what recurrences need.

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from stickslip.mechanics.friction.formula import (
    CallableFormula,
    Formula,
    TracedFormula,
)
from stickslip.mechanics.friction.interface import (
    FORWARD_STATIC_COLUMN,
    LAW_COLUMN,
    PARAMETER_COLUMN,
    STATIC_COLUMN,
)
from stickslip.numerics.expression import derivative
from stickslip.numerics.series import (
    EXACT,
    Lines,
    Scalars,
    SeriesText,
    indented,
    sharp_lines,
    value_lines,
)

SPEED_ROW, FORCE_ROW, SLOPE_ROW, GRADIENT_ROW = range(4)

# Differences of a law that is known by its values only: central ones of order 6, one-sided
# ones where those would ask for s < 0. The step suits laws that change over speeds of 0.01
# and more: error about (step / 0.01)^6 from truncation, 1e-12 from rounding.
DIFFERENCE_STEP = 1e-4
CENTRAL = {-3: -1, -2: 9, -1: -45, 1: 45, 2: -9, 3: 1}
ONE_SIDED = {0: -147, 1: 360, 2: -450, 3: 400, 4: -225, 5: 72, 6: -10}

HEADER = '''\
"""Friction kernels generated from formulas; see stickslip.mechanics.friction.code."""

import math
'''
TRACED_IMPORTS = """\
from stickslip.numerics.rounding import product, quotient, sum_of_two
from stickslip.numerics.targets import kernel
"""
IMPORTS = """\
from stickslip.numerics.by_address import call_at
from stickslip.numerics.targets import kernel
"""


@dataclass(frozen=True)
class KernelSource:
    """The text, with what must be known to call its kernels."""

    text: str
    n_rows: int
    n_parameters: int
    scalars: tuple[Scalars | None, ...]


@dataclass
class TracedText:
    """Lines of each kernel for one traced formula, in one direction of slip."""

    scalars: Scalars
    force: int
    slope: int
    gradient: list[int]

    def values(self, targets: dict[str, int]) -> Lines:
        return value_lines(self.scalars, targets)

    def force_lines(self) -> Lines:
        return self.values({"value": self.force})

    def sharp_lines(self) -> Lines:
        graph, columns = self.scalars.graph, self.scalars.parameter_columns
        symbols = {name: (f"p[{column}]", EXACT) for name, column in columns.items()}
        symbols["s"] = ("s", "s_low")
        return sharp_lines(graph, self.force, symbols, ("value", "low"))

    def slope_lines(self) -> Lines:
        return self.values({"value": self.slope})

    def gradient_lines(self) -> Lines:
        return self.values({f"out[{j}]": number for j, number in enumerate(self.gradient)})

    @cached_property
    def series(self) -> SeriesText:
        variable = self.scalars.graph.symbol("s").number
        first = GRADIENT_ROW + len(self.gradient)
        return SeriesText(self.scalars, {FORCE_ROW: self.force}, {variable: SPEED_ROW}, first)

    @cached_property
    def slope_series(self) -> SeriesText:
        outputs = {SLOPE_ROW: self.slope}
        return SeriesText(self.scalars, outputs, self.series.rows, self.series.next_row)

    @cached_property
    def gradient_series(self) -> SeriesText:
        outputs = {GRADIENT_ROW + j: number for j, number in enumerate(self.gradient)}
        known = self.slope_series
        return SeriesText(self.scalars, outputs, known.rows, known.next_row)


@dataclass
class CallableText:
    """Lines of each kernel around a function of numbers, in one direction of slip."""

    formula: CallableFormula
    forward: bool
    n_gradient: int

    def call(self, role: str, speed: str, shifted: int = -1) -> str:
        """Text of a call, with one parameter shifted to the local name ``x``."""
        n = len(self.formula.parameters)
        address = _column(n + self.formula.ROLES.index(role))
        arguments = ["x" if j == shifted else _column(j) for j in range(n)]
        return f"call_at({', '.join([address, speed, *arguments])})"

    @property
    def role(self) -> str:
        return "forward" if self.forward else "backward"

    def force_lines(self) -> Lines:
        return [f"value = {self.call(self.role, 's')}"]

    def slope_lines(self) -> Lines:
        if self.formula.slope is not None and not self.forward:
            return [f"value = {self.call('slope', 's')}"]
        return [
            f"h = {DIFFERENCE_STEP!r} * (1.0 + s)",
            "if s > 3.0 * h:",
            *indented(self._difference(CENTRAL, "s", "value")),
            "else:",
            *indented(self._difference(ONE_SIDED, "s", "value")),
        ]

    def gradient_lines(self) -> Lines:
        lines: Lines = []
        for j in range(len(self.formula.parameters)):
            column = _column(j)
            lines.append(f"h = {DIFFERENCE_STEP!r} * max(abs({column}), 0.01)")
            lines += self._difference(CENTRAL, column, f"out[{j}]", shifted=j)
        unused = range(len(self.formula.parameters), self.n_gradient)
        return lines + [f"out[{j}] = 0.0" for j in unused]

    def _difference(
        self, weights: Mapping[int, int], at: str, target: str, shifted: int = -1
    ) -> Lines:
        lines = ["total = 0.0"]
        speed = "s" if shifted >= 0 else "x"
        for offset, weight in weights.items():
            lines.append(f"x = {at} + {offset} * h")
            lines.append(f"total += {weight} * {self.call(self.role, speed, shifted)}")
        return [*lines, f"{target} = total / (60.0 * h)"]


DirectionText = TracedText | CallableText


@dataclass
class LawText:
    """One formula: its text in each direction; the directions are one in a symmetric law."""

    directions: list[DirectionText]
    scalars: Scalars | None = None

    def lines(self, part: Callable[[Any], Lines]) -> Lines:
        backward, *forward = (part(direction) for direction in self.directions)
        if not forward:
            return backward
        either = indented(forward[0] or ["pass"]), indented(backward or ["pass"])
        return ["if m > 0:", *either[0], "else:", *either[1]]


def _column(place: int) -> str:
    return f"p[{PARAMETER_COLUMN + place}]"


def kernel_source(formulas: Sequence[Formula]) -> KernelSource:
    """Generate the kernels of some distinct formulas."""
    n_parameters = max(len(formula.parameters) for formula in formulas)
    laws = [_law_text(formula, n_parameters) for formula in formulas]
    traced = all(isinstance(formula, TracedFormula) for formula in formulas)
    parts = [HEADER, TRACED_IMPORTS if traced else IMPORTS, *_pointwise_kernels(laws)]
    n_rows = GRADIENT_ROW + n_parameters
    if traced:
        parts += _series_kernels(laws)
        n_rows = max(text.gradient_series.next_row for law in laws for text in law.directions)  # type: ignore[union-attr]
    return KernelSource("\n".join(parts), n_rows, n_parameters, tuple(law.scalars for law in laws))


def _law_text(formula: Formula, n_gradient: int) -> LawText:
    directions = [False] if formula.symmetric else [False, True]
    if isinstance(formula, CallableFormula):
        return LawText([CallableText(formula, d, n_gradient) for d in directions])
    columns = {name: PARAMETER_COLUMN + j for j, name in enumerate(formula.parameters)}
    scalars = Scalars(formula.graph(), columns, PARAMETER_COLUMN + len(columns))
    return LawText([_traced_text(scalars, formula, d, n_gradient) for d in directions], scalars)


def _traced_text(
    scalars: Scalars, formula: TracedFormula, forward: bool, n_gradient: int
) -> TracedText:
    graph = scalars.graph
    force = graph[formula.output(forward)]
    gradient = [derivative(force, graph.symbol(name)).number for name in formula.parameters]
    gradient += [graph.constant(0.0).number] * (n_gradient - len(gradient))
    slope = derivative(force, graph.symbol("s")).number
    return TracedText(scalars, force.number, slope, gradient)


# --- kernels ------------------------------------------------------------------------------------


def _kernel(signature: str, about: str, *bodies: Lines, inline: bool = False) -> str:
    decorator = "@kernel(inline=True)" if inline else "@kernel"
    lines = [decorator, f"def {signature}:", f'    """{about}"""']
    for body in bodies:
        lines += indented(body)
    return "\n".join(["", *lines, ""])


def _chosen(laws: Sequence[LawText], part: Callable[[Any], Lines]) -> Lines:
    """Choose the lines of the law that the row names."""
    if len(laws) == 1:
        return laws[0].lines(part)
    lines: Lines = []
    for i, law in enumerate(laws):
        last = i == len(laws) - 1
        lines.append("else:" if last else f"{'el' if i else ''}if p[{LAW_COLUMN}] == {float(i)}:")
        lines += indented(law.lines(part) or ["pass"])
    return lines


def _pointwise_kernels(laws: Sequence[LawText]) -> list[str]:
    symmetric = all(len(law.directions) == 1 for law in laws)
    forward = "" if symmetric else f" if m < 0 else p[{FORWARD_STATIC_COLUMN}]"
    static = [f"return p[{STATIC_COLUMN}]{forward}"]
    return [
        _kernel("static_value(p, m)", "F(0).", static),
        _kernel(
            "force(p, m, s)",
            "F(s), s >= 0.",
            _chosen(laws, lambda text: text.force_lines()),
            ["return static_value(p, m) if s == 0.0 else value"],
        ),
        _kernel(
            "slope(p, m, s)",
            "dF/ds, s >= 0.",
            _chosen(laws, lambda text: text.slope_lines()),
            ["return value"],
        ),
        _kernel(
            "force_continued(p, m, s)",
            "F(s), and its tangent at 0 for s < 0.",
            ["if s >= 0.0:", "    return force(p, m, s)"],
            ["return static_value(p, m) + slope(p, m, 0.0) * s"],
        ),
        _kernel(
            "gradient(p, m, s, out)",
            "dF/d(parameter j) into out[j].",
            _chosen(laws, lambda text: text.gradient_lines()),
        ),
    ]


def _series_kernels(laws: Sequence[LawText]) -> list[str]:
    exact = [
        f"if rows[{SPEED_ROW}, 0] == 0.0:",
        f"    rows[{FORCE_ROW}, 0] = static_value(p, m)",
    ]
    start = _chosen(laws, lambda text: text.series.start)
    advance = _chosen(laws, lambda text: text.series.advance)
    slope_start = _chosen(laws, lambda text: text.slope_series.start)
    slope = _chosen(laws, lambda text: text.slope_series.advance)
    gradient_start = _chosen(laws, lambda text: text.gradient_series.start)
    gradient = _chosen(laws, lambda text: text.gradient_series.advance)
    return [
        _kernel(
            "force_sharp(p, m, s, s_low)",
            "F(s + s_low), s >= 0, and what rounding leaves out of it.",
            ["if s == 0.0:", "    return static_value(p, m), 0.0"],
            _chosen(laws, lambda text: text.sharp_lines()),
            ["return value, low if math.isfinite(low) else 0.0"],
        ),
        _kernel(
            "series(p, m, rows, k)",
            "Coefficient k of F along the speed in row 0.",
            ["if k == 0:", *indented([*start, *exact]), "else:", *indented(advance)],
            inline=True,
        ),
        _kernel(
            "series_tangent(p, m, rows, order, gradient)",
            "Series of dF/ds and, if `gradient`, dF/d(parameter j), after those of F.",
            [*slope_start, "if gradient:", *indented(gradient_start or ["pass"])],
            ["for k in range(1, order + 1):"],
            indented([*slope, "if gradient:", *indented(gradient or ["pass"])]),
        ),
    ]
