"""Work that can be called off: jobs with a time limit, and turns taken fairly between users.

A job runs in a thread of its own but computes only while it holds one of a few slots. Wherever
the work calls `checkpoint` it learns that it was called off or has used up its time, and hands
its slot on if others wait and its slice is over. Slots go to the user who has had least of them.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

__all__ = [
    "CalledOffError",
    "Gate",
    "Job",
    "TimeIsUpError",
    "checkpoint",
    "progress_between",
    "undisturbed",
]

SLICE: Final = 0.02  # seconds of work after which others get their turn

REPORTED: Final = 0.2  # seconds between two reports of progress

_current = threading.local()


class CalledOffError(Exception):
    """The answer is not wanted any more."""


class TimeIsUpError(Exception):
    """The work took longer than a request may."""


@dataclass(eq=False)
class _Ticket:
    user: object
    patient: bool = False
    granted: bool = False
    event: threading.Event = field(default_factory=threading.Event)


class Gate:
    """A few slots for computing, shared fairly between users.

    Parameters
    ----------
    slots : int
        Jobs that compute at the same time.
    """

    def __init__(self, slots: int) -> None:
        self._free = slots
        self._lock = threading.Lock()
        self._waiting: list[_Ticket] = []
        self._active: dict[object, int] = {}
        self._used: dict[object, float] = {}

    @property
    def is_crowded(self) -> bool:
        """Whether a job waits for a slot."""
        return bool(self._waiting)

    def join(self, user: object) -> None:
        """Note that a job of this user begins; newcomers start level with the least served."""
        with self._lock:
            if not self._active.get(user):
                others = [self._used[other] for other in self._active if other != user]
                self._used[user] = max(self._used.get(user, 0.0), min(others, default=0.0))
            self._active[user] = self._active.get(user, 0) + 1

    def part(self, user: object) -> None:
        """Note that a job of this user has ended; users without jobs are forgotten."""
        with self._lock:
            self._active[user] -= 1
            if not self._active[user]:
                del self._active[user], self._used[user]

    def enter(self, ticket: _Ticket) -> None:
        """Wait for a slot, or until somebody else sets the ticket's event."""
        with self._lock:
            self._waiting.append(ticket)
            self._grant()
        ticket.event.wait()
        with self._lock:
            if not ticket.granted:
                self._waiting.remove(ticket)

    def leave(self, user: object, seconds: float) -> None:
        """Give a slot back after so many seconds of work."""
        with self._lock:
            self._used[user] += seconds
            self._free += 1
            self._grant()

    def _grant(self) -> None:
        while self._free and self._waiting:
            ticket = min(self._waiting, key=self._turn)
            self._waiting.remove(ticket)
            self._free -= 1
            ticket.granted = True
            ticket.event.set()

    def _turn(self, ticket: _Ticket) -> tuple[float, bool]:
        return self._used[ticket.user], ticket.patient


class Job:
    """One piece of work of a user.

    Parameters
    ----------
    gate : Gate
        Where it waits for its turns.
    user : hashable
        Whose turns they are.
    seconds : float
        How long it may compute, waiting aside.
    patient : bool
        Whether other jobs of this user go first.
    report : callable, optional
        Told now and then which share of the work is done.
    """

    def __init__(
        self,
        gate: Gate,
        user: object,
        seconds: float,
        *,
        patient: bool = False,
        report: Callable[[float], None] | None = None,
    ) -> None:
        self.report = report
        self._gate = gate
        self._user = user
        self._left = seconds
        self._since = 0.0
        self._patient = patient
        self._called_off = False
        self._ticket: _Ticket | None = None
        self._holds = False
        self._turning = threading.Lock()

    def call_off(self) -> None:
        """Let the work end at its next checkpoint."""
        self._called_off = True
        if (ticket := self._ticket) is not None:
            ticket.event.set()

    def check(self) -> None:
        """Stop if called off or out of time; else let others have a turn now and then.

        Raises
        ------
        CalledOffError, TimeIsUpError
        """
        if self._called_off:
            raise CalledOffError
        spent = time.monotonic() - self._since
        if spent > self._left:
            raise TimeIsUpError
        if spent > SLICE and self._gate.is_crowded and self._turning.acquire(blocking=False):
            try:
                self._rest()
                self._compute()
            finally:
                self._turning.release()

    @contextmanager
    def running(self) -> Iterator[Job]:
        """Hold a slot; `checkpoint` in this thread is this job's."""
        self._gate.join(self._user)
        try:
            self._compute()
            _current.job = self
            try:
                yield self
            finally:
                _current.job = None
                self._rest()
        finally:
            self._gate.part(self._user)

    def _compute(self) -> None:
        """Wait for a slot."""
        self._ticket = ticket = _Ticket(self._user, self._patient)
        if not self._called_off:
            self._gate.enter(ticket)
        self._ticket = None
        self._since = time.monotonic()
        self._holds = ticket.granted
        if not self._holds:
            raise CalledOffError

    def _rest(self) -> None:
        """Give the slot back, if it holds one."""
        if not self._holds:
            return
        self._holds = False
        spent = time.monotonic() - self._since
        self._left -= spent
        self._gate.leave(self._user, spent)


def checkpoint() -> None:
    """Check the job that this thread works on, if it works on one; see `Job.check`."""
    job: Job | None = getattr(_current, "job", None)
    if job is not None:
        job.check()


@contextmanager
def undisturbed() -> Iterator[None]:
    """Pass over checkpoints: for work that must not wait for a turn."""
    job, _current.job = getattr(_current, "job", None), None
    try:
        yield
    finally:
        _current.job = job


def progress_between(low: float, high: float) -> Callable[[float], None]:
    """Make a ``progress=`` for a part of this thread's job: a checkpoint, and a report."""
    job: Job | None = getattr(_current, "job", None)
    told = time.monotonic()

    def progress(share: float) -> None:
        nonlocal told
        if job is None:
            return
        job.check()
        now = time.monotonic()
        if job.report is not None and now - told > REPORTED:
            told = now
            job.report(low + (high - low) * share)

    return progress
