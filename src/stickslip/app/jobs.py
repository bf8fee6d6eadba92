"""Work that can be called off: jobs with a time limit, and turns taken fairly between users.

A job computes only while it holds one of a few slots, and gives way where it calls `checkpoint`.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Final

from stickslip.numerics.threads import IN_PIECES
from stickslip.numerics.waiting import WATCH

SLICE: Final = 0.02  # seconds of work after which others get their turn
OVERDUE: Final = 0.1  # seconds of work after which a slot that others wait for is taken back
REPORTED: Final = 0.5  # seconds between two reports of progress
SLOW: Final = 0.05  # seconds between two checkpoints: from then on less is launched at once
QUICK: Final = 0.01  # ... more of it, up to what pays for a thread
FIRST: Final = 2**-13  # ... of which the first launch is this share: one point, which may take long
CREDIT: Final = 0.5  # seconds of work by which a client that comes anew is ahead of others

_current: ContextVar[Job | None] = ContextVar("job", default=None)  # of its helping threads, too


class EndedError(BaseException):
    """The work may not go on; no `Exception`: searches note those and go on with the rest."""


class CalledOffError(EndedError):
    """The answer is not wanted any more."""


class TimeIsUpError(EndedError):
    """The work took longer than a request may."""


@dataclass(eq=False)
class _Ticket:
    client: object
    user: object
    patient: bool = False
    granted: bool = False
    since: float = 0.0
    billed: float = 0.0
    overdue: bool = False
    event: threading.Event = field(default_factory=threading.Event)

    @property
    def sharers(self) -> tuple[tuple[object, ...], ...]:
        """Whose share a turn is taken from: the client's first, then the user's."""
        return (self.client,), (self.client, self.user)


class Gate:
    """A few slots for computing, shared fairly between clients, and between a client's users."""

    # Patient jobs wait while an impatient one of the same user is at work, or of a client that has
    # been served no more; impatient ones while one of a client is that has been served much less:
    # beside each other both would take twice as long. Work that reaches no checkpoint loses its
    # slot while others wait, and goes on beside them until it does; no client has more jobs at work
    # than there are slots.

    def __init__(self, slots: int) -> None:
        self._slots = self._free = slots
        self._is_shut = False
        self._lock = threading.Lock()
        self._waiting: list[_Ticket] = []
        self._working: set[_Ticket] = set()
        self._jobs: Counter[tuple[object, ...]] = Counter()
        self._impatient: Counter[tuple[object, ...]] = Counter()
        self._used: dict[tuple[object, ...], float] = {}
        self._parted: dict[tuple[object, ...], float] = {}  # what clients had used that may return

    @property
    def is_crowded(self) -> bool:
        """Whether a job waits for a slot."""
        return bool(self._waiting)

    def must_wait(self, ticket: _Ticket) -> bool:
        """Whether a quick job goes first, of its user or of a client served less."""
        client, user = ticket.sharers
        had = self._used.get(client, 0.0) - (0.0 if ticket.patient else CREDIT / 2)
        return any(
            (ticket.patient and who == user)
            or (len(who) == 1 and who != client and self._used.get(who, 0.0) <= had)
            for who, count in list(self._impatient.items())
            if count > 0
        )

    def shut(self) -> None:
        """Let nobody in until `open`."""
        self._is_shut = True

    def open(self) -> None:
        """Let in who waits."""
        with self._lock:
            self._is_shut = False
            self._grant()

    def join(self, ticket: _Ticket) -> None:
        """Note that a job begins."""
        with self._lock:
            for who in ticket.sharers:
                if not self._jobs[who]:
                    self._used[who] = self._beginning(who)
                self._jobs[who] += 1
                self._impatient[who] += not ticket.patient

    def _beginning(self, who: tuple[object, ...]) -> float:
        """Tell what counts as used at first: no more than of any, less for a client that rested."""
        kind = len(who), who[:-1]
        others = [used for other, used in self._used.items() if (len(other), other[:-1]) == kind]
        if len(who) > 1:
            return min(others, default=0.0)
        ahead = max((*others, *self._parted.values()), default=0.0) - CREDIT
        self._parted = {other: used for other, used in self._parted.items() if used > ahead}
        return self._parted.pop(who, ahead)

    def part(self, ticket: _Ticket) -> None:
        """Note that a job has ended."""
        with self._lock:
            for who in ticket.sharers:
                self._jobs[who] -= 1
                self._impatient[who] -= not ticket.patient
                if not self._jobs[who]:
                    del self._jobs[who], self._impatient[who]
                    used = self._used.pop(who)
                    if len(who) == 1:
                        self._parted[who] = used
            self._grant()

    def enter(self, ticket: _Ticket) -> bool:
        """Wait for a slot, or until somebody else sets the ticket's event; tell which."""
        with self._lock:
            self._waiting.append(ticket)
            self._grant()
        while not ticket.event.wait(OVERDUE):
            with self._lock:
                self._take_back()
                self._grant()
        with self._lock:
            if not ticket.granted:
                self._waiting.remove(ticket)
            return ticket.granted

    def leave(self, ticket: _Ticket) -> float:
        """Give a slot back; tell for how many seconds it was held."""
        with self._lock:
            self._bill(ticket)
            self._working.remove(ticket)
            self._free += not ticket.overdue
            ticket.granted = False
            self._grant()
            return ticket.billed - ticket.since

    def _bill(self, ticket: _Ticket) -> None:
        """Count what a job has used since it was last counted."""
        now = time.monotonic()
        for who in ticket.sharers:
            self._used[who] += now - ticket.billed
        ticket.billed = now

    def _take_back(self) -> None:
        """Take slots back from work that has reached no checkpoint for too long."""
        for ticket in self._working:
            self._bill(ticket)
            if not ticket.overdue and ticket.billed - ticket.since > OVERDUE:
                ticket.overdue = True
                self._free += 1

    def _grant(self) -> None:
        while self._free and not self._is_shut:
            at_work = Counter(ticket.client for ticket in self._working)
            ready = [
                ticket
                for ticket in self._waiting
                if not self.must_wait(ticket) and at_work[ticket.client] < self._slots
            ]
            if not ready:
                return
            ticket = min(
                ready, key=lambda t: (at_work[t.client], *(self._used[who] for who in t.sharers))
            )
            self._waiting.remove(ticket)
            self._working.add(ticket)
            self._free -= 1
            ticket.granted = True
            ticket.since = ticket.billed = time.monotonic()
            ticket.event.set()


class Job:
    """One piece of work of a user; a client's users share what is due to it."""

    # It may compute for so many `seconds`, waiting aside. If `patient`, other jobs of this user go
    # first. `report` is told now and then which share of the work is done.

    def __init__(
        self,
        gate: Gate,
        user: object,
        seconds: float,
        *,
        client: object = "",
        patient: bool = False,
        report: Callable[[float], None] | None = None,
    ) -> None:
        self.report = report
        self._gate = gate
        self._seconds = self._left = seconds
        self._compiled = WATCH.compiled
        self._called_off = False
        self._ticket = _Ticket(client, user, patient)
        self._turning = threading.Lock()
        self._share = FIRST

    def call_off(self) -> None:
        """Let the work end at its next checkpoint."""
        self._called_off = True
        self._ticket.event.set()

    def check_wanted(self) -> None:
        """Stop if called off."""
        if self._called_off:
            raise CalledOffError

    def check(self) -> None:
        """Stop if called off or out of time; else let others have a turn now and then."""
        with self._turning:  # a job's own threads wait for its turn, too
            self.check_wanted()
            spent = time.monotonic() - self._ticket.since
            if spent > self._left:
                if self._compiled == WATCH.compiled:
                    raise TimeIsUpError
                # A kernel was compiled meanwhile, under load for long, and never is again.
                self._compiled, self._left = WATCH.compiled, spent + self._seconds
            turn_is_over = spent > SLICE and (self._gate.is_crowded or self._ticket.overdue)
            if turn_is_over or self._gate.must_wait(self._ticket):
                self._rest()
                self._compute()

    @contextmanager
    def running(self) -> Iterator[Job]:
        """Hold a slot; `checkpoint` in this thread is this job's."""
        self._gate.join(self._ticket)
        try:
            self._compute()
            try:
                with _working(self):
                    yield self
            finally:
                self._rest()
        finally:
            self._gate.part(self._ticket)

    def launch(self, task: Callable[[int, int], None], size: int, smallest: int) -> None:
        """Run ``task(start, stop)`` over ``range(size)``, a checkpoint before each piece."""
        start = 0
        while start < size or not start:  # nothing, too, once
            self.check()
            stop, since = min(size, start + max(1, int(self._share * smallest))), time.monotonic()
            task(start, stop)
            start, seconds = max(stop, 1), time.monotonic() - since
            if seconds > SLOW:
                self._share /= 4
            elif seconds < QUICK:
                self._share = min(1.0, 2 * self._share)

    def _compute(self) -> None:
        """Wait for a slot."""
        last = self._ticket
        self._ticket = _Ticket(last.client, last.user, last.patient)
        if self._called_off or not self._gate.enter(self._ticket):
            raise CalledOffError

    def _rest(self) -> None:
        """Give the slot back, if the job holds one."""
        if self._ticket.granted:
            self._left -= self._gate.leave(self._ticket)


@contextmanager
def _working(job: Job | None) -> Iterator[None]:
    """Let checkpoints be a job's, and launches have them."""
    token, launching = _current.set(job), IN_PIECES.set(None if job is None else job.launch)
    try:
        yield
    finally:
        _current.reset(token)
        IN_PIECES.reset(launching)


def checkpoint() -> None:
    """Check this thread's job, if there is one; see `Job.check`."""
    if (job := _current.get()) is not None:
        job.check()


def undisturbed() -> AbstractContextManager[None]:
    """Pass over checkpoints: for work that must not wait for a turn."""
    return _working(None)


def progress_between(low: float, high: float) -> Callable[[float], None]:
    """Make a ``progress=`` for a part of this thread's job: a checkpoint, and a report."""
    job = _current.get()
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
