"""Columns of equal length by name: what a result is as a table, and how tables are written."""

from __future__ import annotations

import html
import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import islice
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.files import as_list, flat
from stickslip.results.parts import equal

Column: TypeAlias = NDArray[Any]

SHOWN: Final = 40  # rows of a table as text or in a notebook


class Table(Mapping[str, Column]):
    """Columns by name, in order, each an array of one dimension; all are equally long.

    Cells that are several numbers, or None, stand in an array of objects.

    Parameters
    ----------
    columns : mapping of str to array_like

    Raises
    ------
    ValueError
        The columns are not equally long.
    """

    def __init__(self, columns: Mapping[str, Any]) -> None:
        self._columns = {name: _column(values) for name, values in columns.items()}
        lengths = {name: len(column) for name, column in self._columns.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"columns of a table are equally long; these are {lengths}")

    def __getitem__(self, name: str) -> Column:
        """Return a column."""
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self._columns)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self._columns)

    @property
    def n_rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()), ()))

    def rows(self) -> Iterator[dict[str, Any]]:
        """Iterate over the rows: Python's own numbers and texts by name."""
        cells = (as_list(column) for column in self._columns.values())
        for row in zip(*cells, strict=True):
            yield dict(zip(self._columns, row, strict=True))

    def __eq__(self, other: object) -> bool:
        """Whether names, their order and cells are the same; NaN equals NaN."""
        if not isinstance(other, Table):
            return NotImplemented
        same_names = list(self) == list(other)
        return same_names and all(_same(self[name], other[name]) for name in self)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Return the first rows."""
        rows = zip(*([name, *self._texts(name)] for name in self), strict=True)
        sides = (">" if self[name].dtype.kind in "fiu" else "<" for name in self)
        lines = aligned(rows, "".join(sides))
        return "\n".join([*lines, *self._more])

    def _repr_html_(self) -> str:
        return self.as_html()

    def as_html(self, caption: str = "") -> str:
        """Return the first rows as a table of HTML."""
        columns = [list(map(html.escape, self._texts(name))) for name in self]
        head = "".join(f"<th>{html.escape(name)}</th>" for name in self)
        rows = (
            "<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>"
            for row in zip(*columns, strict=True)
        )
        told = f"<caption>{html.escape(caption)}</caption>" if caption else ""
        more = "".join(f"<p>{line}</p>" for line in self._more)
        body = "".join(rows)
        return f"<table>{told}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"

    def _texts(self, name: str) -> list[str]:
        return [str(flat(cell, _short)) for cell in as_list(self[name][:SHOWN])]

    @property
    def _more(self) -> list[str]:
        hidden = self.n_rows - SHOWN
        return [f"... {hidden} more rows"] if hidden > 0 else []


def aligned(rows: Iterable[Iterable[str]], sides: str) -> list[str]:
    """Lines of texts in columns as wide as their longest, each against its side, ``<`` or ``>``."""
    cells = [list(row) for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(f"{c:{s}{w}s}" for c, s, w in zip(row, sides, widths, strict=True)).rstrip()
        for row in cells
    ]


def more(n: int, shown: int = SHOWN) -> list[str]:
    """Say, in a line of its own, how many there are beyond those shown; nothing if none."""
    return [f"  ... {n - shown} more"] if n > shown else []


def listed(texts: Iterable[str], shown: int) -> str:
    """Join the first of some texts; dots stand for the others."""
    first = [*islice(texts, shown + 1)]
    return ", ".join(first if len(first) <= shown else [*first[:shown], "..."])


def per_point(values: Any, shape: tuple[int, ...]) -> NDArray[Any]:
    """Arrange what is known at points of a shape in rows, one for each point."""
    values = np.asarray(values)
    return values.reshape(math.prod(shape), math.prod(values.shape[len(shape) :]))


def free_name(parameter: str, taken: Collection[str]) -> str:
    """Name of a parameter among other names: ``parameter_d`` where one of these is ``d``."""
    return f"parameter_{parameter}" if parameter in taken else parameter


def numbered(name: str, values: NDArray[Any]) -> dict[str, Column]:
    """Columns ``name_1``, ``name_2``, ... of an array of shape (n, k); ``name`` if k = 1."""
    if values.shape[1] == 1:
        return {name: values[:, 0]}
    return {f"{name}_{k}": column for k, column in enumerate(values.T, start=1)}


def _column(values: Any) -> Column:
    if isinstance(values, np.ndarray) and values.ndim == 1:
        return values
    cells = list(values)
    kinds = {bool if isinstance(cell, np.bool_) else type(cell) for cell in cells}
    for kinds_of_one, dtype in ((bool, np.bool_), (str, np.str_)):
        if kinds == {kinds_of_one}:
            return np.array(cells, dtype=dtype)
    if all(isinstance(cell, int | float | np.number) for cell in cells) and bool not in kinds:
        return np.array(cells, dtype=None if cells else np.float64)
    column = np.empty(len(cells), dtype=object)
    column[:] = [tuple(as_list(cell)) if _is_several(cell) else cell for cell in cells]
    return column


def _is_several(cell: Any) -> bool:
    return isinstance(cell, list | tuple | np.ndarray)


def _same(a: Column, b: Column) -> bool:
    return equal(a, b) if a.dtype.kind != "O" else equal(a.tolist(), b.tolist())


def _short(number: float) -> str:
    return f"{number:.10g}"
