"""The series of one law as text, for generated kernels that step many motions at once."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.friction._text import FORCE_ROW, SLOPE_ROW, SPEED_ROW
from stickslip.mechanics.friction.formula import TracedFormula, quietly
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.numerics.expression import (
    Expression,
    Graph,
    derivative,
    evaluate,
    gathered,
    reachable,
)
from stickslip.numerics.series import Scalars, SeriesText

# Columns of a parameter row: F(0), the parameters, their changes, constants made of both.
STATIC_COLUMN, PARAMETER_COLUMN = 0, 1


@dataclass(frozen=True, eq=False)
class LawSeries:
    """Text of the series of a symmetric law's force, after it of its slope and of its change."""

    key: str
    force: SeriesText
    slope: SeriesText
    change: SeriesText  # of the force at a given speed, with the parameters' changes
    change_row: int
    scalars: Scalars  # of all; constants are the last columns of `rows`
    tells: bool  # whether the last terms tell how far a series of the force holds
    absent: tuple[str, ...] = ()  # parameters that are zero, and left out

    def rows(
        self, laws: Sequence[FrictionLaw], changing: Sequence[str | None] = ()
    ) -> NDArray[np.float64]:
        """Return the parameter rows ``p`` of laws, one for each block, some parameters changing."""
        changing = changing or [None] * len(laws)
        return np.array([_row(self, *each) for each in zip(laws, changing, strict=True)])


@lru_cache(maxsize=64)  # models beside each other have the same laws
def _row(series: LawSeries, law: FrictionLaw, changing: str | None) -> tuple[float, ...]:
    values = {name: np.float64(value) for name, value in law.arguments.items()}
    values |= {_changed(name): np.float64(name == changing) for name in law.arguments}
    more = quietly(evaluate, series.scalars.graph, series.scalars.constants, values)
    return law.static_value(), *values.values(), *more


@lru_cache(maxsize=16)
def law_series(laws: tuple[FrictionLaw, ...], *, whole: bool = False) -> LawSeries | None:
    """Series of laws that are one smooth symmetric formula; None for others."""
    # Optional parameters that are zero in all of them are left out where recurrences go with them,
    # unless the formula is wanted whole.
    formula, *others = {law.formula for law in laws}
    if any(law.knots for law in laws):
        return None
    if others or not isinstance(formula, TracedFormula) or not formula.symmetric:
        return None
    optional = [] if whole else _optional(laws[0])
    absent = [name for name in optional if all(law.arguments[name] == 0 for law in laws)]
    return _shortest_series(formula, tuple(absent))


def _optional(law: FrictionLaw) -> list[str]:
    """Names of parameters that are zero unless they are given."""
    given = {field.name: field.default for field in fields(law)}
    return [name for name in law.arguments if given.get(name) == 0.0]


@lru_cache(maxsize=64)
def _shortest_series(formula: TracedFormula, absent: tuple[str, ...]) -> LawSeries:
    """Series without those of the absent parameters that cost recurrences."""
    series = _series_of(formula)
    for name in absent:
        formula_without = formula.without([name])
        without = _series_of(formula_without)
        if without.force.n_recurrences < series.force.n_recurrences:
            formula = formula_without
            series = replace(without, absent=(*series.absent, name))
    return series


def _changed(name: str) -> str:
    """Symbol of a parameter's change: no parameter has a name like it."""
    return f"{name}'"


def _series_of(formula: TracedFormula) -> LawSeries:
    names = [*formula.parameters, *map(_changed, formula.parameters)]
    columns = {name: PARAMETER_COLUMN + j for j, name in enumerate(names)}
    graph = formula.graph()
    scalars = Scalars(graph, columns, PARAMETER_COLUMN + len(columns))
    s = graph.symbol("s")
    force = graph[formula.backward]
    slope = gathered(derivative(force, s))
    series = SeriesText(scalars, {FORCE_ROW: force.number}, {s.number: SPEED_ROW}, SLOPE_ROW + 1)
    tangent = SeriesText(scalars, {SLOPE_ROW: slope.number}, series.rows, series.next_row)
    change = graph.constant(0.0)
    for name in formula.parameters:
        by_parameter = derivative(force, graph.symbol(name))
        change = change + by_parameter * graph.symbol(_changed(name))
    seen = "\n".join([*tangent.start, *tangent.advance])
    known = {node: row for node, row in tangent.rows.items() if f"rows[{row}, " in seen}
    row = tangent.next_row
    gained = SeriesText(
        scalars, {row: change.number}, {**known, s.number: SPEED_ROW}, first_row=row + 1
    )
    lines = [*series.start, *series.advance, seen, *gained.start, *gained.advance]
    key = hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]
    return LawSeries(key, series, tangent, gained, row, scalars, _has_simple_poles(graph, force))


def _has_simple_poles(graph: Graph, force: Expression) -> bool:
    """Tell whether a force is a polynomial, and fractions with divisors of first degree."""
    # Such series are geometric after their first terms: nowhere are they flat to rounding alone.
    degrees: dict[int, float] = {}  # infinite of a fraction
    for number in reachable(graph, [force.number]):
        node, own = graph.nodes[number], [degrees[arg] for arg in graph.nodes[number].args]
        if not graph.varies[number]:
            degrees[number] = 0
        elif node.op == "symbol":
            degrees[number] = 1
        elif node.op in ("add", "subtract", "negative"):
            degrees[number] = max(own)
        elif node.op == "multiply" and (min(own) == 0 or max(own) < math.inf):
            degrees[number] = sum(own)
        elif node.op in ("reciprocal", "divide") and own[-1] == 1 and not any(own[:-1]):
            degrees[number] = math.inf
        elif node.op == "divide" and own[-1] == 0:
            degrees[number] = own[0]
        else:
            return False
    return True
