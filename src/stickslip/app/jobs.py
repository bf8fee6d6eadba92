"""Work that can be called off: jobs with a time limit, and turns taken fairly between users.

A job runs in a thread of its own but computes only while it holds one of a few slots. Wherever
the work calls `checkpoint` it learns that it was called off or has used up its time, and hands
its slot on if others wait and its slice is over. Slots go to the user who has had least of them.
Python runs one thread at a time, so what nobody waits for makes way for what a user waits for.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
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

    A user's patient jobs wait while an impatient one of the same user is at work.

    Parameters
    ----------
    slots : int
        Jobs that compute at the same time.
    """

    def __init__(self, slots: int) -> None:
        self._free = slots
        self._is_shut = False
        self._lock = threading.Lock()
        self._waiting: list[_Ticket] = []
        self._jobs: Counter[object] = Counter()
        self._impatient: Counter[object] = Counter()
        self._used: dict[object, float] = {}

    @property
    def is_crowded(self) -> bool:
        """Whether a job waits for a slot."""
        return bool(self._waiting)

    def must_wait(self, ticket: _Ticket) -> bool:
        """Whether it is a patient job, and its user has an impatient one."""
        return ticket.patient and self._impatient[ticket.user] > 0

    def shut(self) -> None:
        """Let nobody in until it is opened."""
        self._is_shut = True

    def open(self) -> None:
        """Let in who waits."""
        with self._lock:
            self._is_shut = False
            self._grant()

    def join(self, ticket: _Ticket) -> None:
        """Note that a job begins; newcomers start level with the least served user."""
        user = ticket.user
        with self._lock:
            if not self._jobs[user]:
                others = [used for other, used in self._used.items() if other != user]
                self._used[user] = min(others, default=0.0)
            self._jobs[user] += 1
            self._impatient[user] += not ticket.patient

    def part(self, ticket: _Ticket) -> None:
        """Note that a job has ended; users without jobs are forgotten."""
        user = ticket.user
        with self._lock:
            self._jobs[user] -= 1
            self._impatient[user] -= not ticket.patient
            if not self._jobs[user]:
                del self._jobs[user], self._impatient[user], self._used[user]
            self._grant()

    def enter(self, ticket: _Ticket) -> bool:
        """Wait for a slot, or until somebody else sets the ticket's event; tell which."""
        with self._lock:
            self._waiting.append(ticket)
            self._grant()
        ticket.event.wait()
        with self._lock:
            if not ticket.granted:
                self._waiting.remove(ticket)
            return ticket.granted

    def leave(self, user: object, seconds: float) -> None:
        """Give a slot back after so many seconds of work."""
        with self._lock:
            self._used[user] += seconds
            self._free += 1
            self._grant()

    def _grant(self) -> None:
        while self._free and not self._is_shut:
            ready = [ticket for ticket in self._waiting if not self.must_wait(ticket)]
            if not ready:
                return
            ticket = min(ready, key=lambda ticket: self._used[ticket.user])
            self._waiting.remove(ticket)
            self._free -= 1
            ticket.granted = True
            ticket.event.set()


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
        self._left = seconds
        self._since = 0.0
        self._called_off = False
        self._ticket = _Ticket(user, patient)
        self._turning = threading.Lock()

    def call_off(self) -> None:
        """Let the work end at its next checkpoint."""
        self._called_off = True
        self._ticket.event.set()

    def check(self) -> None:
        """Stop if called off or out of time; else let others have a turn now and then.

        Raises
        ------
        CalledOffError, TimeIsUpError
        """
        with self._turning:  # a job's own threads wait for its turn, too
            if self._called_off:
                raise CalledOffError
            spent = time.monotonic() - self._since
            if spent > self._left:
                raise TimeIsUpError
            turn_is_over = spent > SLICE and self._gate.is_crowded
            if turn_is_over or self._gate.must_wait(self._ticket):
                self._rest()
                self._compute()

    @contextmanager
    def running(self) -> Iterator[Job]:
        """Hold a slot; `checkpoint` in this thread is this job's."""
        self._gate.join(self._ticket)
        try:
            self._compute()
            _current.job = self
            try:
                yield self
            finally:
                _current.job = None
                self._rest()
        finally:
            self._gate.part(self._ticket)

    def _compute(self) -> None:
        """Wait for a slot."""
        self._ticket = ticket = _Ticket(self._ticket.user, self._ticket.patient)
        if self._called_off or not self._gate.enter(ticket):
            raise CalledOffError
        self._since = time.monotonic()

    def _rest(self) -> None:
        """Give the slot back, if it holds one."""
        if not self._ticket.granted:
            return
        self._ticket.granted = False
        spent = time.monotonic() - self._since
        self._left -= spent
        self._gate.leave(self._ticket.user, spent)


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
