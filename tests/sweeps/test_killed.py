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

import stickslip as ss

pytest.importorskip("zarr")

ROOT = Path(__file__).resolve().parents[2]
KILLS = 10


def started(store):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    command = [sys.executable, "-m", "tests.sweeps.small", str(store)]
    return subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no SIGKILL")
def test_a_sweep_that_is_killed_ten_times_ends_like_one_that_was_not(tmp_path):
    small.run_slowly(tmp_path / "whole")
    store = tmp_path / "killed"
    moment = random.Random(8)
    done = [0]
    for _ in range(KILLS):
        process = started(store)
        # Wait until it begins to write, then for a random part of the time that a tile takes.
        until = time.monotonic() + 60
        while not (store / "checksum/c").exists() and process.poll() is None:
            assert time.monotonic() < until
            time.sleep(0.01)
        seen = len(list(store.glob("checksum/c/*/*")))
        while len(list(store.glob("checksum/c/*/*"))) == seen and process.poll() is None:
            if time.monotonic() > until or moment.random() < 0.02:
                break
            time.sleep(0.005)
        time.sleep(0.06 * moment.random())
        process.send_signal(signal.SIGKILL)
        process.communicate()
        if (store / "zarr.json").exists():
            done.append(ss.open_sweep(store).attrs["done"])
    assert done == sorted(done)  # nothing that was done is ever lost
    assert len(set(done)) > 3  # it was killed in the middle, again and again
    small.run_slowly(store)
    assert chunks_of(store) == chunks_of(tmp_path / "whole")
    assert not list(store.rglob("*.partial"))
