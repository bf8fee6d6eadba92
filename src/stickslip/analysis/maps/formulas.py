"""Maps of the line by formulas as text, one for each branch, with exact derivatives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.checks import finite_number, instance, shown
from stickslip.numerics.formula_text import FUNCTIONS, FormulaText
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats

VARIABLE: Final = "x"
MOST_BRANCHES: Final = 100


@dataclass(frozen=True)
class Edges:
    """Breakpoints as formulas of the parameters; called, their values."""

    formulas: tuple[FormulaText, ...]

    def __call__(self, **parameters: float) -> Floats:
        """Compute them all, also those that lie outside of the domain."""
        values = {name: np.float64(value) for name, value in parameters.items()}
        with np.errstate(all="ignore"):
            return np.array([formula(np.nan, **values) for formula in self.formulas], dtype=float)


@dataclass(frozen=True)
class Formulas:
    """The branches of a map in order, and the breakpoints between them; called, the map."""

    branches: tuple[FormulaText, ...]
    edges: Edges

    def __call__(self, x: Any, **parameters: float) -> Floats:
        """Compute values; at a breakpoint that of the branch on the right."""
        return self.pieces(x, parameters, self.branches)

    def pieces(
        self, x: Any, parameters: Mapping[str, float], branches: Sequence[Callable[..., Any]]
    ) -> Floats:
        """Compute each branch at the points where it is the map."""
        points = np.asarray(x)
        branch = np.searchsorted(self.edges(**parameters), points.real, side="right")
        numbers = {name: np.float64(value) for name, value in parameters.items()}
        values = np.empty(points.shape, dtype=np.result_type(points, np.float64))
        with np.errstate(all="ignore"):
            for k, function in enumerate(branches):
                here = branch == k
                if here.any():
                    values[here] = function(points[here], **numbers)
        return values

    @property
    def __name__(self) -> str:
        *left, last = (f"'{branch.text}'" for branch in self.branches)
        ends = (edge.text for edge in self.edges.formulas)
        return "".join(f"{a} for x < {b}, " for a, b in zip(left, ends, strict=True)) + last


@dataclass(frozen=True)
class Slope:
    """The derivative of formulas by x or a parameter, as a function like the map."""

    formulas: Formulas
    by: str

    def __call__(self, x: Any, **parameters: float) -> Floats:
        """Compute it; at a breakpoint that of the branch on the right."""
        slopes = [partial(branch.slope, self.by) for branch in self.formulas.branches]
        return self.formulas.pieces(x, parameters, slopes)


def formulas_of(
    texts: str | Sequence[str], breakpoints: Any, parameters: Mapping[str, float]
) -> Formulas:
    """Read the formulas of the branches and of the breakpoints; ValueError names a wrong one."""
    for name in parameters:
        if name == VARIABLE or name in FUNCTIONS:
            raise ValueError(f"parameters[{shown(name)}]: in formulas {name} has another meaning.")
    given = [texts] if isinstance(texts, str) else list(texts)
    ends = [] if breakpoints is None else breakpoints
    if isinstance(ends, str) or not isinstance(ends, Iterable):
        raise ValueError(
            f"breakpoints = {shown(ends)}: a list is needed, of numbers or formulas of the "
            "parameters."
        )
    ends = list(ends)
    if not 1 <= len(given) == len(ends) + 1 <= MOST_BRANCHES:
        raise ValueError(
            f"func has {len(given)} formulas and breakpoints has {len(ends)} numbers: there is one "
            f"formula for each branch, so one more than breakpoints; at most {MOST_BRANCHES}."
        )
    branches = tuple(_formula(f"func[{k}]", text, parameters) for k, text in enumerate(given))
    edges = []
    for k, end in enumerate(ends):
        role = f"breakpoints[{k}]"
        written = end if isinstance(end, str) else repr(finite_number(role, end))
        edges.append(_formula(role, written, parameters))
        if edges[-1].varies:
            raise ValueError(f"{role} = {shown(end)}: a breakpoint cannot depend on {VARIABLE}.")
    return Formulas(branches, Edges(tuple(edges)))


def _formula(role: str, text: object, parameters: Mapping[str, float]) -> FormulaText:
    written = " ".join(instance(role, text, str, 'a formula as text, "a - x**2"').split())
    try:
        formula = FormulaText(written, VARIABLE)
    except ValueError as reason:
        raise ValueError(f"{role}: {reason}") from None
    for name in formula.names:
        if name not in parameters:
            raise ValueError(
                f"{role} = {shown(text)} names {shown(name)}, which is neither {VARIABLE} nor one "
                f"of the parameters. {did_you_mean(name, parameters)}"
            )
    return formula
