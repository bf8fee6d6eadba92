"""What a user may pass by mistake: one value of every sort, by a name for the report."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from types import MappingProxyType
from typing import Any, Final

import numpy as np

import stickslip as ss

HUGE: Final = 10**30
"""Beyond every machine integer."""


def _read_only() -> np.ndarray:
    numbers = np.array([0.1, 0.2])
    numbers.flags.writeable = False
    return numbers


def _nested() -> list[Any]:
    """Deeper than Python follows."""
    inner: list[Any] = [0.1]
    for _ in range(10**5):
        inner = [inner]
    return inner


def _answers_nothing(*_: Any, **__: Any) -> None:
    return None


_MAKERS: dict[str, Callable[[], Any]] = {
    # numbers
    "None": lambda: None,
    "True": lambda: True,
    "zero": lambda: 0,
    "one": lambda: 1,
    "minus one": lambda: -1,
    "half": lambda: 0.5,
    "minus half": lambda: -0.5,
    "tiny": lambda: 5e-324,
    "large": lambda: 1e300,
    "huge": lambda: HUGE,
    "minus huge": lambda: -HUGE,
    "beyond the floats": lambda: 10**400,
    "beyond what is written": lambda: 10**5000,
    "a count that no memory holds": lambda: 1e16,
    "float16": lambda: np.float16(3),
    "beyond the floats, as longdouble": lambda: np.longdouble("1e4000"),
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "minus inf": lambda: float("-inf"),
    "complex": lambda: 0.5 + 1j,
    "fraction": lambda: Fraction(1, 3),
    "decimal": lambda: Decimal("0.1"),
    "float32": lambda: np.float32(0.5),
    "int64": lambda: np.int64(3),
    "numpy bool": lambda: np.True_,
    "datetime": lambda: np.datetime64("2001-01-01"),
    # text and containers
    "empty text": lambda: "",
    "text": lambda: "spam",
    "digits": lambda: "0.5",
    "bytes": lambda: b"spam",
    "long text": lambda: "x" * 10**5,
    "text with a zero": lambda: "spam\0",
    "text of a control": lambda: "\x1b[2J\nspam",
    "nested": _nested,
    "nested in a dict": lambda: {"spam": _nested()},
    "long list of texts": lambda: ["spam"] * 10**5,
    "empty list": lambda: [],
    "empty dict": lambda: {},
    "dict": lambda: {"spam": 1.0},
    "dict of numbers": lambda: {3: 4},
    "set": lambda: {0.1, 0.2},
    "list of texts": lambda: ["spam", "eggs"],
    "list of None": lambda: [None, None],
    "one number in a list": lambda: [0.5],
    "pair": lambda: (0.1, 0.2),
    "pair the wrong way": lambda: (0.2, 0.1),
    "pair of NaN": lambda: (float("nan"), float("nan")),
    "pair with inf": lambda: (0.0, float("inf")),
    "pair of huge": lambda: (-HUGE, HUGE),
    "triple": lambda: (0.1, 0.2, 0.3),
    "grid": lambda: (0.1, 0.2, 100),
    "grid that no memory holds": lambda: (0.1, 0.2, 10**16),
    "ragged": lambda: [[0.1], [0.1, 0.2]],
    "generator": lambda: (x for x in (0.1, 0.2)),
    "range": lambda: range(3),
    # arrays
    "0-d array": lambda: np.array(0.5),
    "0-d NaN": lambda: np.array(np.nan),
    "empty array": lambda: np.array([]),
    "empty 2-d array": lambda: np.empty((0, 2)),
    "array": lambda: np.array([0.1, 0.2]),
    "array of NaN": lambda: np.array([np.nan, 0.1]),
    "array of whole numbers": lambda: np.array([0, 1]),
    "array of bools": lambda: np.array([True, False]),
    "complex array": lambda: np.array([0.1, 0.2j]),
    "array of objects": lambda: np.array([0.1, None, "spam"], dtype=object),
    "array of texts": lambda: np.array(["spam", "eggs"]),
    "2-d array": lambda: np.full((2, 3), 0.1),
    "read-only array": _read_only,
    "strided array": lambda: np.linspace(0.0, 0.3, 7)[::-3],
    "matrix": lambda: np.array([[0.1, 0.2]]).view(np.matrix),
    "masked array": lambda: np.ma.masked_array([0.1, 0.2], mask=[True, False]),
    # things of another kind
    "object": object,
    "type": lambda: float,
    "module": lambda: ss.status,
    "builtin": lambda: len,
    "function of anything": lambda: _answers_nothing,
    "friction law": lambda: ss.Coulomb(mu=0.2),
    "two blocks": ss.examples.coulomb,
    "chain": lambda: ss.Chain(static=(1.0, 1.1, 1.2), alpha=1.0, V=0.1, friction=ss.Coulomb(0.2)),
    "class of models": lambda: ss.TwoBlock,
    "map": lambda: ss.PiecewiseMap(_half, (0.0, 1.0)),
}


def _half(x: Any) -> Any:
    return 0.5 * x


MAKERS: Final = MappingProxyType(_MAKERS)
"""Each makes the value anew: a call may use up a generator or change a list."""
