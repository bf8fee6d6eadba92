"""The base of every result: table, text, picture, labelled arrays, files, equality by value."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeVar, overload

import numpy as np

from stickslip.extras import require_extra
from stickslip.files import as_list, checked_path, checked_suffix, flat, whole_file, write_table
from stickslip.results import files
from stickslip.results.parts import equal_results, hash_of_result, register
from stickslip.results.table import Table

if TYPE_CHECKING:
    import os

    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

LARGEST: Final = 2**31 - 1  # whole number of a NetCDF file
SUFFIXES: Final = ("", ".json", ".csv", ".nc")


class Result:
    """What a computation found.

    Subclasses are frozen dataclasses, made with ``eq=False``: results are equal if their fields
    are. They define `_columns`, or list fields and properties in ``_column_names``; and name in
    ``_drawn`` the columns that a picture shows, the abscissa first, or in ``_plot`` a function of
    `stickslip.plot` of their own.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.3})
    >>> ss.periodic_orbits(f, 2).table()
    orbit  period  kind      multiplier  point             d            error  itinerary
        1       1  unstable         3.3      1             0  3.861645303e-16  0
        2       1  unstable        -1.3      1   0.696969697  4.440892099e-16  0
        3       2  stable         -0.29      1  0.4794270198  2.331468352e-15  0
        3       2  stable         -0.29      2  0.8236032832  8.881784197e-16  0
    """

    _column_names: ClassVar[tuple[str, ...]] = ()
    _drawn: ClassVar[tuple[str, ...]] = ()
    _plot: ClassVar[str] = "columns.draw_columns"  # module.function
    _has_picture: ClassVar[bool] = True  # in a notebook, beside the table

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        register(cls)

    def _columns(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in self._column_names}

    def _coordinates(self) -> tuple[str, ...]:
        """Names of the columns that are coordinates of the others."""
        return ()

    # ------------------------------------------------------------------ other forms

    def table(self) -> Table:
        """Return the result as columns by name."""
        return Table(self._columns())

    def to_pandas(self) -> pd.DataFrame:
        """Return the table as a ``pandas.DataFrame`` (needs the extra ``sweep``).

        Raises
        ------
        MissingExtraError
            A ModuleNotFoundError: pandas is not installed.
        """
        require_extra("sweep", "data frames", "pandas")
        frame: pd.DataFrame = importlib.import_module("pandas").DataFrame(dict(self.table()))
        return frame

    def to_xarray(self) -> xr.Dataset:
        """Return the table as an ``xarray.Dataset`` (needs the extra ``sweep``).

        Cells of several numbers have axes of their own, NaN where one has fewer than another.

        Raises
        ------
        MissingExtraError
            A ModuleNotFoundError: xarray is not installed.
        """
        require_extra("sweep", "labelled arrays", "xarray")
        columns = {name: _labelled(name, column) for name, column in self.table().items()}
        coordinates = {name: columns.pop(name) for name in self._coordinates()}
        dataset: xr.Dataset = importlib.import_module("xarray").Dataset(
            columns, coords=coordinates, attrs=self._attributes()
        )
        return dataset

    def _attributes(self) -> dict[str, Any]:
        """Numbers and texts among the fields, and the numbers of those that are dicts."""
        found: dict[str, Any] = {}
        for item in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            if isinstance(value, dict):
                numbers = ((key, one) for key, one in value.items() if np.isscalar(one))
                # A status of motions, -2, is a key, and no name.
                found |= {k if isinstance(k, str) else f"{item.name}_{k}": v for k, v in numbers}
            elif isinstance(value, bool | int | float | str):
                found[item.name] = int(value) if isinstance(value, bool) else value
        return found

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a file, which replaces one of that name.

        Parameters
        ----------
        path : str or path
            Ends in ``.json``, or has no suffix: every digit, for `stickslip.load`; in ``.csv``:
            the table, imaginary parts in columns ``..._imag``; in ``.nc``: NetCDF of `to_xarray`
            (needs the extra ``sweep``), complex numbers as ``..._real`` and ``..._imag``.

        Raises
        ------
        ValueError
            The name has another suffix, or a file cannot hold something in the result.
        OSError
            The file cannot be written.
        """
        path = checked_path(path)
        match checked_suffix(path, SUFFIXES):
            case ".csv":
                write_table(path, self.table())
            case ".nc":
                dataset = _for_netcdf(self.to_xarray())
                with whole_file(path) as temporary:
                    dataset.to_netcdf(temporary)
            case _:
                files.save(self, path)

    # ------------------------------------------------------------------ for eyes

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the result.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; by default a new figure, which a notebook shows.
        **style
            Passed on to the function of `stickslip.plot` that draws this kind of result.

        Returns
        -------
        matplotlib.axes.Axes
        """
        module, _, name = self._plot.rpartition(".")
        draw = getattr(importlib.import_module(f"stickslip.plot.{module}"), name)
        axes: Axes = draw(self, ax, **style)
        return axes

    def __repr__(self) -> str:
        """Name, number of rows, and the table."""
        table = self.table()
        rows = f"{table.n_rows} row{'' if table.n_rows == 1 else 's'}"
        return f"{type(self).__name__}: {rows}\n{table!r}"

    def _repr_html_(self) -> str:
        return self.table().as_html(repr(self).partition("\n")[0])

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        """Text, and the table below the picture: a notebook shows one of what it is given."""
        html = self._repr_html_()
        if self._has_picture:
            try:
                style = importlib.import_module("stickslip.plot.style")
                html = f'<img src="data:image/png;base64,{style.png_text(self.plot)}"/>{html}'
            except Exception:  # noqa: S110, RUF100 (the table must appear whatever fails)
                pass
        return {"text/plain": repr(self), "text/html": html}

    # ------------------------------------------------------------------ equality

    __eq__ = equal_results
    __hash__ = hash_of_result


class ResultRow(Result):
    """A result whose table is one row: its fields and properties of the columns' names."""

    def _facts(self) -> Iterable[Any]:
        """Return what stands in the columns, in order."""
        return (getattr(self, name) for name in self._column_names)

    def _columns(self) -> dict[str, Any]:
        return {n: [fact] for n, fact in zip(self._column_names, self._facts(), strict=True)}


Item = TypeVar("Item", bound=Result)


class ResultList(Result, Sequence[Item]):
    """A sequence of results of one class, whose table joins theirs.

    Subclasses list the columns of an item in ``_column_names``, so that an empty list has them
    too, and may name in ``_number`` a first column that counts the items from 1; ``_of`` is the
    field that holds them.
    """

    _number: ClassVar[str] = ""
    _of: ClassVar[str] = "items"

    @property
    def _items(self) -> tuple[Item, ...]:
        items: tuple[Item, ...] = getattr(self, self._of)
        return items

    def __len__(self) -> int:
        """Count."""
        return len(self._items)

    @overload
    def __getitem__(self, index: int) -> Item: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Item, ...]: ...
    def __getitem__(self, index: int | slice) -> Item | tuple[Item, ...]:
        """Return one of them, or several as a tuple."""
        return self._items[index]

    def __iter__(self) -> Iterator[Item]:
        """Iterate in order."""
        return iter(self._items)

    def _columns(self) -> Mapping[str, Any]:
        tables = [item.table() for item in self._items]
        joined = {
            name: [cell for table in tables for cell in as_list(table[name])]
            for name in self._column_names
        }
        if not self._number:
            return joined
        lengths = [table.n_rows for table in tables]
        return {self._number: np.repeat(np.arange(len(tables)) + 1, lengths), **joined}


def _labelled(name: str, column: NDArray[Any]) -> tuple[tuple[str, ...], NDArray[Any]]:
    """Return a column with the names of its axes, one for each level of cells within cells."""
    if column.dtype.kind != "O":
        return ("row",), column
    cells = column.tolist()
    kinds = {type(leaf) for leaf in _leaves(cells)} - {type(None)}
    if not kinds or not kinds <= {int, float, complex}:
        return ("row",), column
    shape = _shape(cells)
    values = np.full(shape, np.nan, dtype=complex if complex in kinds else float)
    _fill(values, cells)
    return ("row", *(f"{name}_{level}" for level in range(len(shape) - 1))), values


def _leaves(cell: Any) -> Iterator[Any]:
    if isinstance(cell, list | tuple):
        for each in cell:
            yield from _leaves(each)
    else:
        yield cell


def _shape(cell: Any) -> tuple[int, ...]:
    """Shape of the least array that holds a cell."""
    if not isinstance(cell, list | tuple):
        return ()
    inner = zip_longest(*map(_shape, cell), fillvalue=0)
    return (len(cell), *map(max, inner))


def _fill(values: NDArray[Any], cell: Sequence[Any]) -> None:
    for place, each in enumerate(cell):
        if isinstance(each, list | tuple):
            _fill(values[place], each)
        elif each is not None:
            values[place] = each


def _for_netcdf(dataset: xr.Dataset) -> xr.Dataset:
    """Write what NetCDF has no type for: as text, and complex numbers as their two parts."""
    plain = dataset.copy()
    for name, variable in dataset.variables.items():
        if variable.dtype.kind == "c":
            del plain[name]
            plain[f"{name}_real"], plain[f"{name}_imag"] = variable.real, variable.imag
        elif variable.dtype.kind == "O" or _is_large(variable.values):
            texts = [str(flat(cell, repr)) for cell in variable.values.ravel().tolist()]
            values = np.array(texts, dtype=np.str_).reshape(variable.shape)
            plain[name] = (variable.dims, values)
    attributes = {name: str(one) if _is_large(one) else one for name, one in plain.attrs.items()}
    return plain.assign_attrs(attributes)


def _is_large(values: Any) -> bool:
    array = np.asarray(values)
    return array.dtype.kind in "iu" and bool((array > LARGEST).any() or (array < -LARGEST).any())
