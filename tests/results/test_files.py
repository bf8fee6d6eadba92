"""Results written to files and read again."""

import csv
import dataclasses
import json
import math

import numpy as np
import pytest
from tests.analysis import known_maps as examples

import stickslip as ss
from stickslip import examples as models
from stickslip.analysis.attractors.basin_pieces import EdgeCause
from stickslip.analysis.bifurcations.bifurcations import bifurcations
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.branches import branches, breakpoints
from stickslip.analysis.continuation.continuation import follow_orbit
from stickslip.analysis.maps.derived import PowerMap, WindowMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.friction import Coulomb, PoppStelter, Stribeck, friction_law
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Units
from stickslip.results.files import VERSION, _checksum, _hints, load, save
from stickslip.results.parts import equal, import_public, registered


@pytest.fixture
def path(tmp_path):
    return tmp_path / "result.json"


@pytest.mark.parametrize(
    "value",
    [
        None,
        True,
        -3,
        2**64 - 1,
        "text with ü and \n",
        0.1 + 0.2,
        5e-324,
        -0.0,
        math.nan,
        math.inf,
        -math.inf,
        (1, (2.5, None), ()),
        [1, [2]],
        {"a": 1, "b": {"c": (1.0,)}},
        {"is": "what is not meant"},
        {(1, 2): "key", None: 0},
        np.array([[1.0, math.nan], [-math.inf, 1 / 3]]),
        np.array([], dtype=np.float64).reshape(0, 4),
        np.array([2**64 - 1, 0, 2**63], dtype=np.uint64),
        np.array([True, False]),
        np.array([1, -1]),
        np.array(["periodic", "chaotic"]),
        TrackedDiscontinuity(2**64 - 1, None, 0.1, "jump", 1e-300),
    ],
    ids=repr,
)
def test_values_come_back_exactly(path, value):
    save(value, path)
    assert equal(load(path), value)


def test_negative_zero_keeps_its_sign(path):
    save(-0.0, path)
    assert math.copysign(1, load(path)) == -1


def test_random_floats_come_back_bit_by_bit(path):
    rng = np.random.default_rng(1)
    x = rng.integers(0, 2**64, 2000, dtype=np.uint64).view(np.float64)
    x = x[np.isfinite(x)]
    save(x, path)
    assert np.array_equal(load(path).view(np.uint64), x.view(np.uint64))


def test_annotations_of_every_registered_class_can_be_read():
    import_public()
    classes = [cls for cls in registered().values() if "tests" not in cls.__module__]
    assert len(classes) > 60
    for cls in classes:
        if dataclasses.is_dataclass(cls) or issubclass(cls, tuple):
            assert set(_hints(cls)) >= set(cls.__annotations__) - {"_texts"}


def test_a_part_that_holds_a_nan_is_loaded_equal(path):
    cause = EdgeCause("unresolved")
    assert math.isnan(cause.source)
    save(cause, path)
    assert load(path) == cause
    assert hash(load(path)) == hash(cause)


def test_a_hash_tells_arrays_apart_and_not_what_is_equal():
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(0.5), forcing=ss.Harmonic(1.0, 0.5))
    models = [block.replace(**{"forcing.amplitude": 1.0 + 0.01 * k}) for k in range(64)]
    assert len({hash(model.plant) for model in models}) == len(models)
    plant = block.plant
    same = dataclasses.replace(plant, force=-plant.force, frequency=plant.frequency.copy())
    assert same == plant
    assert hash(same) == hash(plant)


def test_orbits_and_breakpoints(path):
    f = examples.tent_with_hole()
    result = (periodic_orbits(f, 3, infinitely_unstable=True), breakpoints(f))
    save(result, path)
    assert equal(load(path), result)


@pytest.fixture(scope="module")
def branch():
    f = examples.logistic(3.3)
    return follow_orbit(periodic_orbits(f, period=2)[0], f, "r", (2.9, 3.4))


def without_system(curve):
    return dataclasses.replace(curve, problem=dataclasses.replace(curve.problem, system=None))


def test_a_branch_of_the_users_own_map_is_given_its_map_again(path, branch):
    branch.save(path)
    alone = load(path)
    assert alone.system is None
    assert equal(without_system(branch), alone)
    assert repr(alone) == repr(branch)
    with pytest.raises(ValueError, match=r"load\(path, system"):
        alone.at(r=3.2)
    again = load(path, examples.logistic(2.0))
    assert again.system.parameters == {"r": 3.3}
    assert np.array_equal(again.at(r=3.2).points, branch.at(r=3.2).points)
    assert again.at(r=3.2).multiplier == branch.at(r=3.2).multiplier


def test_branches_of_the_users_own_map_are_loaded_without_it(path):
    f = examples.logistic(3.3)
    found = branches(f)
    save(found, path)
    alone = load(path)
    assert alone.f is None
    assert alone.table() == found.table()
    assert repr(alone) == repr(found)
    assert load(path, f) == found


def test_a_system_with_other_parameters_is_refused(path, branch):
    branch.save(path)
    with pytest.raises(ValueError, match="a, b, mu, jump; the result is one of a system with r"):
        load(path, examples.border_collision())


@pytest.mark.parametrize(
    "model",
    [
        models.coulomb(),
        models.law9(),
        TwoBlock(alpha=1.0, beta=0.9, V=0.1, friction=(Coulomb(0.3, 0.01), PoppStelter(2.0))),
        TwoBlock(alpha=1 / 3, beta=0.9, V=0.1, friction=Stribeck(0.3, 0.2, exponent=2)),
        TwoBlock(
            alpha=1.0, beta=1.1, V=0.1, friction=Coulomb(0.3), units=Units(m=2.0, k=3.0, fs1=4.0)
        ),
    ],
    ids=lambda model: str(model.friction),
)
def test_event_maps_are_made_again(path, model):
    f = event_map(model, rtol=1e-13, max_events=500)
    save({"whole": f, "part": WindowMap(f, (-0.1, 0.2))}, path)
    again = load(path)
    assert again["whole"] == f
    assert isinstance(again["whole"], EventMap)
    assert again["part"] == WindowMap(f, (-0.1, 0.2))
    assert again["part"].f is again["whole"]  # equal maps are one


def test_powers_of_maps_are_made_again(path):
    f = event_map(models.coulomb())
    for base, given in ((f, None), (examples.logistic(3.0), examples.logistic(3.0))):
        save({"power": base.power(3)}, path)
        assert load(path, system=given)["power"] == PowerMap(given or base, 3)
        assert load(path, system=base.power(3))["power"] == base.power(3)
    assert load(path)["power"] is None  # of a Python function, which nobody gave


def test_maps_of_formulas_are_made_again(path):
    texts = ["a - 1.1*x - 0.35*x**2", "0.55*x - 0.62"]
    f = PiecewiseMap(texts, (-1.5, 1.5), parameters={"a": 0.45, "b": 0.2}, breakpoints=["b"])
    found = periodic_orbits(f.replace(a=0.4), 2)
    save([f, found], path)
    again = load(path)
    assert again == [f, found]
    assert again[1][0].system.parameters == {"a": 0.4, "b": 0.2}
    assert again[0].parameter_derivative(0.1, "a") == 1.0


def test_branches_of_models_need_no_system(path):
    f = event_map(models.coulomb())
    branch = follow_orbit(periodic_orbits(f, period=4)[0], f, "V", (0.0366, 0.0372))
    branch.save(path)
    again = load(path)
    assert again.system == f
    assert again.ends[1].border == branch.ends[1].border
    assert np.array_equal(again.at(V=0.0368).points, branch.at(V=0.0368).points)


def test_laws_of_the_users_own_need_the_model(path):
    law = friction_law(lambda s, a: a / (1 + s), parameters={"a": 0.9})
    model = TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    save(event_map(model), path)
    assert load(path) is None
    assert "is a Python function" in json.loads(path.read_text())["result"]["why"]
    again = load(path, system=model.replace(V=0.2, a=0.8))
    assert again.model == model


def test_files_of_others_are_refused(path):
    for text, said in [
        ("not JSON", "is not a stickslip result"),
        ("[1, 2]", "some other JSON"),
        ("[" * 100_000, "is not a stickslip result"),
        ('{"format": "something"}', "some other JSON"),
        ('{"format": "stickslip result"}', "damaged"),
        ('{"format": "stickslip result", "version": 1}', "damaged"),
    ]:
        path.write_text(text)
        with pytest.raises(ValueError, match=said) as error:
            load(path)
        assert str(path) in str(error.value)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="not UTF-8 text"):
        load(path)


def test_newer_files_are_refused(path):
    save(1.0, path)
    document = json.loads(path.read_text()) | {"version": VERSION + 1, "program": "9.9"}
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=r"9\.9 in version 3 .* Update"):
        load(path)


def test_files_of_the_first_version_are_refused_with_what_to_do(path):
    save(1.0, path)
    document = json.loads(path.read_text()) | {"version": 1, "program": "0.1.0"}
    path.write_text(json.dumps(document))
    with pytest.raises(ValueError, match=r"0\.1\.0 in version 1 .* Compute the result again"):
        load(path)


@pytest.mark.parametrize(
    "result",
    [
        {"is": "NoSuchType"},
        {"is": "TrackedDiscontinuity", "x": 1.0},
        {"is": "TrackedDiscontinuity", "left": 1},
        {"is": "array", "dtype": "float64", "shape": [3], "of": [1.0]},
        {"is": "array", "dtype": "float64", "shape": [1], "of": ["one"]},
        {"is": "array", "dtype": "uint64", "shape": [1], "of": [10**30]},
        {"is": "float", "of": "many"},
        {"is": "tuple"},
    ],
    ids=str,
)
def test_damaged_files_are_told(path, result):
    replace_result(path, result)
    with pytest.raises(ValueError, match="is damaged: result"):
        load(path)


def replace_result(path, result):
    """Write a file by hand, without a checksum."""
    save(1.0, path)
    document = json.loads(path.read_text()) | {"result": result}
    del document["sha256"]
    path.write_text(json.dumps(document))


@pytest.mark.parametrize("renamed", ["refused", "Fit"])
def test_a_whole_file_of_a_program_with_other_classes_is_not_called_damaged(path, renamed):
    block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    save(ss.fit(block, ss.ForcePoints([0.1, 0.2, 0.3], [0.52, 0.47, 0.5]), ["mu"]), path)
    document = json.loads(path.read_text().replace(f'"{renamed}"', '"former"'))
    path.write_text(json.dumps(document | {"sha256": _checksum(document)}))
    with pytest.raises(
        ValueError, match=r"is whole, but of another state of stickslip .*former"
    ) as why:
        load(path)
    assert renamed == "Fit" or "besides: former, refused." in str(why.value)
    path.write_text(path.read_text().replace("0.47", "0.48"))
    with pytest.raises(ValueError, match="is damaged: result"):
        load(path)


def test_files_without_a_checksum_are_read(path):
    replace_result(path, [1, {"is": "tuple", "of": [2.5]}])
    assert load(path) == [1, (2.5,)]


def test_a_changed_number_is_noticed_and_another_layout_is_not(path):
    save([1.5, 2.5], path)
    document = json.loads(path.read_text())
    path.write_text(json.dumps(document, indent=3))
    assert load(path) == [1.5, 2.5]
    path.write_text(json.dumps(document | {"result": [1.5, 2.25]}))
    with pytest.raises(ValueError, match="is damaged: its content does not fit its sha256"):
        load(path)


def deep(levels):
    """Nest tuples."""
    value = 1.0
    for _ in range(levels):
        value = {"is": "tuple", "of": [value]}
    return value


@pytest.mark.parametrize(
    ("result", "fragment"),
    [
        ({"is": ["list"]}, "result"),
        ({"is": "k" * 100_000}, "result"),
        ({"is": "TrackedDiscontinuity", "k" * 100_000: 1}, "result"),
        ({"is": "part", "kind": "model", "description": 5}, "result"),
        ({"is": "map", "text": "f", "kind": "event map", "description": [1]}, "result"),
        ({"is": "map", "text": "f", "kind": "formulas", "description": {"func": "x("}}, "result"),
        ({"is": "dict", "of": [[1]]}, "result"),
        ({"is": "array", "dtype": "V1000000000", "shape": [1], "of": [1]}, "type of numbers"),
        ({"is": "array", "dtype": "float64", "shape": [10**9, 10**9], "of": []}, "result"),
        ({"is": "array", "dtype": "str", "shape": [20_000], "of": ["x" * 10_000] * 20_000}, "long"),
        ([0.0, [deep(400)]], "nested too deeply"),
    ],
    ids=lambda value: repr(value)[:40],
)
def test_hostile_files_are_told_shortly(path, result, fragment):
    replace_result(path, result)
    with pytest.raises(ValueError, match="is damaged") as error:
        load(path)
    assert fragment in str(error.value)
    assert len(str(error.value)) < 600


@pytest.mark.parametrize("text", ["NaN", "1" * 5000, "{" * 10_000], ids=["nan", "digits", "open"])
def test_what_json_cannot_say_is_told_with_the_files_name(path, text):
    path.write_text('{"format": "stickslip result", "version": 2, "result": ' + text + "}")
    with pytest.raises(ValueError, match=r"result\.json is not a stickslip result"):
        load(path)


WRONG = [None, True, "text", 10**400, 0.5, [], {}, {"is": "tuple", "of": [[]]}]


def test_every_field_of_a_result_is_checked_by_its_annotation(path):
    f = examples.tent_with_hole()
    result = (periodic_orbits(f, 3, infinitely_unstable=True), breakpoints(f))
    save(result, path)
    assert equal(load(path), result)
    document = json.loads(path.read_text())
    del document["sha256"]
    refused = 0
    for holder, key in list(fields_of(document["result"])):
        kept = holder[key]
        for wrong in WRONG:
            holder[key] = wrong
            path.write_text(json.dumps(document))
            try:
                load(path)
            except ValueError as error:
                assert f".{key}" in str(error)  # noqa: PT017
                refused += 1
            else:
                assert could_be(kept, wrong), (key, kept, wrong)
        holder[key] = kept
    assert refused > 100


def fields_of(written):
    """Every field of a class in a document, with what holds it."""
    children = written if isinstance(written, list) else written.values()
    for key in written if isinstance(written, dict) and written.get("is") in registered() else ():
        if key != "is":
            yield written, key
    for child in children:
        if isinstance(child, dict | list):
            yield from fields_of(child)


def could_be(kept, wrong):
    """Whether an annotation that allows one value may allow another: `float | None` and such."""
    if wrong is None:
        return kept is None or isinstance(kept, dict | int)
    if kept is None or isinstance(kept, bool) or isinstance(wrong, bool):
        return type(kept) is type(wrong) or kept is None
    number = (int, float)
    if isinstance(kept, number) or (isinstance(kept, dict) and kept.get("is") == "float"):
        return isinstance(wrong, number)
    same_kind = type(kept) is type(wrong)
    return same_kind and (not isinstance(kept, dict) or kept.get("is") == wrong.get("is"))


# --- suffixes ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["x.nc", "x.npz", "x.h5", "x.JSON", "x.json.gz", "x.csv"])
def test_a_suffix_that_cannot_be_written_is_refused_with_those_that_can(tmp_path, name):
    with pytest.raises(ValueError, match=r"Give a name that ends in \.json\."):
        save((1.0, 2.0), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_a_result_with_a_table_may_be_saved_as_csv(tmp_path):
    f = examples.logistic(3.0)
    found = bifurcations(f, "r", (2.9, 3.1), max_period=1, n_lists=6)
    found.save(tmp_path / "found.csv")
    with (tmp_path / "found.csv").open(newline="") as stream:
        (row,) = csv.DictReader(stream)
    assert float(row["value"]) == found[0].value
    assert row["kind"] == found[0].kind
    with pytest.raises(ValueError, match=r"ends in \.json or \.csv or \.nc"):
        found.save(tmp_path / "found.npz")
    dataclasses.replace(found, bifurcations=()).save(tmp_path / "found.csv")
    assert (tmp_path / "found.csv").read_text() == ",".join(row) + "\n"


@pytest.mark.parametrize("path", [None, 3, b"x.json", "", ["x.json"]])
def test_a_path_that_is_none_is_named(path):
    for use in (lambda path: save(1.0, path), load):
        with pytest.raises(ValueError, match=r"^path = "):
            use(path)


def test_what_is_no_result_is_refused_and_leaves_the_file_alone(path):
    save("old", path)
    for value in (object(), lambda x: x, np.array([object()]), {"deep": [(print,)]}):
        with pytest.raises(ValueError, match="cannot be saved"):
            save(value, path)
    assert load(path) == "old"
    assert list(path.parent.iterdir()) == [path]
