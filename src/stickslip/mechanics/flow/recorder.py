"""Following one motion step by step in Python, keeping what each step was."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip import status as status_codes
from stickslip.mechanics.flow.settings import MAX_INSTANT
from stickslip.results.parts import part

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]

# Longer steps of closed forms are cut: quadrature over a step must be accurate.
LONGEST_STEP = 1.5
# Steps, for each event allowed, after which a motion without an end time is given up.
STEPS_PER_EVENT = 10

StatesInside: TypeAlias = Callable[[Ints, Floats], tuple[Floats, Floats, Floats]]


@part
@dataclass(frozen=True, eq=False)
class Recorded:
    """A motion as it was followed: n steps of N blocks; entries of all but `inside`: n + 1."""

    t: Floats
    x: Floats
    w: Floats
    e: Floats
    mode: Ints  # of each step; in the end those that the motion ends with
    inside: StatesInside | None  # (step, t since its start) -> x, w, e; None: events only


class Record:
    """Steps of a motion while it is followed, or the `last` of them: start times, states, modes."""

    def __init__(self, last: int | None = None) -> None:
        self.t: deque[float] = deque(maxlen=last)
        self.x: deque[Floats] = deque(maxlen=last)
        self.w: deque[Floats] = deque(maxlen=last)
        self.e: deque[Floats] = deque(maxlen=last)
        self.mode: deque[Ints] = deque(maxlen=last)

    def add(self, t: float, x: Floats, w: Floats, e: Floats, mode: Ints) -> None:
        """Keep the state at the start of a step."""
        self.t.append(t)
        self.x.append(x.copy())
        self.w.append(w.copy())
        self.e.append(e.copy())
        self.mode.append(mode.copy())

    def drop(self) -> None:
        """Forget the last step: it could not be taken."""
        self.t.pop()
        for values in (self.x, self.w, self.e, self.mode):
            values.pop()

    def recorded(self, inside: StatesInside | None) -> Recorded:
        """All of it as arrays."""
        return Recorded(
            np.array(self.t),
            np.array(self.x),
            np.array(self.w),
            np.array(self.e),
            np.array(self.mode),
            inside,
        )


class Recorder(ABC):
    """A motion that moves step by step; `run` ends it and returns why.

    Keeps the `last` steps and global stick phases, or all; `dense`: what is inside steps too.
    """

    def __init__(self, *, rtol: float, dense: bool, last: int | None = None) -> None:
        self.rtol = rtol
        self.dense = dense
        self.record = Record(last)
        self.t = 0.0
        self.n_events = 0
        self.status = status_codes.OK  # why it ended
        self.d: deque[float | Floats] = deque(maxlen=last)

    # --- what a kind of motion must do -------------------------------------------------------

    @property
    @abstractmethod
    def mode(self) -> Ints:
        """Present modes of the blocks."""

    @abstractmethod
    def start_on_belt(self, d: Floats) -> None:
        """Start at the end of a global stick phase: there the first slip begins."""

    @abstractmethod
    def start(self, x: Floats, v: Floats) -> None:
        """Start from any state; a block at belt velocity rides if its force is in the limits."""

    @abstractmethod
    def keep(self) -> None:
        """Add the present state to the record."""

    @abstractmethod
    def _advance(self, cap: float) -> tuple[float, int]:
        """Take one step of at most `cap`, with the change of modes that ends it."""

    @abstractmethod
    def _slides_for_ever(self) -> bool:
        """Whether it can be shown that no block sticks again."""

    @abstractmethod
    def _inside(self) -> StatesInside:
        """How to evaluate the recorded steps."""

    # --- following ---------------------------------------------------------------------------

    def run(self, t_end: float, max_events: int, *, until_stick: bool) -> int:
        """Move until `t_end` or a limit, or the next global stick phase; return a status."""
        for _ in self.follow(t_end, max_events, until_stick=until_stick):
            pass
        return self.status

    def follow(self, t_end: float, max_events: int, *, until_stick: bool) -> Iterator[None]:
        """Move as `run` does and pause after each step, the start of which was kept last."""
        endless = math.isinf(t_end)
        for n, status in enumerate(self._steps(t_end)):
            self.status = status
            if status != status_codes.OK:
                self.record.drop()
                return
            if endless and self._slides_for_ever():
                self.status = status_codes.NEVER_SLIPPING
            elif endless and n >= STEPS_PER_EVENT * max_events:
                self.status = status_codes.TIME_LIMIT
            elif self.n_events >= max_events:
                self.status = status_codes.EVENT_LIMIT
            yield
            if self.status != status_codes.OK:
                return
            if until_stick and self.n_events > 0 and not self.mode.any():
                return

    def _steps(self, t_end: float) -> Iterator[int]:
        instant = 0
        while self.t < t_end:
            self.keep()
            left = t_end - self.t
            t, status = self._advance(min(LONGEST_STEP, left))
            self.t = t_end if t == left else self.t + t
            instant = instant + 1 if t == 0.0 else 0
            stuck = instant > MAX_INSTANT * self.mode.size
            yield status_codes.UNDECIDED if stuck and status == status_codes.OK else status

    def finish(self) -> Recorded:
        """Return the record, closed by the last state."""
        dense = self.dense and bool(self.record.t)
        self.keep()
        return self.record.recorded(self._inside() if dense else None)
