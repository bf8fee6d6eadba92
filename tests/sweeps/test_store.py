"""Stores: whole whatever happened to them, of one description, of one writer."""

import errno
import hashlib
import json
import multiprocessing
import os
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from tests.sweeps import small

import stickslip as ss
from stickslip.errors import StoreBusy, StoreFull, StoreRefused, TilesFailed
from stickslip.sweeps import store as stores
from stickslip.sweeps import sweep as sweeping
from stickslip.sweeps.identity import target
from stickslip.sweeps.place import Place

zarr = pytest.importorskip("zarr")

VALUES = ("kind", "period", "status", "lyapunov_exponent", "lyapunov_error", "orbit", "checksum")


def chunks_of(store):
    """Bytes of every chunk file, by name."""
    store = Path(store)
    return {
        str(path.relative_to(store)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in store.rglob("*")
        if path.is_file() and "/c/" in path.as_posix()
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """An uninterrupted store, to compare with and never to touch."""
    store = tmp_path_factory.mktemp("whole") / "store"
    small.run(store)
    return store


@pytest.fixture
def copy(whole, tmp_path):
    """A copy of it, to damage."""
    import shutil

    return Path(shutil.copytree(whole, tmp_path / "copy"))


def computed_points(store, **more):
    """Run again; how many points had to be computed."""
    seen = []
    small.run(store, progress=seen.append, **more)
    assert seen[-1].done == seen[-1].total == 120
    return seen[-1].total - seen[-1].resumed


def test_a_complete_store_is_only_opened(copy, whole):
    assert computed_points(copy) == 0
    assert chunks_of(copy) == chunks_of(whole)


def truncate(path):
    path.write_bytes(path.read_bytes()[:-3])


def empty(path):
    path.write_bytes(b"")


def flip_a_bit(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize("damage", [truncate, empty, flip_a_bit, Path.unlink])
@pytest.mark.parametrize("name", VALUES)
def test_a_damaged_chunk_is_found_and_computed_again(copy, whole, damage, name):
    path = copy / name / "c/1/2"
    damage(path / "0" if path.is_dir() else path)
    assert computed_points(copy) == 12
    assert chunks_of(copy) == chunks_of(whole)


def test_a_damaged_chunk_without_a_mark_is_in_nobody_s_way(copy, whole):
    # At the end of an axis, where the store reads a chunk before it writes a part of it.
    (copy / "checksum/c/0/3").unlink()
    truncate(copy / "period/c/0/3")
    assert computed_points(copy) == 4
    assert chunks_of(copy) == chunks_of(whole)


def test_a_chunk_of_another_tile_is_found(copy, whole):
    # Whole in itself, and not what was computed here.
    (copy / "period/c/1/2").write_bytes((copy / "period/c/2/1").read_bytes())
    if chunks_of(copy) == chunks_of(whole):
        pytest.skip("the two chunks are equal")
    assert computed_points(copy) == 12
    assert chunks_of(copy) == chunks_of(whole)


def test_a_tile_without_any_value_is_a_result(tmp_path):
    def run():
        seen = []
        found = ss.sweep(
            ss.examples.coulomb(),
            {"V": (0.03, 0.04, 4), "d": [7.0, 8.0]},
            [ss.observables.LyapunovExponent(transient=2, n=4)],
            store=tmp_path / "x",
            progress=seen.append,
            threads=1,
        )
        return found, seen[-1].resumed

    found, resumed = run()
    assert np.isnan(found.lyapunov_exponent).all()
    assert resumed == 0
    assert run()[1] == 8


def test_an_unfinished_store_can_be_read(copy, whole):
    (copy / "checksum/c/0/0").unlink()
    (copy / "period/c/0/0").unlink()
    found = ss.open_sweep(copy)
    assert (found.attrs["done"], found.attrs["chunks"]) == (11, 12)
    assert (found.period[:4, :3] == np.iinfo("int32").min).all()
    np.testing.assert_array_equal(found.period[4:], ss.open_sweep(whole).period[4:])


def test_xarray_alone_reads_a_store(whole):
    import xarray

    found = xarray.open_zarr(whole, chunks=None)
    np.testing.assert_array_equal(found.kind, ss.open_sweep(whole).kind)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"rng": 1}, "seed = 0 there, 1 here"),
        ({"d": 0.1}, "d = None there, 0.1 here"),
        ({"axes": {**small.AXES, "V": (0.03, 0.06, 12)}}, r"axes\.V\.to = 0\.05 there, 0\.06 here"),
        ({"observables": ["attractor"]}, "observables"),
        ({"chunks": {"V": 3}}, r"chunks \(4, 3\), not \(3, "),
    ],
)
def test_another_description_is_refused(copy, whole, more, words):
    with pytest.raises(StoreRefused, match=words):
        small.run(copy, **more)
    assert chunks_of(copy) == chunks_of(whole)


def test_another_system_is_refused(copy):
    model = ss.examples.coulomb().replace(mu=0.23)
    with pytest.raises(StoreRefused, match=r"system\.parameters\.mu = 0\.22 there, 0\.23 here"):
        ss.sweep(model, small.AXES, small.observables(), store=copy)


def test_a_changed_function_is_another_description(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))

    def run():
        import importlib
        import linecache

        import changing_function

        linecache.clearcache()
        importlib.reload(changing_function)
        return ss.sweep(
            ss.examples.coulomb(),
            {"V": [0.03]},
            [changing_function.g],
            store=tmp_path / "x",
            threads=1,
        )

    module = tmp_path / "changing_function.py"
    module.write_text("def g(f, d):\n    return 1.0\n")
    assert run().g == 1.0
    assert run().g == 1.0
    module.write_text("def g(f, d):\n    return 22.0\n")
    with pytest.raises(StoreRefused, match=r"observables\[0\]\.text"):
        run()


@pytest.mark.parametrize("key", ["device", "cpu", "features", "kernels"])
def test_another_target_is_refused(copy, monkeypatch, key):
    other = {**target(), key: "+something"}
    for module in (stores, sweeping):
        monkeypatch.setattr(module, "target", lambda device: other)
    with pytest.raises(StoreRefused, match=r"computed otherwise.*something"):
        small.run(copy)


def test_a_worker_of_another_kind_is_refused(tmp_path, monkeypatch):
    from stickslip.sweeps import job

    monkeypatch.setattr(job, "target", lambda device: {**target(), "cpu": "other"})
    with pytest.raises(
        StoreRefused, match=r"A part of this sweep was computed otherwise \(cpu other there"
    ):
        small.run(tmp_path / "x")


def test_what_is_no_sweep_is_left_alone(tmp_path):
    (tmp_path / "precious.txt").write_text("mine")
    zarr.create_group(tmp_path / "group")
    (tmp_path / "file").write_text("mine")
    for name, words in [
        (".", "is not empty and no sweep"),
        ("group", "group/zarr.json is not of a sweep"),
        ("file", "file' is a file: a sweep is a folder, or an archive in .zip"),
    ]:
        with pytest.raises(StoreRefused, match=words):
            small.run(tmp_path / name)
    assert {path.name for path in tmp_path.iterdir()} == {"precious.txt", "group", "file"}
    with pytest.raises(StoreRefused, match=r"store = '.*nothing': there is no sweep"):
        ss.open_sweep(tmp_path / "nothing")


def test_a_place_that_cannot_be_is_told():
    with pytest.raises(ValueError, match="store = '' is neither a path"):
        ss.open_sweep("")
    with pytest.raises(ValueError, match="storage_options = 3 is not a name"):
        ss.open_sweep("store", storage_options={3: 4})


@pytest.mark.parametrize("written", [0, 1, 2, 9, 10])
def test_a_store_whose_making_was_interrupted_is_made_again(tmp_path, whole, monkeypatch, written):
    class Killed(BaseException):
        pass

    real, left = Path.replace, [written]

    def killed(self, other):
        left[0] -= 1
        if left[0] < 0:
            raise Killed
        return real(self, other)

    store = tmp_path / "x"
    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", killed)
        with pytest.raises(Killed):
            small.run(store)
    assert sum(path.is_file() for path in store.rglob("*")) == written
    with pytest.raises(StoreRefused, match="has only begun" if written else "there is no sweep"):
        ss.open_sweep(store)
    assert computed_points(store) == 120
    assert chunks_of(store) == chunks_of(whole)


def hold(store, held, go):
    from stickslip.sweeps.place import place_of, writing

    with writing(place_of(store)):
        held.set()
        go.wait()


def test_a_second_writer_is_told_who_the_first_is(copy, whole):
    context = multiprocessing.get_context("spawn")
    held, go = context.Event(), context.Event()
    holder = context.Process(target=hold, args=(str(copy), held, go))
    holder.start()
    try:
        assert held.wait(60)
        with pytest.raises(StoreBusy, match=f"being written by process {holder.pid} on"):
            small.run(copy)
        assert ss.open_sweep(copy).attrs["done"] == 12
    finally:
        holder.kill()
        holder.join()
    # A lock of a process that was killed holds nobody up.
    assert computed_points(copy) == 0
    assert chunks_of(copy) == chunks_of(whole)


def test_a_full_disk_is_told_and_the_store_goes_on_later(tmp_path, whole, monkeypatch):
    store = tmp_path / "x"
    real, left = os.replace, [70]

    def replace(source, destination):
        left[0] -= 1
        if left[0] < 0 and "/c/" in str(destination):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(destination))
        real(source, destination)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", replace)
        patch.setattr(Path, "replace", lambda self, other: replace(self, other))
        patch.setattr(Path, "rename", lambda self, other: replace(self, other))
        with pytest.raises(StoreFull, match=r"no space is left for .*x.*run the same sweep again"):
            small.run(store)
    assert 0 < ss.open_sweep(store).attrs["done"] < 12
    assert 0 < computed_points(store) < 120
    assert chunks_of(store) == chunks_of(whole)
    assert not list(store.rglob("*.partial"))


def test_what_a_killed_writer_left_half_written_is_removed(copy):
    remains = copy / "period/c/1/2.0123.partial"
    remains.write_text("half")
    small.run(copy)
    assert not remains.exists()


def test_a_tile_that_fails_keeps_no_other_from_being_stored(tmp_path):
    def run(**more):
        return small.run(tmp_path / "x", observables=[small.fails_somewhere], **more)

    with pytest.raises(TilesFailed, match=r"4 chunks of .*ArithmeticError: on purpose"):
        run()
    found = ss.open_sweep(tmp_path / "x")
    assert found.attrs["done"] == 8
    assert np.isfinite(found.fails_somewhere[:8]).all()


def test_a_store_is_listed_as_often_whatever_tiles_it_has(copy, monkeypatch):
    """Each listing is a request to a bucket, and there was one for each tile."""
    listed, names = [], Place.names

    def counted(place, folder):
        listed.append(folder)
        return names(place, folder)

    monkeypatch.setattr(Place, "names", counted)
    small.run(copy)
    outputs = len(VALUES) - 1
    assert len(listed) <= 2 * outputs + 2


@pytest.mark.parametrize("name", ["x", "x.zip"])
def test_grid_points_that_the_model_refuses_have_no_values_and_are_told(tmp_path, name):
    """F(0) = a + b is at most 1: two of the corners are beyond, and so is the model's own b."""
    law = ss.friction_law("a + b * exp(-s)", parameters={"a": 0.3, "b": 0.6})
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=law)
    wanted = [*small.observables(), small.half]
    axes = {"a": [0.1, 0.4, 0.6], "b": [0.2, 0.5, 0.7]}
    chunks = {"a": 2, "b": 2}
    found = ss.sweep(model, axes, wanted, store=tmp_path / name, d=0.2, threads=1, chunks=chunks)
    assert found.kind.values[1:, 2].tolist() == [-128, -128] == found.kind.values[2, 1:].tolist()
    assert np.isnan(found.lyapunov_exponent.values).sum() == 3 == np.isnan(found.half.values).sum()
    assert found.attrs["refused"].startswith("without values: 3 of 9 grid points, ")
    assert "a = 0.4, b = 0.7: F(0) = 1.1 of the friction law" in found.attrs["refused"]
    assert ss.open_sweep(tmp_path / name).attrs["refused"] == found.attrs["refused"]
    alone = ss.sweep(
        model, {"a": [0.6], "b": [0.2]}, wanted, store=tmp_path / "y", d=0.2, threads=1
    )
    for name in alone.data_vars:
        np.testing.assert_array_equal(alone[name].values[0, 0], found[name].values[2, 0])


@pytest.mark.parametrize(
    ("declared", "words"),
    [
        ({"shape": (2,)}, r"half = 0\.5 has the shape \(\): shape = \(2,\) was declared"),
        ({"dtype": "int32"}, r"half = 0\.5 is no int32, which was declared: that would store 0\."),
        ({"dtype": "bool"}, r"half = 0\.5 is no bool, .* store True\."),
    ],
)
def test_what_a_function_returns_is_stored_as_it_was_declared_or_not(tmp_path, declared, words):
    wanted = [ss.observables.Function(function=small.half, **declared)]
    with pytest.raises(TilesFailed, match=words):
        small.run(tmp_path / "x", axes={"V": [0.03, 0.04]}, observables=wanted, chunks=None)


@pytest.mark.parametrize("name", ["x.zip", "folder/deep/X.ZIP"])
def test_a_zip_file_appears_whole(tmp_path, whole, name):
    store = tmp_path / name
    found = small.run(store)
    np.testing.assert_array_equal(found.orbit, ss.open_sweep(whole).orbit)
    with zipfile.ZipFile(store) as archive:
        names = {info for info in archive.namelist() if "/c/" in info}
        assert names == set(chunks_of(whole))
    before = store.read_bytes()
    assert computed_points(store) == 0
    assert store.read_bytes() == before
    assert not store.with_name(store.name + ".partial").exists()


def test_an_interrupted_zip_file_goes_on(tmp_path, monkeypatch):
    store = tmp_path / "x.zip"

    def stop(progress):
        if progress.done > 60:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        small.run(store, progress=stop)
    assert not store.exists()
    assert 0 < ss.open_sweep(store).attrs["done"] < 12
    assert 0 < computed_points(store) < 120
    assert store.exists()


def test_what_to_install_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(ImportError, match=r'package zarr: pip install "stickslip\[sweep\]"'):
        small.run(tmp_path / "x")


def test_the_description_is_readable_in_the_file(whole):
    facts = json.loads((whole / "zarr.json").read_text())["attributes"]["stickslip"]
    assert facts["version"] == ss.__version__
    assert facts["description"]["observables"][0] == {"name": "attractor", **small.SHORT}
    assert facts["description"]["system"]["parameters"]["mu"] == 0.22
