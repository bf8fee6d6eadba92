"""SIGKILL at any moment: nothing is lost but the tiles that were being computed."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.sweeps import small
from tests.sweeps.test_store import chunks_of

pytest.importorskip("zarr")

ROOT = Path(__file__).resolve().parents[2]
KILLS = 10
EARLY = (0, 5)  # of the kills


def started(store):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    command = [sys.executable, "-m", "tests.sweeps.small", str(store)]
    return subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE)


def marks(store):
    return len(list(store.glob("checksum/c/*/*")))


def wait_for_progress(store, process):
    before, until = marks(store), time.monotonic() + 120
    while marks(store) == before and process.poll() is None:
        assert time.monotonic() < until
        time.sleep(0.002)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no SIGKILL")
def test_a_sweep_that_is_killed_ten_times_ends_like_one_that_was_not(tmp_path):
    small.run_slowly(tmp_path / "whole")
    store = tmp_path / "killed"
    moment = random.Random(8)
    done = [0]
    for kill in range(KILLS):
        process = started(store)
        if kill in EARLY:
            time.sleep(2.0 * moment.random())  # as it starts, or lays out the store
        else:
            wait_for_progress(store, process)
            time.sleep(0.1 * moment.random())  # within a tile or while it is written
        process.send_signal(signal.SIGKILL)
        process.communicate()
        if (store / "checksum/zarr.json").exists():
            done.append(marks(store))
    assert done == sorted(done)  # nothing that was done is ever lost
    assert len(set(done)) > 3  # it was killed in the middle, again and again
    small.run_slowly(store)
    assert chunks_of(store) == chunks_of(tmp_path / "whole")
    assert not list(store.rglob("*.partial"))
