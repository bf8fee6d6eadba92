"""Kernels of friction laws: force, slope, parameter derivatives and Taylor series."""

# All kernels take a parameter row ``p`` and the direction of slip ``m``: -1 backward, +1 forward.

from __future__ import annotations

import bisect
import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import shown
from stickslip.mechanics.friction import _text
from stickslip.mechanics.friction.formula import CallableFormula, Formula, TracedFormula, quietly
from stickslip.mechanics.friction.interface import NEXT_PIECE_COLUMN
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.numerics.expression import evaluate
from stickslip.numerics.series import Scalars
from stickslip.vocabulary import did_you_mean

Kernel = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class LawCode:
    """Compiled functions of one or more friction laws; p, m as the module says."""

    key: str  # short hash of the generated text; names cache folders
    traceable: bool  # there are Taylor series: the last three kernels
    formulas: tuple[Formula, ...]  # distinct; LAW_COLUMN of a row numbers them
    force: Kernel  # (p, m, s) -> F(s), s >= 0; exactly 0 or 1 at s = 0 but for rounding
    force_continued: Kernel  # the same, and its tangent at 0 for s < 0
    slope: Kernel  # (p, m, s) -> dF/ds
    gradient: Kernel  # (p, m, s, out): dF/d(parameter j) into out[j]
    static_value: Kernel  # (p, m) -> F(0)
    force_sharp: Kernel | None  # (p, m, s, s_low) -> F(s + s_low), what rounding leaves out
    # (p, m, rows, k): with s_0..k in rows[0], and called for 0..k-1: F_k into rows[FORCE_ROW].
    series: Kernel | None
    # (p, m, rows, order, gradient): dF/ds into rows[SLOPE_ROW]; if asked, dF/d(parameter j) after.
    series_tangent: Kernel | None
    N_ROWS: int
    N_PARAMETERS: int
    scalars: tuple[Scalars | None, ...]
    FORCE_ROW: int = _text.FORCE_ROW
    SLOPE_ROW: int = _text.SLOPE_ROW
    GRADIENT_ROW: int = _text.GRADIENT_ROW

    def parameter_rows(self, laws: Iterable[FrictionLaw]) -> NDArray[np.float64]:
        """Rows ``p``, one per block; further pieces of laws follow after all blocks."""
        pieces = [self._pieces(law) for law in laws]
        rows = [first for first, *_ in pieces]
        for block, (_, *later) in enumerate(pieces):
            before = rows[block]
            for row in later:
                before[NEXT_PIECE_COLUMN] = float(len(rows))
                rows.append(row)
                before = row
        table = np.zeros((len(rows), max(map(len, rows))))
        for i, row in enumerate(rows):
            table[i, : len(row)] = row
        return table

    def parameter_row(self, law: FrictionLaw, s: float) -> NDArray[np.float64]:
        """Row ``p`` of the piece of a law that a slip speed lies on."""
        piece = bisect.bisect_left([end for end, _ in law.pieces], s)
        return np.array(self._pieces(law)[piece])

    def _pieces(self, law: FrictionLaw) -> list[list[float]]:
        """Law number, F(0) twice, end, no next piece, parameters, constants or addresses."""
        index = self.formulas.index(law.formula)
        static = (law.static_value(), law.static_value(forward=True))
        scalars = self.scalars[index]
        rows: list[list[float]] = []
        for end, arguments in law.pieces:
            values = {name: np.float64(value) for name, value in arguments.items()}
            row = [float(index), *static, end, -1.0]
            row += [values[name] for name in law.formula.parameters]
            if isinstance(law.formula, CallableFormula):
                row += law.formula.addresses()
            elif scalars is not None:
                row += quietly(evaluate, scalars.graph, scalars.constants, values)
            rows.append(row)
        return rows

    def parameter_index(self, law: FrictionLaw, name: str) -> int:
        """Return the j of a parameter in `gradient` and among the rows of `series_tangent`."""
        names = law.formula.parameters
        if name not in names:
            known = did_you_mean(name, names)
            raise ValueError(f"friction law {law.title} has no parameter {shown(name)}. {known}")
        return names.index(name)


_codes: dict[frozenset[Formula], LawCode] = {}


def law_code(laws: Sequence[FrictionLaw]) -> LawCode:
    """Kernels for the laws of a model's blocks; the same object for the same formulas."""
    formulas = frozenset(law.formula for law in laws)
    if formulas not in _codes:
        # In an order of their own: blocks that change places need no other kernels.
        _codes[formulas] = _generated(tuple(sorted(formulas, key=repr)))
    return _codes[formulas]


def _generated(formulas: tuple[Formula, ...]) -> LawCode:
    from stickslip.numerics.targets import write_module

    source = _text.kernel_source(formulas)
    names = vars(write_module("friction", source.text))
    return LawCode(
        key=hashlib.sha256(source.text.encode()).hexdigest()[:16],
        traceable=all(isinstance(formula, TracedFormula) for formula in formulas),
        formulas=formulas,
        force=names["force"],
        force_continued=names["force_continued"],
        slope=names["slope"],
        gradient=names["gradient"],
        static_value=names["static_value"],
        force_sharp=names.get("force_sharp"),
        series=names.get("series"),
        series_tangent=names.get("series_tangent"),
        N_ROWS=source.n_rows,
        N_PARAMETERS=source.n_parameters,
        scalars=source.scalars,
    )


def pointwise(law: FrictionLaw, name: str) -> tuple[NDArray[np.float64], Kernel]:
    """Return the parameter row of one law and one of its kernels."""
    code = law_code([law])
    return code.parameter_rows([law])[0], getattr(code, name)
