"""Work on threads, and all that a lesson needs where there are none, nor signals, nor processes."""

import subprocess
import sys
import threading

import pytest

from stickslip.numerics import threads
from stickslip.numerics.threads import pool

IN_A_BROWSER = """
import _thread, os, signal, subprocess, sys, threading
if sys.argv[2:]:
    def refuse(*_, **__):
        raise RuntimeError("can't start new thread")
    for module in (threading, _thread):
        for name in ("_start_new_thread", "start_new_thread", "_start_joinable_thread",
                     "start_joinable_thread"):
            if hasattr(module, name):
                setattr(module, name, refuse)
    for name in ("_multiprocessing", "_posixshmem", "_posixsubprocess", "fcntl", "resource"):
        sys.modules[name] = None
    for module, names in (
        (signal, ("setitimer", "alarm", "pthread_kill", "set_wakeup_fd", "raise_signal")),
        (os, ("fork", "posix_spawn", "sched_getaffinity", "register_at_fork")),
    ):
        for name in names:
            if hasattr(module, name):
                delattr(module, name)
    os.cpu_count = lambda: 2
    subprocess.Popen = None

import numpy as np
import matplotlib.pyplot as plt
import stickslip as ss
from stickslip.cli import main

os.chdir(sys.argv[1])
model = ss.examples.coulomb()
f = ss.event_map(model)
print(f.evaluate(np.linspace(*f.domain, 20_001)).value.sum().hex())
print(ss.periodic_orbits(f, 4))
print(ss.basins(f))
print(ss.bifurcations(model, "V", (0.0369, 0.037), n_lists=3))
diagram = ss.bifurcation_diagram(model, "V", np.linspace(0.0369, 0.037, 3), n_lists=3)
print(diagram)
fig, axes = plt.subplots(1, 2)
ss.branches(f).plot(ax=axes[0])
diagram.plot(ax=axes[1])
fig.savefig("picture.png")
ss.plot.film(ss.simulate(model, d=0.1, t_end=5), "film.gif", frames=2)
law = ss.friction_law(lambda s, a: 1 / (1 + a * s), parameters={"a": 2.125})
print(ss.event_map(model.replace(friction=law))(0.1))
assert main("orbits --preset coulomb --out orbits.csv".split()) == 0
"""


@pytest.fixture
def no_threads(monkeypatch):
    def refuse(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    threads.threads_start.cache_clear()
    yield
    threads.threads_start.cache_clear()


def test_without_threads_a_task_is_done_when_it_is_given(no_threads):
    done = []
    with pool(3, "some") as workers:
        assert [workers.submit(done.append, k).done() for k in range(3)] == [True] * 3
        assert done == [0, 1, 2]
        assert list(workers.map(abs, [-1, 2])) == [1, 2]
        with pytest.raises(ZeroDivisionError):
            workers.submit(lambda: 1 / 0).result()


def test_without_threads_an_interrupt_goes_to_who_gives_the_task(no_threads):
    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pool(3, "some").submit(interrupted)


def test_threads_are_used_where_they_start():
    with pool(2, "some") as workers:
        assert workers.submit(threading.current_thread).result() is not threading.current_thread()


def test_maps_lists_and_pictures_need_neither_threads_nor_signals_nor_processes(tmp_path):
    told = []
    for bare in ((), ("bare",)):
        place = tmp_path / str(len(bare))
        place.mkdir()
        command = [sys.executable, "-c", IN_A_BROWSER, str(place), *bare]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert {path.name for path in place.iterdir()} == {"picture.png", "film.gif", "orbits.csv"}
        told.append(done.stdout)
    assert told[0] == told[1]
