"""Every public result offers the same: table, text, picture, labelled arrays, files, equality."""

import csv
import dataclasses
import inspect
import sys
import typing
from collections.abc import Sequence
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib.axes import Axes
from tests.results.samples import Samples

import stickslip as ss
from stickslip.files import real_columns
from stickslip.results.files import _TypeChecked
from stickslip.results.parts import import_public, registered
from stickslip.results.result import Result, ResultList
from stickslip.results.table import SHOWN, Table

# What public functions return that is no result: models, laws, maps; labelled arrays of xarray;
# an iterator that keeps nothing; files; the explorer's window.
OTHERS = {
    *("TwoBlock", "Blocks", "Chain", "Oscillator", "BeltModel", "UserLaw", "FrictionLaw"),
    *("EventMap", "BlocksEventMap", "QuasistaticMap", "StroboscopicMap"),
    *("ReturnMap", "LineReturnMap"),
    *("Dataset", "Axis", "SlipStream", "Path", "Explorer"),
    *("Record", "EventTimes", "MapPoints", "ForcePoints", "CyclePeriods"),
}
NAMES = Samples().names


def public_results():
    import_public()
    return {
        name: cls
        for name, cls in registered().items()
        if issubclass(cls, Result)
        and dataclasses.is_dataclass(cls)
        and cls.__module__.startswith("stickslip.")
    }


def test_every_result_is_tried_here():
    assert set(NAMES) == set(public_results())


def returned_classes(function):
    """Classes that the annotation of what a function returns names, those in tuples too."""
    module = function.__module__
    hint = eval(function.__annotations__["return"], vars(sys.modules[module]), _TypeChecked(module))
    waiting, found = [hint], []
    while waiting:
        each = waiting.pop()
        waiting += typing.get_args(each)
        if inspect.isclass(each) and not typing.get_args(each):
            found.append(each)
    return [cls for cls in found if cls.__module__ not in ("builtins", "typing", "types", "numpy")]


@pytest.mark.parametrize("name", sorted(ss.__all__))
def test_public_functions_return_results(name):
    function = getattr(ss, name)
    if not inspect.isfunction(function):
        return
    for cls in returned_classes(function):
        assert issubclass(cls, Result) or cls.__name__ in OTHERS


@pytest.fixture(params=NAMES)
def result(request, samples):
    found = samples[request.param]
    assert type(found).__name__ == request.param
    return found


def test_tables_hold_columns_by_name(result):
    table = result.table()
    assert type(table) is Table
    assert len(table) > 1
    for column in table.values():
        assert column.shape == (table.n_rows,)
    assert all(name in repr(table).partition("\n")[0] for name in table)
    if isinstance(result, ResultList):
        assert isinstance(result, Sequence)
        assert list(result) == list(result[:])
        expected = [item.table().n_rows for item in result]
        assert table.n_rows == sum(expected)


@pytest.mark.parametrize("kind", ["Diagram", "Curve", "ReturnRegion"])
def test_a_parameter_keeps_its_column_whatever_it_is_called(samples, kind):
    pytest.importorskip("xarray")
    result = samples[kind]
    first, *others = result.table()
    for name in (*others, "r"):
        called = {"parameters": {name: result.values}} if kind == "Curve" else {"parameter": name}
        again = dataclasses.replace(result, **called)
        own = f"parameter_{name}" if name in others else name
        assert list(again.table()) == [own, *others]
        assert (again.table()[own] == result.table()[first]).all()
        for variable, array in result.to_xarray().variables.items():
            there = again.to_xarray()[own if variable == first else variable]
            assert np.array_equal(there, array, equal_nan=array.dtype.kind == "f")


@pytest.mark.parametrize(
    ("f", "empty", "point"),
    [
        (ss.event_map(ss.examples.coulomb()), (0,), ()),
        (ss.event_map(ss.examples.coulomb()), (2, 0), ()),
        (ss.PiecewiseMap("r * x * (1 - x)", (0, 1), parameters={"r": 3.3}), (0,), ()),
        (ss.Map(lambda x: x[..., ::-1] / 2, 2), (0, 2), (2,)),
    ],
    ids=str,
)
def test_values_at_no_points_are_a_table_without_rows(f, empty, point):
    one = f.evaluate(np.zeros(point)).table()
    none = f.evaluate(np.zeros(empty))
    assert none.table().n_rows == 0
    assert list(none.table()) == list(one)
    assert repr(none)


def test_what_has_numbers_for_keys_has_names_in_netcdf(tmp_path):
    xarray = pytest.importorskip("xarray")
    found = ss.attractors(ss.PiecewiseMap("r * x", (0, 1), parameters={"r": 3.0}))
    found.save(tmp_path / "left.nc")
    attributes = xarray.load_dataset(tmp_path / "left.nc").attrs
    ((status, count),) = found.statuses.items()
    assert attributes[f"statuses_{status}"] == count > 0


def test_lists_have_the_columns_of_their_items(samples):
    lists = [name for name in NAMES if isinstance(samples[name], ResultList)]
    assert len(lists) > 5
    for name in lists:
        found = samples[name]
        assert set(type(found)._column_names) <= set(found[0].table())
        field = next(item.name for item in dataclasses.fields(found))
        if field != "f":
            empty = dataclasses.replace(found, **{field: ()} | _no_hits(found))
            assert list(empty.table()) == list(found.table())
            assert empty.table().n_rows == len(empty) == 0


def _no_hits(found):
    return {"hits": np.zeros(0, dtype=np.int64)} if hasattr(found, "hits") else {}


def test_text_is_short_and_the_table_is_html(result):
    assert repr(result).startswith((type(result).__name__, "HopfPoint:"))
    assert len(repr(result).splitlines()) < 100
    rows = parsed(result._repr_html_())
    table = result.table()
    assert rows[0] == list(table)
    assert len(rows) == 1 + min(table.n_rows, SHOWN)
    assert all(len(row) == len(table) for row in rows)


def parsed(text):
    """Cells of the rows of an HTML table; tags must be closed in order."""
    rows, stack = [], []

    class Parser(HTMLParser):
        def handle_starttag(self, tag, attrs):
            if tag != "img":
                stack.append(tag)
            if tag == "tr":
                rows.append([])
            if tag in ("td", "th"):
                rows[-1].append("")

        def handle_endtag(self, tag):
            assert stack.pop() == tag

        def handle_data(self, data):
            if stack and stack[-1] in ("td", "th"):
                rows[-1][-1] += data

    parser = Parser()
    parser.feed(text)
    parser.close()
    assert stack == []
    return rows


def test_a_notebook_gets_text_table_and_picture(result):
    bundle = result._repr_mimebundle_()
    assert bundle["text/plain"] == repr(result)
    assert bundle["text/html"].endswith(result._repr_html_())
    shown = bundle["text/html"].startswith('<img src="data:image/png;base64,iVBOR')
    assert shown == type(result)._has_picture


def test_plots_return_axes_that_hold_something(result):
    ax = result.plot()
    assert isinstance(ax, Axes)
    assert ax.has_data()
    assert result.plot(ax) is ax
    with pytest.raises(TypeError, match=r"ax = 3 is not allowed: ax must be matplotlib axes"):
        result.plot(3)


def test_data_frames_hold_the_table(result):
    frame = result.to_pandas()
    assert Table({name: frame[name].to_numpy() for name in frame}) == plain(result.table())


def plain(table):
    """Texts as objects, as pandas has them."""
    return Table(
        {
            name: column.astype(object) if column.dtype.kind == "U" else column
            for name, column in table.items()
        }
    )


def test_labelled_arrays_are_of_xarray(result):
    xarray = pytest.importorskip("xarray")
    dataset = result.to_xarray()
    assert isinstance(dataset, xarray.Dataset)
    if type(result).to_xarray is Result.to_xarray:
        for name, column in result.table().items():
            if column.dtype.kind == "O":  # cells of several numbers, in an array
                assert dataset[name].shape[0] == len(column)
                continue
            assert np.array_equal(dataset[name].values, column, equal_nan=column.dtype.kind == "f")


def test_what_is_loaded_equals_what_was_saved(result, samples, tmp_path):
    path = tmp_path / "result.json"
    result.save(path)
    again = ss.load(path, samples.systems.get(type(result).__name__))
    assert type(again) is type(result)
    assert again == result
    assert hash(again) == hash(result)
    assert not again != result
    assert again.table() == result.table()


def test_csv_holds_the_table_to_the_last_digit(result, tmp_path):
    path = tmp_path / "result.csv"
    result.save(path)
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    table = result.table()
    assert len(rows) == table.n_rows
    table = Table(real_columns(table))
    assert header == list(table)
    for name, *cells in zip(header, *rows, strict=True):
        if table[name].dtype.kind == "f":
            assert np.array_equal(np.array(cells, dtype=float), table[name], equal_nan=True)
        elif table[name].dtype.kind in "iu":
            assert [int(cell) for cell in cells] == table[name].tolist()
    with pytest.raises(ValueError, match=r"result.csv is a table or NetCDF, which pandas.read_csv"):
        ss.load(path)


def test_netcdf_holds_the_labelled_arrays(result, tmp_path):
    xarray = pytest.importorskip("xarray")
    path = tmp_path / "result.nc"
    result.save(path)
    dataset = xarray.load_dataset(path)
    for name, variable in result.to_xarray().variables.items():
        parts = {f"{name}_real": variable.real, f"{name}_imag": variable.imag}
        for part, there in parts.items() if variable.dtype.kind == "c" else [(name, variable)]:
            if there.dtype.kind == "f":
                assert np.array_equal(dataset[part].values, there.values, equal_nan=True)
            assert dataset[part].shape == there.shape


@pytest.mark.parametrize(
    ("kind", "name", "axes"),
    [
        ("OrbitListND", "multipliers", ("row", "multipliers_0")),
        ("OrbitListND", "d", ("row", "d_0")),
        ("BifurcationList", "points", ("row", "points_0")),
        ("AttractorList", "bands", ("row", "bands_0", "bands_1")),
        ("BreakpointList", "block", ("row",)),
    ],
)
def test_netcdf_holds_numbers_where_cells_have_several(samples, kind, name, axes, tmp_path):
    xarray = pytest.importorskip("xarray")
    samples[kind].save(tmp_path / "result.nc")
    dataset = xarray.load_dataset(tmp_path / "result.nc")
    cells = samples[kind].table()[name].tolist()
    part = f"{name}_real" if name == "multipliers" and name not in dataset else name
    assert dataset[part].dims == axes
    for row, cell in zip(dataset[part].values, cells, strict=True):
        expected = np.nan if cell is None else np.ravel(cell).real
        np.testing.assert_array_equal(np.ravel(row)[: np.size(expected)], expected)
        assert np.isnan(np.ravel(row)[np.size(expected) :]).all()


def test_other_suffixes_are_refused_with_those_that_can_be_written(result, tmp_path):
    with pytest.raises(ValueError, match=r"ends in \.json or \.csv or \.nc"):
        result.save(tmp_path / "result.npz")
    assert list(tmp_path.iterdir()) == []


# --- equality ---------------------------------------------------------------------------------


def test_results_that_differ_are_not_equal(samples):
    orbits = samples["OrbitList"]
    assert orbits != samples["BreakpointList"]
    assert orbits != orbits.orbits
    assert orbits[0] != orbits[1]
    changed = dataclasses.replace(orbits[0], points=orbits[0].points + 1e-16)
    assert (changed == orbits[0]) == np.array_equal(changed.points, orbits[0].points)
    assert dataclasses.replace(orbits, orbits=orbits.orbits[1:]) != orbits


# --- tables -----------------------------------------------------------------------------------


def test_columns_are_of_one_kind_and_equally_long():
    table = Table({"a": [1, 2.5], "b": ["x", "<b>"], "c": [None, 3], "d": [[1.0, 2.0], (3.0,)]})
    assert [table[name].dtype.kind for name in table] == ["f", "U", "O", "O"]
    assert list(table.rows()) == [
        {"a": 1.0, "b": "x", "c": None, "d": (1.0, 2.0)},
        {"a": 2.5, "b": "<b>", "c": 3, "d": (3.0,)},
    ]
    assert "&lt;b&gt;" in table.as_html("a < b")
    assert "a &lt; b" in table.as_html("a < b")
    assert repr(table).splitlines()[1] == "  1  x       1 2"
    with pytest.raises(ValueError, match="equally long"):
        Table({"a": [1], "b": [1, 2]})


def test_long_tables_are_cut():
    table = Table({"number": np.arange(SHOWN + 3)})
    assert repr(table).endswith("\n... 3 more rows")
    assert "<p>... 3 more rows</p>" in table.as_html()


def test_columns_of_text_do_not_run_together_however_long_the_numbers():
    small = ss.PiecewiseMap(
        lambda x: np.where(x < 1e-90 / 3, -1.23456789012345 * x, 0.5 * x - 1.23456789012345e-91),
        (-1e-90, 1e-90),
        breakpoints=[1e-90 / 3],
    )
    result = ss.event_map(ss.examples.coulomb()).evaluate([0.1, -0.2])
    longest = dataclasses.replace(result, value=-result.value * 1e-300, derivative=[-1e300] * 2)
    for found, columns in ((ss.branches(small), 5), (ss.breakpoints(small), 6), (longest, 5)):
        first = repr(found).splitlines()[2]
        assert len(first.split()) == columns, first
