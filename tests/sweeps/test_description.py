"""Descriptions of sweeps: axes, observables, seeds, and what is refused with which words."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.sweeps import small

import stickslip as ss
from stickslip.sweeps.job import as_axes, default_chunks, tiles
from stickslip.sweeps.system import spread_starts
from stickslip.sweeps.systems import as_system

pytest.importorskip("zarr")


def test_axes_are_given_as_a_range_or_as_values():
    axes = as_axes(
        {"a": (1, 2, 5), "b": ss.axis(1, 100, 3, "log"), "c": [3, 1], "d": [1.0, 2.0, 3.0]}
    )
    assert [each.values.tolist() for each in axes.values()] == [
        [1, 1.25, 1.5, 1.75, 2],
        [1, 10, 100],
        [3, 1],
        [1, 2, 3],
    ]


@pytest.mark.parametrize(
    ("given_", "words"),
    [
        ({}, "at least one axis"),
        ({"V": (1, 2, 0)}, "axis 'V': n = 0"),
        ({"V": (0.1, np.inf, 3)}, "axis 'V': hi = inf"),
        ({"V": [1, 1]}, "axis 'V': its values must be distinct"),
        ({"V": (1, 2)}, r"axis 'V': .* a tuple is a grid"),
        ({"V": (1.0, 2.0, 3.0)}, r"axis 'V': .* a tuple is a grid"),
        ({"V": [1, np.nan]}, r"axis 'V': .* finite numbers"),
        ({"V": "text"}, r"axis 'V': V = 'text'"),
        ({"V": 3.0}, r"axis 'V': V = 3\.0"),
    ],
)
def test_an_axis_that_is_none_is_named(given_, words):
    with pytest.raises(ValueError, match=words):
        as_axes(given_)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0, 1, 3, "log"), "ends above 0"),
        ((1, 2, 3, "cubic"), "scale = 'cubic' is unknown. Known: linear, log"),
        ((1, 2, 2.5), "n = 2.5"),
    ],
)
def test_an_impossible_axis_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        ss.axis(*arguments)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (
            {"axes": {"v": (0.1, 0.2, 3)}},
            "axis 'v' is no parameter that takes a number.* Did you mean 'V'",
        ),
        ({"axes": {3: [0.1]}}, "a name in axes = 3 .*is not text, as in"),
        ({"axes": {"friction": [0.1]}}, "Known: alpha, beta, V, mu, viscous, damping\\.$"),
        ({"axes": {"V": [-1.0, 1.0]}}, r"axis 'V': V = -1\.0"),
        ({"axes": {"d": [0.1]}, "d": 0.2}, "d is an axis and a number"),
        ({"d": np.nan}, "d = nan"),
        ({"rng": -1}, "rng = -1"),
        ({"device": "gpu"}, "device = 'gpu' is unknown.* Known: cpu, cuda"),
        ({"threads": 0}, "threads = 0"),
        ({"client": object(), "threads": 2}, "threads and client"),
        ({"chunks": {"beta": 2}}, "chunks: 'beta' is no axis; the axes are V, alpha"),
        ({"chunks": {"V": 0}}, r"chunks\['V'\] = 0"),
        ({"observables": []}, "at least one is needed"),
        (
            {"observables": ["atractor"]},
            "observables: 'atractor' is unknown.* Did you mean 'attractor'",
        ),
        ({"observables": ["attractor", "attractor"]}, "two of them record a variable 'kind'"),
        (
            {
                "observables": [ss.observables.OrbitPoints(n=10**8, count=10**8)],
                "chunks": {"V": 4},
            },
            "orbit would take [0-9]+ bytes in a chunk of .* points, at most 2147483647",
        ),
        (
            {"observables": [ss.observables.CoexistingAttractors(n_starts=10**8)]},
            "the orbits from 100000000 starts would take [0-9]+ bytes .* at most 2147483647",
        ),
        (
            {
                "axes": {"V": (0.1, 0.2, 200), "d": (0, 0.1, 10**6)},
                "chunks": {"V": 1, "d": 1},
            },
            "200000000 grid points in chunks of 1 are 200000000 chunks, at most 100000000",
        ),
        ({"observables": [lambda f, d: 0.0]}, "one of a module and neither a lambda"),
    ],
)
def test_a_bad_description_is_refused_before_anything_is_written(tmp_path, more, words):
    with pytest.raises(ValueError, match=words):
        small.run(tmp_path / "x", **{"chunks": None, "threads": None, **more})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: ss.observables.Attractor(n=1),
            "n of attractor = 1 is not allowed: .* from 2 to 100000000",
        ),
        (
            lambda: ss.observables.Attractor(n=1e16),
            "n of attractor = 1e16 .* to 100000000".replace("1e16", r"1e\+16"),
        ),
        (
            lambda: ss.observables.Attractor(transient=10**300),
            r"transient of attractor = 10+\.\.\. \(301 digits\) is not allowed",
        ),
        (lambda: ss.observables.NeverReturns(n_starts=10**16), "n_starts .* to 100000000"),
        (lambda: ss.observables.LimitCycles(n_starts=10**16), "n_starts .* to 100000000"),
        (lambda: ss.observables.OrbitPoints(n=8, count=10), r"at most n \+ 1 = 9 points"),
        (lambda: ss.observables.Function(function="nowhere:f"), "'nowhere:f' cannot be imported"),
        (lambda: ss.observables.Function(function="math:nothing"), "cannot be imported"),
        (lambda: ss.observables.Function(function=small.both, dtype="U3"), "a type of numbers"),
        *(
            (lambda label=label: ss.observables.Function(function=small.both, label=label), words)
            for label in ("a/b", "zarr.json", "..", " ", "__x", "-a")
            for words in ("label = .* letters, digits",)
        ),
    ],
)
def test_an_observable_with_bad_settings_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_a_map_has_no_events(tmp_path):
    f = ss.PiecewiseMap(small.logistic, (0, 1), parameters={"r": 3.0})
    with pytest.raises(ValueError, match="observable 'events': a map of one's own has no events"):
        ss.sweep(f, {"r": (3, 4, 3)}, ["events"], store=tmp_path / "x")


@pytest.mark.parametrize(
    ("name", "words"),
    [("d", "axis 'd': the system has a parameter of that name"), ("iterate", "'iterate' is taken")],
)
def test_a_parameter_of_a_name_that_is_taken_is_refused(name, words, tmp_path):
    f = ss.PiecewiseMap(f"{name} * x * (1 - x)", (0, 1), parameters={name: 3.2})
    with pytest.raises(ValueError, match=words):
        ss.sweep(f, {name: [3.1, 3.3]}, ["orbit_points"], store=tmp_path / "store")
    assert not list(tmp_path.iterdir())


def test_what_is_no_system_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"a model, its event map, .* or a PiecewiseMap"):
        ss.sweep(ss.Oscillator, {"V": [1.0]}, ["attractor"], store=tmp_path / "x")


def test_a_map_that_depends_on_more_than_its_text_is_refused(tmp_path):
    factor = np.array([1.0])
    f = ss.PiecewiseMap(lambda x, r: r * x * factor[0] / 4, (0, 1), parameters={"r": 3.0})
    with pytest.raises(ValueError, match="depends on factor"):
        ss.sweep(f, {"r": (3, 4, 3)}, ["attractor"], store=tmp_path / "x")


def test_what_a_function_takes_from_where_it_was_made_is_part_of_it(monkeypatch):
    def described(function):
        return as_system(ss.PiecewiseMap(function, (0, 1), parameters={"r": 3.0})).identity()

    known = described(small.scaled(1.0))
    assert known == described(small.scaled(1.0)) != described(small.scaled(0.9))
    assert known != described(small.scaled(np.nan))
    before = described(small.damped)
    assert before["map"]["func"]["closure"] == {"SCALE": "1.0"}
    monkeypatch.setattr(small, "SCALE", 0.9)
    assert described(small.damped) != before
    with pytest.raises(ValueError, match="depends on self = "):
        described(small.Family().member)


def test_a_map_is_described_as_its_store_will_tell_it():
    f = ss.PiecewiseMap("r * x * (1 - x)", (0, 1), parameters={"r": 3.0})
    described = as_system(f).identity()
    assert json.loads(json.dumps(described)) == described


def test_models_that_rub_at_other_places_are_other_sweeps():
    def described(at):
        contact = ss.Contact(at=at, friction=ss.Coulomb(mu=0.4))
        model = ss.Structure(mass=[1.0, 1.0], stiffness=np.eye(2), contacts=[contact])
        return as_system(model).identity()

    assert described([1.0, 0.5]) == described([1.0, 0.5]) != described([1.0, 0.6])


@pytest.mark.parametrize("n", [2, 3])
def test_chains_followed_by_another_engine_are_other_sweeps(n):
    model = ss.Chain(static=[1.0, 1.3, 1.1][:n], alpha=1.2, V=0.04, friction=ss.Coulomb(mu=0.2))

    def described(**settings):
        return as_system(ss.event_map(model, **settings)).identity()

    assert described() == described(threads=2) == as_system(model).identity()
    assert described() != described(engine="adaptive")


@pytest.mark.parametrize("force", [[1.0, 0.8, 0.6], [1.0, 0.7, 0.5]])
@pytest.mark.parametrize("speed", [[0.0, 0.2, 1.0], [0.0, 0.2, 2.0]])
def test_models_with_other_tables_of_friction_are_other_sweeps(speed, force):
    def described(*table):
        law = ss.TabulatedFriction(*table)
        two_block, block = ss.examples.law9().replace(friction=law), ss.Oscillator(0.2, law)
        return [as_system(model).identity() for model in (two_block, block)]

    other = described([0.0, 0.2, 1.0], [1.0, 0.7, 0.6])
    for these, those in zip(described(speed, force), other, strict=True):
        assert these != those


@given(shape=st.lists(st.integers(1, 300), min_size=1, max_size=4))
def test_default_chunks_fit_and_leave_work_for_all(shape):
    chunks = default_chunks(tuple(shape))
    assert all(1 <= a <= n for a, n in zip(chunks, shape, strict=True))
    assert np.prod(chunks) <= 2 * 4096
    assert np.prod(chunks) <= max(1, 2 * np.prod(shape) / 64)


@given(shape=st.lists(st.integers(1, 9), min_size=1, max_size=3), data=st.data())
def test_tiles_cover_the_grid_once(shape, data):
    chunks = tuple(data.draw(st.integers(1, n)) for n in shape)
    axes = as_axes({f"a{k}": np.arange(float(n)) for k, n in enumerate(shape)})
    seen = np.zeros(shape, dtype=int)
    for tile in tiles(axes, chunks):
        seen[tile.region] += 1
        for values, part, axis in zip(tile.values, tile.region, axes.values(), strict=True):
            np.testing.assert_array_equal(values, axis.values[part])
    assert (seen == 1).all()


@given(
    seed=st.integers(0, 2**63 - 1), count=st.integers(1, 9), places=st.sets(st.integers(0, 2**62))
)
def test_starts_lie_in_cells_and_depend_on_the_place_alone(seed, count, places):
    index = np.array(sorted(places), dtype=np.uint64)
    low, high = np.full(index.size, -0.5), np.full(index.size, 1.5)
    starts = spread_starts(seed, index, count, low, high)
    cells = np.clip(np.floor((starts + 0.5) / 2 * count), 0, count - 1)
    assert ((starts >= -0.5) & (starts <= 1.5)).all()
    assert (np.abs(cells - np.arange(count)) <= 0).all() or not index.size
    for i in range(index.size):
        alone = spread_starts(seed, index[i : i + 1], count, low[:1], high[:1])
        np.testing.assert_array_equal(alone[0], starts[i])


def test_starts_are_spread_evenly():
    n = 20_000
    starts = spread_starts(7, np.arange(n, dtype=np.uint64), 1, np.zeros(n), np.ones(n))[:, 0]
    counts = np.histogram(starts, bins=20, range=(0, 1))[0]
    # Chi-square of 19 degrees of freedom exceeds 60 with a chance of 4e-6.
    assert ((counts - n / 20) ** 2 / (n / 20)).sum() < 60
    assert abs(np.corrcoef(starts[1:], starts[:-1])[0, 1]) < 5 / np.sqrt(n)
