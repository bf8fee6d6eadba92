"""The series of one law as text, for generated kernels that step many motions at once."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.friction._text import FORCE_ROW, SLOPE_ROW, SPEED_ROW
from stickslip.mechanics.friction.formula import TracedFormula, quietly
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.numerics.expression import derivative, evaluate
from stickslip.numerics.series import Scalars, SeriesText

# Columns of a parameter row: F(0), the parameters, constants made of them.
STATIC_COLUMN, PARAMETER_COLUMN = 0, 1


@dataclass(frozen=True)
class LawSeries:
    """Text of the series of a symmetric law's force, and after it of its slope."""

    key: str
    force: SeriesText
    slope: SeriesText
    scalars: Scalars  # of both; constants are the last columns of `rows`

    def rows(self, laws: Sequence[FrictionLaw]) -> NDArray[np.float64]:
        """Return the parameter rows ``p`` of laws with this formula, one for each block."""
        graph, constants = self.scalars.graph, self.scalars.constants
        table = []
        for law in laws:
            values = {name: np.float64(value) for name, value in law.arguments.items()}
            more = quietly(evaluate, graph, constants, values)
            table.append([law.static_value(), *values.values(), *more])
        return np.array(table, dtype=np.float64)


@lru_cache(maxsize=16)
def law_series(laws: tuple[FrictionLaw, ...]) -> LawSeries | None:
    """Series of laws that are one smooth symmetric formula; None for others."""
    # Optional parameters that are zero in all of them are left out where recurrences go with them.
    formula, *others = {law.formula for law in laws}
    if any(law.knots for law in laws):
        return None
    if others or not isinstance(formula, TracedFormula) or not formula.symmetric:
        return None
    absent = [name for name in _optional(laws[0]) if all(law.arguments[name] == 0 for law in laws)]
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
            formula, series = formula_without, without
    return series


def _series_of(formula: TracedFormula) -> LawSeries:
    columns = {name: PARAMETER_COLUMN + j for j, name in enumerate(formula.parameters)}
    graph = formula.graph()
    scalars = Scalars(graph, columns, PARAMETER_COLUMN + len(columns))
    s = graph.symbol("s")
    force = graph[formula.backward]
    slope = derivative(force, s)
    series = SeriesText(scalars, {FORCE_ROW: force.number}, {s.number: SPEED_ROW}, SLOPE_ROW + 1)
    tangent = SeriesText(scalars, {SLOPE_ROW: slope.number}, series.rows, series.next_row)
    text = "\n".join([*series.start, *series.advance, *tangent.start, *tangent.advance])
    return LawSeries(hashlib.sha256(text.encode()).hexdigest()[:16], series, tangent, scalars)
