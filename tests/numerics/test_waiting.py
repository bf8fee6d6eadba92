"""Calls that last tell of themselves: on a terminal, in a notebook, in a log, and once."""

import io
import logging
import os
import pty
import re
import subprocess
import sys
import threading
import time
from dataclasses import replace

import pytest

from stickslip.numerics import waiting as told
from stickslip.numerics.targets import LASTS, launch
from stickslip.numerics.waiting import WATCH, doing, waiting, waits
from stickslip.sweeps.sweep import Progress

AT_MOST = 30.0  # seconds until a word comes, on any machine


@pytest.fixture(autouse=True)
def hasty(monkeypatch, caplog):
    monkeypatch.setattr(told, "PATIENCE", 0.01)
    monkeypatch.setattr(told, "REDRAWN", 0.01)
    caplog.set_level(logging.INFO, "stickslip")


@waits
def long_call(until, *, progress=None):
    if progress is not None:
        progress(0.25)
    end = time.monotonic() + AT_MOST
    while not until() and time.monotonic() < end:
        time.sleep(0.005)


@waits
def around(until):
    long_call(until)


def test_a_log_gets_lines_that_say_what_and_how_far(caplog):
    long_call(lambda: len(caplog.messages) > 1)
    assert {line.replace("1 s", "0 s") for line in caplog.messages} == {"long call: 0 s, 25% done"}


def test_what_is_done_now_is_told(caplog):
    def done():
        doing("one thing" if len(caplog.messages) < 2 else "")
        return len(caplog.messages) > 3

    long_call(done)
    lines = caplog.text.splitlines()  # of the messages as they were
    assert lines[0].endswith("s, 25% done, one thing")
    assert lines[-1].endswith("s, 25% done")
    doing("what nobody asks for")


def test_what_will_take_hours_is_told(caplog):
    with waiting("simulate") as tell:
        tell(1e-12)
        end = time.monotonic() + AT_MOST
        while not caplog.text and time.monotonic() < end:
            time.sleep(0.01)
    assert re.search(r"simulate: 0 s, 0% done, some \S+ hours left", caplog.text)


def test_lines_become_rare(caplog):
    long_call(lambda: len(caplog.messages) > 3)
    times = [record.created for record in caplog.records]
    assert times[3] - times[2] > 1.5 * (times[2] - times[1]) > 0


def test_the_outer_call_is_told_of(caplog):
    around(lambda: bool(caplog.messages))
    assert {line[:6] for line in caplog.messages} == {"around"}


def test_a_caller_who_watches_is_not_told(caplog):
    shares = []
    begun = time.monotonic()
    long_call(lambda: time.monotonic() > begun + 0.1, progress=shares.append)
    assert (shares, caplog.messages) == ([0.25], [])


@pytest.mark.parametrize("why", ["quiet", "another thread", "over soon"])
def test_nothing_is_said(caplog, monkeypatch, why):
    begun = time.monotonic()
    if why == "quiet":
        monkeypatch.setattr(WATCH, "quiet", True)
    if why == "over soon":
        monkeypatch.setattr(told, "PATIENCE", AT_MOST)
    thread = threading.Thread(target=long_call, args=(lambda: time.monotonic() > begun + 0.1,))
    if why == "another thread":
        thread.start()
        thread.join()
    else:
        thread.run()
    assert caplog.messages == []


def test_short_calls_share_a_thread(caplog, monkeypatch):
    monkeypatch.setattr(told, "PATIENCE", AT_MOST)
    monkeypatch.setattr(told, "REDRAWN", 0.5)
    while told.WATCH.looks:  # at calls of other tests
        time.sleep(0.01)
    before, seen = set(threading.enumerate()), set()
    for _ in range(100):
        long_call(lambda: bool(seen.update(threading.enumerate())) or True)
    assert len(seen - before) <= 1  # none, if one still looks
    assert caplog.messages == []


def test_after_an_error_the_next_call_is_told_of(caplog):
    with pytest.raises(ZeroDivisionError):
        long_call(lambda: 1 / 0)
    long_call(lambda: bool(caplog.messages))


def test_a_sweep_tells_points_their_rate_and_the_time_left(caplog):
    with waiting("sweep") as tell:
        tell(Progress(done=30, total=40, resumed=10, seconds=10.0))
        end = time.monotonic() + AT_MOST
        while "grid" not in caplog.text and time.monotonic() < end:
            time.sleep(0.01)
    assert re.search(r"s, 30 of 40 grid points, \S+/s, 0:00:0[5-9] left", caplog.text)


def test_a_tile_in_work_counts_by_its_time():
    """It said that 1 s is left for as long as the last tile took."""
    told = Progress(done=63, total=64, resumed=0, seconds=63.0)
    assert str(told) == "63 of 64 grid points, 1/s, 0:00:01 left"
    later = replace(told, waited=600.0)
    assert str(later) == "63 of 64 grid points, 0.095/s, 0:10:00 left"
    assert later.remaining == 600.0
    assert Progress(done=64, total=64, resumed=0, seconds=63.0, waited=5.0).remaining == 0.0


def test_a_notebook_shows_one_line_and_takes_it_away(monkeypatch):
    stream = type("OutStream", (io.StringIO,), {"__module__": "ipykernel.iostream"})()
    monkeypatch.setattr(sys, "stderr", stream)
    long_call(lambda: stream.getvalue().count("\r") > 1)
    shown, last = stream.getvalue().split("\r")[1:-1], stream.getvalue().split("\r")[-1]
    assert shown[0].startswith("stickslip: long call: 0 s, 25% done")
    assert (shown[-1].strip(), last) == ("", "")
    assert "\n" not in stream.getvalue()


TERMINAL = """
import time
from stickslip.numerics import waiting
waiting.PATIENCE = waiting.REDRAWN = 0.05
with waiting.waiting("basins") as tell:
    tell(0.5)
    time.sleep(2)
    print("a result")
"""


def test_a_terminal_shows_a_bar_and_takes_it_away():
    main, side = pty.openpty()
    done = subprocess.run(
        [sys.executable, "-c", TERMINAL],
        stderr=side,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "80"},
    )
    os.close(side)
    shown = os.read(main, 1 << 16).decode()
    os.close(main)
    assert done.stdout == "a result\n"
    assert "basins: " in shown
    assert "50% done" in shown
    assert shown.rstrip().endswith("\x1b[2K")  # the line is empty again


def test_a_large_array_tells_how_far_it_is(caplog):
    end = time.monotonic() + AT_MOST

    def task(start, stop):
        while start and not caplog.messages and time.monotonic() < end:
            time.sleep(0.005)

    launch(task, LASTS, 2, 1000)
    assert "1000000 points: 0 s" in caplog.messages[0]
