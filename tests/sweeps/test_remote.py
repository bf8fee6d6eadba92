"""Buckets, of a server on this machine that speaks S3."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from tests.sweeps import small
from tests.sweeps.test_killed import ROOT

import stickslip as ss
from stickslip.errors import StoreBusy
from stickslip.sweeps import place as places
from stickslip.sweeps.place import place_of

pytest.importorskip("s3fs")
pytest.importorskip("flask_cors")
moto_server = pytest.importorskip("moto.server")

pytestmark = pytest.mark.filterwarnings("ignore")  # of the test server and of botocore


@pytest.fixture(scope="module")
def options():
    server = moto_server.ThreadedMotoServer(port=0, verbose=False)
    server.start()
    port = server.get_host_and_port()[1]
    options = {
        "key": "anyone",
        "secret": "anything",
        "endpoint_url": f"http://127.0.0.1:{port}",
        "client_kwargs": {"region_name": "eu-central-1"},
    }
    # Workers that share tests come back to a module: its buckets outlive a server.
    place_of("s3://maps/x", options).fs.makedirs("maps", exist_ok=True)
    yield options
    server.stop()


@pytest.fixture
def store(request):
    return f"s3://maps/{request.node.name.replace('[', '_').replace(']', '')}"


def test_a_bucket_holds_what_a_folder_holds(store, options, tmp_path):
    there = small.run(store, storage_options=options).load()
    here = small.run(tmp_path / "x").load()
    for name in here.data_vars:
        assert there[name].values.tobytes() == here[name].values.tobytes()
    objects = place_of(store, options).fs.find("maps", withdirs=False)
    assert not [name for name in objects if name.endswith(".lock")]


def test_a_damaged_object_is_computed_again(store, options):
    before = small.run(store, storage_options=options).load()
    place = place_of(store, options)
    content = place.fs.cat_file(place.of("period/c/1/2"))
    place.fs.pipe_file(place.of("period/c/1/2"), content[:-2])
    place.fs.rm_file(place.of("kind/c/0/0"))
    seen = []
    after = small.run(store, storage_options=options, progress=seen.append)
    assert seen[0].resumed == 120 - 24
    np.testing.assert_array_equal(after.period, before.period)
    np.testing.assert_array_equal(after.kind, before.kind)


def test_a_second_writer_is_refused(store, options):
    place = place_of(store, options)
    with places.writing(place):
        with pytest.raises(StoreBusy, match=f"being written by process {os.getpid()} on"):
            small.run(store, storage_options=options)
    small.run(store, storage_options=options)


def test_a_lease_of_a_killed_process_is_taken_over(store, options):
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, store, repr(options)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
        stdout=subprocess.PIPE,
    )
    assert holder.stdout.readline() == b"held\n"
    with pytest.raises(StoreBusy, match=f"process {holder.pid}"):
        small.run(store, storage_options=options)
    holder.send_signal(signal.SIGKILL)
    holder.communicate()
    assert small.run(store, storage_options=options).attrs["done"] == 12


HOLD = """
import sys, time
from stickslip.sweeps.place import writing
from stickslip.sweeps.place import place_of
with writing(place_of(sys.argv[1], eval(sys.argv[2]))):
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.mark.parametrize(("age", "taken"), [(10.0, False), (1000.0, True)])
def test_a_lease_of_another_machine_runs_out(store, options, age, taken):
    place = place_of(store, options)
    lease = places._Lease(place)
    lease.mine |= {"host": "elsewhere", "renewed": 0}
    lease.take()
    content = place.fs.cat_file(lease.path).decode()
    renewed = content[content.index('"renewed"') :]
    old = content.replace(renewed, f'"renewed": {time.time() - age}}}')
    place.fs.pipe_file(lease.path, old.encode())
    if taken:
        assert small.run(store, storage_options=options).attrs["done"] == 12
    else:
        with pytest.raises(StoreBusy, match="on elsewhere"):
            small.run(store, storage_options=options)


def test_a_writer_whose_lease_was_taken_stops(store, options, monkeypatch):
    monkeypatch.setattr(places, "RENEWED_EVERY", 0.05)
    place = place_of(store, options)

    def steal(progress):
        if progress.done:
            thief = places._Lease(place)
            thief._put(mode="overwrite")
            time.sleep(0.5)

    with pytest.raises(StoreBusy):
        small.run(store, storage_options=options, progress=steal)
    assert ss.open_sweep(store, storage_options=options).attrs["done"] < 12


def test_a_bucket_alone_is_no_store(options):
    with pytest.raises(ValueError, match="a name inside the bucket is needed"):
        small.run("s3://maps", storage_options=options)


def test_missing_credentials_are_told(tmp_path, monkeypatch):
    for name in [name for name in os.environ if name.startswith("AWS_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    with pytest.raises(ValueError, match=r"maps/x' cannot be reached .*credentials.* in storage_o"):
        small.run("s3://maps/x", storage_options={"skip_instance_cache": True})


def test_an_unknown_kind_of_url_is_refused():
    with pytest.raises(ValueError, match="store = 'gopher://x/y' cannot be reached"):
        small.run("gopher://x/y")
