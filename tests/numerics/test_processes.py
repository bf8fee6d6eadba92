"""Tasks in processes of their own: the same answers, in order, whatever is lost on the way."""

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from functools import partial

import pytest

from stickslip.analysis.branches.table import branch_table, tables_complete_above
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.numerics import processes
from stickslip.numerics.processes import PROCESSES, in_processes, travels
from stickslip.numerics.threads import PROCESS

SECRET = travels(ContextVar("secret", default="none"))


@pytest.fixture(autouse=True)
def started(two_processes):
    with two_processes():
        yield


def elsewhere(*_):
    return PROCESS in os.environ


def away(x):
    assert elsewhere()
    return x * x


def test_results_come_in_order_from_elsewhere():
    assert list(in_processes(away, range(20))) == [x * x for x in range(20)]


def slow_first(x):
    time.sleep(1.0 if x == 0 else 0.0)
    return time.monotonic()


def test_a_slow_task_holds_up_none_but_the_order():
    ends = list(in_processes(slow_first, range(12)))
    assert sorted(ends)[6] < ends[0]


def test_functions_without_a_name_travel():
    assert list(in_processes(lambda x: (x, elsewhere()), [1, 2])) == [(1, True), (2, True)]


def test_what_cannot_travel_is_done_here():
    kept = (number for number in range(3))  # no generator can be pickled
    assert list(in_processes(lambda x: bool(kept) and elsewhere(), [1, 2])) == [False, False]


def test_all_threads_share_the_same_processes():
    def seen():
        return {pid for _, pid in in_processes(lambda x: (time.sleep(0.05), os.getpid()), range(8))}

    with ThreadPoolExecutor(3) as threads:
        found = [future.result() for future in [threads.submit(seen) for _ in range(3)]]
    assert len(set().union(*found)) == PROCESSES.count


ORPHANS = """
import os, signal
from stickslip.numerics.processes import PROCESSES
PROCESSES.count = 2
print({PROCESSES.submit(os.getpid).result() for _ in range(9)}, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_processes_end_with_the_one_that_started_them():
    done = subprocess.run([sys.executable, "-c", ORPHANS], capture_output=True, text=True)
    left = [int(pid) for pid in done.stdout.strip("{}\n").split(",")]
    end = time.monotonic() + 60.0
    while any(map(is_alive, left)) and time.monotonic() < end:
        time.sleep(0.05)
    assert left
    assert not any(map(is_alive, left))
    assert "leaked" not in done.stderr  # what cleans up after them says nothing


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def mortal(x):
    if x == 2 and elsewhere():
        os._exit(1)
    return x


def test_a_process_that_dies_loses_nothing():
    assert list(in_processes(mortal, range(5))) == list(range(5))
    assert list(in_processes(away, range(5))) == [0, 1, 4, 9, 16]  # others have started


def failing(x):
    raise ValueError(f"{x} is too much") if x == 3 else LookupError(x)


def test_an_error_is_the_callers():
    with pytest.raises(LookupError, match="0"):
        list(in_processes(failing, range(5)))


def test_what_the_teller_raises_ends_the_work():
    told = []

    def tell(share):
        told.append(share)
        if len(told) > 3:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        list(in_processes(partial(time.sleep), [0.2] * 50, tell))
    assert told == sorted(told)


def late(path):
    time.sleep(3)
    path.touch()


def test_an_interrupt_ends_the_tasks_at_work(tmp_path):
    list(in_processes(away, range(2)))
    files = [tmp_path / name for name in "abcdef"]

    def interrupt(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(in_processes(late, files, interrupt))
    assert not any(path.exists() for path in files)
    PROCESSES.begin(0)
    assert list(in_processes(away, range(3))) == [0, 1, 4]


def secret(_):
    return SECRET.get()


def test_context_travels():
    token = SECRET.set("told")
    assert list(in_processes(secret, range(2))) == ["told", "told"]
    SECRET.reset(token)


def resolution(f):
    return branch_table(f).resolution


def test_the_resolution_of_tables_travels():
    f = PiecewiseMap(lambda x: 0.5 * x, (0.0, 1.0))
    with tables_complete_above(1e-4):
        assert list(in_processes(resolution, [f, f])) == [1e-4, 1e-4]
    assert list(in_processes(resolution, [f, f])) == [1e-9, 1e-9]


def nested(x):
    return list(in_processes(partial(os.getppid), [])), PROCESSES.start


def test_processes_start_no_others():
    assert list(in_processes(nested, range(2))) == [([], False)] * 2


def test_short_work_starts_none(monkeypatch):
    monkeypatch.setattr(PROCESSES, "are_up", False)
    monkeypatch.setattr(PROCESSES, "submit", None)
    assert list(in_processes(abs, range(100))) == list(range(100))


def test_long_work_starts_them_after_its_first_task(monkeypatch):
    monkeypatch.setattr(PROCESSES, "are_up", False)
    monkeypatch.setattr(processes, "WORTH", 0.1)
    assert list(in_processes(slow, range(4))) == [False, True, True, True]


def slow(_):
    time.sleep(0.1)
    return elsewhere()
