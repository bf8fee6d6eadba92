"""Friction given by measured points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import dimensions, model_number, shown
from stickslip.mechanics.friction.formula import TracedFormula, builtin_formula
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.numerics.arrays import Floats
from stickslip.vocabulary import suggests

NUMBERS = ("knot", "constant", "linear", "square", "cube")
# Of the largest speed: points closer together are no two measurements.
SHORTEST_PIECE = 1e-6


@suggests
@dataclass(frozen=True, init=False, repr=False)
class TabulatedFriction(FrictionLaw):
    """Measured points, joined by cubics that rise and fall only as the points do.

    Parameters
    ----------
    speed : array_like of float, shape (n,)
        Slip speeds, dimensionless, ascending from 0; two or more.
    force : array_like of float, shape (n,)
        Friction force over the static limit at those speeds, >= 0; the first, F(0), <= 1.

    Raises
    ------
    ValueError
        Other shapes, speeds that do not ascend from 0, a force that is negative or not finite,
        F(0) > 1.

    Notes
    -----
    Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304, as in
    `scipy.interpolate.PchipInterpolator`: a cubic between neighbouring points, no higher and no
    lower than its ends, with continuous slope. Beyond the last point the force stays what it is
    there. The second derivative jumps at the `knots`, the points after the first; at the last
    one the slope does.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.TabulatedFriction(speed=[0, 0.1, 0.5, 2], force=[1, 0.6, 0.3, 0.35])
    >>> law.force([0.0, 0.1, 5.0]).tolist()
    [1.0, 0.6, 0.35]
    """

    name: ClassVar[str] = "tabulated"

    speeds: tuple[float, ...]
    forces: tuple[float, ...]

    def __init__(self, speed: ArrayLike, force: ArrayLike) -> None:
        speeds, forces = self._numbers("speed", speed), self._numbers("force", force)
        if len(speeds) != len(forces) or len(speeds) < 2:
            raise ValueError(
                f"the friction law tabulated has {len(speeds)} speeds and {len(forces)} forces: "
                "give as many of one as of the other, two or more."
            )
        if speeds[0] != 0.0:
            raise ValueError(
                f"speed[0] = {speeds[0]!r} of the friction law tabulated must be 0: the first "
                "force is F(0), at the start of a slip."
            )
        for i, step in enumerate(np.diff(speeds), start=1):
            if not step > SHORTEST_PIECE * max(speeds):
                raise ValueError(
                    f"speed[{i}] = {speeds[i]!r} of the friction law tabulated must be larger than "
                    f"speed[{i - 1}] = {speeds[i - 1]!r}, by more than {SHORTEST_PIECE:g} of the "
                    "largest speed."
                )
        object.__setattr__(self, "speeds", speeds)
        object.__setattr__(self, "forces", forces)
        self._check_static_value()

    def _numbers(self, name: str, given: ArrayLike) -> tuple[float, ...]:
        if dimensions(given) != 1:
            raise ValueError(
                f"{name} = {shown(given)} of the friction law tabulated must be a list of numbers."
            )
        owner = f"the friction law {self.name}"
        values: list[Any] = list(given)  # type: ignore[arg-type]
        return tuple(
            model_number(f"{name}[{i}]", value, at_least=0.0, of=owner)
            for i, value in enumerate(values)
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The two lists: a table has no parameters."""
        return ("speed", "force")

    def _replaced(self, changes: dict[str, Any]) -> Self:
        return type(self)(**{"speed": self.speeds, "force": self.forces, **changes})

    def __repr__(self) -> str:
        """Call that makes it."""
        return f"TabulatedFriction(speed={list(self.speeds)!r}, force={list(self.forces)!r})"

    def __str__(self) -> str:
        """Return the same: no option of the command line takes a table."""
        return repr(self)

    # --- the equation ---------------------------------------------------------------------

    @staticmethod
    def expression(s: Any, knot: Any, constant: Any, linear: Any, square: Any, cube: Any) -> Any:
        """Cubic of the distance from the knot where its piece begins."""
        x = s - knot
        return constant + x * (linear + x * (square + x * cube))

    @property
    def formula(self) -> TracedFormula:
        """The cubic; all tables share it, and their kernels."""
        return builtin_formula(self.expression, NUMBERS, ())

    @cached_property
    def _cubics(self) -> Floats:
        """Rows of ``NUMBERS``, a piece each; the last is constant."""
        from scipy.interpolate import PchipInterpolator

        curve = PchipInterpolator(self.speeds, self.forces)
        rows = np.zeros((len(self.speeds), len(NUMBERS)))
        rows[:, 0] = self.speeds
        rows[:, 1] = self.forces
        rows[:-1, 2:] = curve.c[-2::-1].T
        return rows

    @property
    def pieces(self) -> tuple[tuple[float, Mapping[str, float]], ...]:
        """End of each piece, and the numbers of its cubic."""
        ends = (*self.speeds[1:], math.inf)
        rows = self._cubics.tolist()
        return tuple(
            (end, dict(zip(NUMBERS, row, strict=True))) for end, row in zip(ends, rows, strict=True)
        )

    def _on_pieces(self, s: Any) -> dict[str, Any]:
        piece = np.maximum(np.searchsorted(self.speeds, s) - 1, 0)
        return dict(zip(NUMBERS, np.moveaxis(self._cubics[piece], -1, 0), strict=True))

    def _force(self, s: Any, forward: bool) -> Any:
        return self.formula.force(s, self._on_pieces(s), forward)

    def _slope(self, s: Any, forward: bool) -> Any:
        return self.formula.slope(s, self._on_pieces(s), forward)
