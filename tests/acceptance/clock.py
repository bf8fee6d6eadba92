"""A plugin of pytest that stops tests that take too long, and remembers how long the others took.

Measured in processor time, so that it does not matter what else the machine does.
"""

from __future__ import annotations

import os
import signal
import time
from types import FrameType

import pytest

LONGEST = 1.5  # seconds
SOON = 0.01
LOCKING = ("/coverage/", "/numba/", "/llvmlite/")
seconds: dict[str, float] = {}
"""Of the tests that passed, by node id."""


class TooLong(BaseException):
    """Not an Exception: hypothesis would look for a smaller example of those."""


def pytest_configure() -> None:
    """Keep to one core: only the first of the package's threads could be stopped."""
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cores[os.getpid() % len(cores)]})


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> object:
    """Give a test its time."""
    signal.signal(signal.SIGVTALRM, _stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    began = time.process_time()
    try:
        result = yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    seconds[item.nodeid] = time.process_time() - began
    return result


def _stop(_signal: int, frame: FrameType | None) -> None:
    if _may_hold_a_lock(frame):
        signal.setitimer(signal.ITIMER_VIRTUAL, SOON)
        return
    raise TooLong


def _may_hold_a_lock(frame: FrameType | None) -> bool:
    """Whether coverage or a compiler is at work: others would wait for what it holds for ever."""
    while frame is not None:
        if any(folder in frame.f_code.co_filename for folder in LOCKING):
            return True
        frame = frame.f_back
    return False
