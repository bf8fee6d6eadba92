"""Measurements from CSV files, whose columns have names."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from inspect import signature
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.checks import instance, shown
from stickslip.files import read_text
from stickslip.identification.data import (
    CyclePeriods,
    Data,
    EventTimes,
    ForcePoints,
    MapPoints,
    Record,
)
from stickslip.mechanics.friction.values import within
from stickslip.vocabulary import closest, did_you_mean

if TYPE_CHECKING:
    from os import PathLike

    from stickslip.mechanics.model.units import Units
    from stickslip.numerics.arrays import Floats

MOST_BYTES: Final = 2**28
"""Of a file that instruments write."""
KINDS: Final[tuple[tuple[type[Any], tuple[str, ...], tuple[str, ...]], ...]] = (
    (Record, ("t",), ("x", "v")),
    (ForcePoints, ("speed", "force"), ()),
    (MapPoints, ("d", "value"), ()),
    (CyclePeriods, ("V", "period"), ()),
    (EventTimes, ("times",), ()),
)
"""What is measured: the columns that are needed, and those of which one is."""
ERRORS: Final = ("sigma", "sigma_v")
MISSING: Final = ("x", "v", *ERRORS)
"""What may be missing in some lines."""
NAMES: Final = (*(name for _, needed, some in KINDS for name in (*needed, *some)), *ERRORS)
SEPARATORS: Final = (",", ";", "\t")


def read_measurements(
    path: str | PathLike[str],
    columns: Mapping[str, str | Iterable[str]] | None = None,
    *,
    units: Units | None = None,
    **settings: Any,
) -> Data:
    r"""Read measurements from a CSV file.

    Parameters
    ----------
    path : str or path
        Text with commas, semicolons or tabulators between numbers with decimal points, and a first
        line that names the columns; lines that begin with # are left out. Displacements and
        velocities may be missing: the cell is empty, or NaN.
    columns : mapping of str to str or to several, optional
        Columns of the file that hold `t`, `x`, `v` (one for each block), or `speed` and
        `force`, or `d` and `value`, or `V` and `period`, or `times`; and their standard errors
        `sigma`, `sigma_v`; `V` of a motion holds one speed. Without, those that are called so, or
        ``x_1, x_2, ...``; an empty list stands for none.
    units : Units, optional
        Units of the file, such as SI; without it numbers are those of the model.
    **settings
        Further arguments of what is returned, such as `sigma` or `blocks`, in the units of the
        file.

    Returns
    -------
    Record, ForcePoints, MapPoints, CyclePeriods or EventTimes
        In the units of the model. Of `t` and `x` or `v` a `Record`, and so on.

    Raises
    ------
    ValueError
        No such columns, a cell that is no finite number, data that are not allowed. The message
        names file, line and column.
    OSError
        The file cannot be read.

    Examples
    --------
    >>> import pathlib, tempfile, stickslip as ss
    >>> path = pathlib.Path(tempfile.mkdtemp(), "contact.csv")
    >>> _ = path.write_text("v [m/s]; F [N]\n0.1; 3.1\n0.2; 2.7\n")
    >>> names = {"speed": "v [m/s]", "force": "F [N]"}
    >>> points = ss.read_measurements(path, names, units=ss.Units(m=2.0, k=8.0, fs1=4.0))
    >>> points.force
    array([0.775, 0.675])
    """
    asked = _asked(columns)
    text = read_text(path, limit=MOST_BYTES)
    with within(f"{path}: "):
        header, rows = _cells(text)
        found = {name: _headed(name, header, asked) for name in NAMES}
        kind, names = _kind(found, header, asked)
        parameters = signature(kind).parameters
        besides = [name for name in (*ERRORS, "V") if found[name] and name not in settings]
        names += [name for name in besides if name in parameters and name not in names]
        values: dict[str, Any] = {
            name: _numbers(header, rows, found[name], may_miss=kind is Record and name in MISSING)
            for name in names
        }
        if kind is not Record:
            values = {name: column[:, 0] for name, column in values.items()}
        else:
            values["t"] = values["t"][:, 0]
            settings = _blocks([found[name] for name in names if name in ("x", "v")]) | settings
        if "V" in values and kind is not CyclePeriods:
            values["V"] = _one_speed(values["V"])
        unused = {name for name in asked if found[name]} - {*names, *settings}
        if strange := sorted(unused | ({*settings} - {*parameters})):
            known = [name for name in parameters if name not in values]
            what = f"{shown(strange[0])} is nothing of {kind.__name__}"
            told = f"which {' and '.join(names)} tell: leave it out"
            raise ValueError(f"{what}, {told}. {did_you_mean(strange[0], known)}")
        with _by_line(header, rows, {name: found[name] for name in values}):
            data: Data = kind(**values, **settings)
    return data if units is None else data.to_dimensionless(units)


@contextmanager
def _by_line(
    header: list[str], rows: list[tuple[int, list[str]]], columns: Mapping[str, list[str]]
) -> Iterator[None]:
    """Name the line and the column of a number that is told by its place in an array."""

    def told(place: re.Match[str]) -> str:
        column = columns[place[1]][int(place[3] or 0)]
        return f"line {rows[int(place[2])][0]}, column {shown(column)}:"

    names = "|".join(columns)
    try:
        yield
    except ValueError as error:
        text = re.sub(rf"\b({names})\[(\d+)(?:, (\d+))?\] =", told, str(error))
        raise ValueError(text) from error


def _asked(columns: Any) -> dict[str, list[str]]:
    given = {} if columns is None else instance("columns", columns, Mapping, "pairs of names")
    asked = {}
    for name, headers in given.items():
        if name not in NAMES:
            raise ValueError(f"columns: {shown(name)} is not measured. {did_you_mean(name, NAMES)}")
        listed = [headers] if isinstance(headers, str) else headers
        if not np.iterable(listed) or not all(isinstance(each, str) for each in listed):
            raise ValueError(f"columns[{name!r}] = {shown(headers)}: names of columns are needed")
        asked[name] = list(listed)
    return asked


def _cells(text: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return names of columns, then numbers of lines and their cells."""
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise ValueError("a line of names of columns is needed, and lines of numbers below.")
    first = lines[0][1]
    separator = max(SEPARATORS, key=first.count)
    split = csv.reader((line for _, line in lines), delimiter=separator, skipinitialspace=True)
    try:
        rows = [[cell.strip() for cell in row] for row in split]
    except csv.Error as error:
        raise ValueError(f"not CSV: {error}") from None
    header = rows[0]
    if len(rows) != len(lines):
        raise ValueError("not CSV: a quotation mark is not closed.")
    if all(_number(cell) is not None for cell in header):
        raise ValueError(
            f"line {lines[0][0]} holds numbers: the first line must name the columns, such as t,x"
        )
    if len(set(header)) < len(header):
        twice = next(name for name in header if header.count(name) > 1)
        raise ValueError(f"two columns have the name {shown(twice)}")
    for (number, _), row in zip(lines, rows, strict=True):
        if len(row) != len(header):
            raise ValueError(
                f"line {number} has {len(row)} cells, and there are {len(header)} columns"
            )
    return header, [(number, row) for (number, _), row in zip(lines[1:], rows[1:], strict=True)]


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _headed(name: str, header: list[str], asked: Mapping[str, list[str]]) -> list[str]:
    """Columns that hold a quantity: those asked for, or those that are called so."""
    if name not in asked:
        own = [each for each in header if each == name]
        return own or [each for each in header if re.fullmatch(rf"{name}_[1-9]\d?", each)]
    for each in asked[name]:
        if each not in header:
            raise ValueError(f"no column {shown(each)}, for {name}. {did_you_mean(each, header)}")
    return asked[name]


def _kind(
    found: Mapping[str, list[str]], header: list[str], asked: Mapping[str, list[str]]
) -> tuple[type[Any], list[str]]:
    """Return what is measured by the columns asked for, or that there are, and which those are."""
    for first, (kind, needed, some) in product((asked, found), KINDS):
        there = [name for name in some if found[name]]
        if all(first.get(name) for name in needed) and (there or not some):
            return kind, [*needed, *there]
    needs = "t with x or v; speed with force; d with value; V with period; or times"
    known = [name for name in NAMES if name != "times"]  # "time" is that of a record
    near = next((told for name in header if (told := closest(name, known))), "")
    raise ValueError(
        f"the columns are {', '.join(map(shown, header))}: {needs} is needed. Commas, semicolons "
        "or tabulators part columns. Rename them, or say which they are: columns "
        f'{{"t": {header[0]!r}, ...}} (--columns "t={header[0]}" ...). {near}'.rstrip()
    )


def _blocks(named: list[list[str]]) -> dict[str, Any]:
    """Blocks by the numbers in the names of columns, if they have such."""
    numbers = [tuple(int(part) for name in names for part in _suffix(name)) for names in named]
    if all(len(each) == len(names) for each, names in zip(numbers, named, strict=True)):
        if len(set(numbers)) == 1:
            return {"blocks": numbers[0]}
    return {}


def _suffix(name: str) -> list[str]:
    return re.findall(r"^[xv]_([1-9]\d?)$", name)


def _one_speed(values: Floats) -> float:
    """Speed of the belt of one motion."""
    low, high = float(values.min()), float(values.max())
    if low < high:
        raise ValueError(
            f"column V holds {low:.6g} to {high:.6g}: the belt of one motion has one speed. Cut "
            "the record where the speed changes, or give its mean, V=, and no column for V."
        )
    return low


def _numbers(
    header: list[str],
    rows: list[tuple[int, list[str]]],
    names: list[str],
    *,
    may_miss: bool,
) -> Floats:
    """Return columns of numbers, shape (rows, names); what is empty or NaN may be missing."""
    places = [header.index(name) for name in names]
    out = np.empty((len(rows), len(places)))
    for target, (number, row) in zip(out, rows, strict=True):
        for k, place in enumerate(places):
            cell = row[place]
            value = _number(cell or "nan")
            where = f"line {number}, column {shown(header[place])}"
            if value is None:
                raise ValueError(
                    f"{where}: {shown(cell)} is not a number with a decimal point. Lines that are "
                    "no data begin with #."
                )
            if not (np.isfinite(value) or (may_miss and np.isnan(value))):
                told = f": {cell} is not a finite number" if cell else " is empty"
                raise ValueError(f"{where}{told}. Leave such lines out.")
            target[k] = value
    return out
