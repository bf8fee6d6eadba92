"""Every file of a store damaged in every way: made again bit for bit, or refused by its name."""

import itertools
import random
import shutil
import warnings
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from tests.sizes import sizes

import stickslip as ss
from stickslip.cli import main
from stickslip.errors import StoreRefused

xarray = pytest.importorskip("xarray")
pytest.importorskip("zarr")

PLAN = """\
store = "x"
d = 0.1
observables = [
    {name = "function", function = "tests.sweeps.small:second_iterate"},
    {name = "function", function = "tests.sweeps.small:both", shape = [2]},
]
[model]
kind = "two_block"
alpha = 1.2
beta = 1.3
V = 0.03
friction = {law = "a + b * exp(-s)", a = 0.1, b = 0.5}
[axes]
a = [0.1, 0.2, 0.6]  # of its two points one is refused
b = [0.2, 0.5]
[chunks]
a = 2
b = 2
"""


def contents(store):
    """Bytes of every file, by name; what is empty of files counts for nothing."""
    return {
        path.relative_to(store).as_posix(): path.read_bytes()
        for path in sorted(Path(store).rglob("*"))
        if path.is_file()
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A finished store, to copy."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "plan.toml").write_text(PLAN)
    assert main(["sweep", str(folder / "plan.toml")]) == 0
    return folder / "x"


def is_values(name):
    return name.startswith("checksum/refused/") or (
        "/c/" in name and name.split("/")[0] not in ("a", "b")
    )


def truncate(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def empty(path):
    path.write_bytes(b"")


def lengthen(path):
    path.write_bytes(path.read_bytes() + b"0")


def flips(path):
    """Damages to a file by one byte: the first, the last and others drawn."""
    size, chance = path.stat().st_size, random.Random(path.name)

    def flip(place, by, path):
        content = bytearray(path.read_bytes())
        content[place] ^= by
        path.write_bytes(content)

    for place in {0, size - 1, *(chance.randrange(size) for _ in range(3))}:
        yield partial(flip, place, chance.randrange(1, 256))


def told_and_mended(store, whole, damaged, capsys):
    """Look at a damaged store in every way; then go on with it."""
    plan, before = str(whole.parent / "plan.toml"), contents(store)
    code = main(["sweep", plan, "--store", str(store), "--status"])
    told = capsys.readouterr()
    if any(not is_values(name) for name in damaged):
        assert code == 3, damaged
        assert any(str(store / name) in told.err for name in damaged), (damaged, told.err)
        with pytest.raises(StoreRefused, match="is damaged or missing"):
            ss.open_sweep(store)
    else:
        assert code == 0, damaged
        assert "not verified: contents of the chunks" in told.out
        found = ss.open_sweep(store)
        assert f"{found.attrs['done']} of 2 chunks done" in told.out
        complete = all((store / name).is_file() for name in damaged)
        torn_mark = any(name.startswith("checksum/") for name in damaged)
        assert (found.attrs["done"] == 2) == complete or torn_mark
    assert contents(store) == before  # looking changes nothing
    assert main(["sweep", plan, "--store", str(store), "--resume"]) == 0, damaged
    assert contents(store) == contents(whole), damaged
    assert ss.open_sweep(store).attrs["done"] == 2


EACH = sizes(5, 1)  # one of so many, in turn


@pytest.mark.parametrize("each", EACH)
def test_a_damaged_file_of_a_store_is_made_again(whole, tmp_path, capsys, each):
    store = tmp_path / "x"
    damages = [
        (name, damage)
        for name in contents(whole)
        for damage in (truncate, empty, lengthen, Path.unlink, *flips(whole / name))
    ]
    for name, damage in damages[::each]:
        shutil.copytree(whole, store)
        damage(store / name)
        told_and_mended(store, whole, [name], capsys)
        shutil.rmtree(store)


@pytest.mark.parametrize("each", EACH)
def test_files_of_a_store_that_were_swapped_are_made_again(whole, tmp_path, capsys, each):
    store, known = tmp_path / "x", contents(whole)
    pairs = itertools.combinations(known, 2)
    for one, other in [pair for pair in pairs if known[pair[0]] != known[pair[1]]][::each]:
        shutil.copytree(whole, store)
        (store / one).write_bytes(known[other])
        (store / other).write_bytes(known[one])
        told_and_mended(store, whole, [one, other], capsys)
        shutil.rmtree(store)


@pytest.mark.parametrize("folder", ["a", "second_iterate", "checksum", "both/c", "checksum/c"])
def test_a_folder_of_a_store_that_was_removed_is_made_again(whole, tmp_path, folder):
    store = Path(shutil.copytree(whole, tmp_path / "x"))
    shutil.rmtree(store / folder)
    plan = str(whole.parent / "plan.toml")
    assert main(["sweep", plan, "--store", str(store), "--resume"]) == 0
    assert contents(store) == contents(whole)


def test_a_tile_that_was_moved_with_its_mark_is_found(whole, tmp_path):
    store = Path(shutil.copytree(whole, tmp_path / "x"))
    for name in ("second_iterate/c/{}/0", "both/c/{}/0/0", "checksum/c/{}/0"):
        shutil.copy(whole / name.format(0), store / name.format(1))
    plan = str(whole.parent / "plan.toml")
    assert main(["sweep", plan, "--store", str(store), "--resume"]) == 0
    assert contents(store) == contents(whole)


def test_a_tile_of_another_sweep_is_found(whole, tmp_path):
    plan = str(whole.parent / "plan.toml")
    other = tmp_path / "other.toml"
    other.write_text(PLAN.replace("d = 0.1", "d = 0.2"))
    assert main(["sweep", str(other)]) == 0
    store = Path(shutil.copytree(whole, tmp_path / "y"))
    for name in ("second_iterate/c/0/0", "both/c/0/0/0", "checksum/c/0/0"):
        shutil.copy(tmp_path / "x" / name, store / name)
    assert main(["sweep", plan, "--store", str(store), "--resume"]) == 0
    assert contents(store) == contents(whole)


@pytest.mark.parametrize("each", EACH)
def test_a_damaged_zip_file_is_made_again_or_refused_by_its_name(whole, tmp_path, capsys, each):
    plan, packed = str(whole.parent / "plan.toml"), tmp_path / "x.zip"
    assert main(["sweep", plan, "--store", str(packed)]) == 0
    content, chance, made = packed.read_bytes(), random.Random(23), []
    places = [*range(0, len(content), 211), *chance.sample(range(len(content)), 15)]
    for place in places[::each]:
        flipped = bytes([content[place] ^ chance.randrange(1, 256)])
        for damaged in (content[:place], content[:place] + flipped + content[place + 1 :]):
            packed.write_bytes(damaged)
            for what in ("--status", "--resume"):
                code = main(["sweep", plan, "--store", str(packed), what])
                assert code == 0 or (code == 3 and str(packed) in capsys.readouterr().err)
            made.append(code == 0)
            assert packed.read_bytes() == (content if made[-1] else damaged)
            assert not packed.with_name("x.zip.partial").exists()
    assert sum(made) > len(made) / 3  # what lies in one member costs that member alone


def test_a_store_that_says_nothing_more_of_itself_is_refused_by_name(whole, tmp_path):
    store = Path(shutil.copytree(whole, tmp_path / "x"))
    truncate(store / "checksum/zarr.json")
    truncate(store / "zarr.json")
    before = contents(store)
    plan = str(whole.parent / "plan.toml")
    assert main(["sweep", plan, "--store", str(store), "--resume"]) == 3
    with pytest.raises(StoreRefused, match=r"x/zarr\.json does not fit its own checksum"):
        ss.open_sweep(store)
    assert contents(store) == before


def test_xarray_opens_a_store_without_a_word(whole):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = xarray.open_zarr(whole, chunks=None)
    np.testing.assert_array_equal(found.both[..., 0], [[0.1, 0.1], [0.1, 0.1], [0.1, np.nan]])
    assert found.a.values.tolist() == [0.1, 0.2, 0.6]


def test_an_empty_tile_of_a_resumed_sweep_has_its_files(tmp_path):
    def run():
        return ss.sweep(
            ss.examples.coulomb(),
            {"V": (0.03, 0.04, 4), "d": [7.0, 8.0]},
            [ss.observables.LyapunovExponent(transient=2, n=4)],
            store=tmp_path / "x",
            chunks={"V": 2},
            threads=1,
        )

    run()
    before = contents(tmp_path / "x")
    (tmp_path / "x/lyapunov_exponent/c/0/0").unlink()
    assert (
        ss.open_sweep(tmp_path / "x").attrs["done"] < ss.open_sweep(tmp_path / "x").attrs["chunks"]
    )
    run()
    assert contents(tmp_path / "x") == before
