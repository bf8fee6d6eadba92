"""Slips of a motion one after the other, in memory that does not grow with it."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from stickslip.checks import whole_number
from stickslip.mechanics.flow.engine import tolerance
from stickslip.mechanics.flow.slip import Slip, SlipTracker
from stickslip.mechanics.flow.trajectory import (
    State,
    end_time,
    recorder_for,
    start,
)
from stickslip.mechanics.model.arguments import Model
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.mechanics.flow.engine import EngineName
    from stickslip.mechanics.flow.recorder import Recorder


class SlipStream(Iterator[Slip]):
    """Slips as they end; `slips` makes it.

    Attributes
    ----------
    state : State
        How far the motion has been followed: ``simulate`` or `slips` goes on from there.
    status : int
        `stickslip.status`: why the slips ended; OK before, and where `t_end` was reached.
    """

    def __init__(self, model: Model, recorder: Recorder, t_end: float, max_events: int) -> None:
        self.model = model
        self._recorder = recorder
        recorder.keep()
        self._slips = self._follow(t_end, max_events)

    @property
    def status(self) -> int:
        """Why the slips ended."""
        return self._recorder.status

    @property
    def state(self) -> State:
        """Start of the last step taken; when the slips have ended, the end of it."""
        x, v, _, _ = self._recorder.last
        return State(self._recorder.record[-1].t, x, v)

    def __next__(self) -> Slip:
        """Follow the motion to the end of its next slip."""
        return next(self._slips)

    def _follow(self, t_end: float, max_events: int) -> Iterator[Slip]:
        recorder, record = self._recorder, self._recorder.record
        plant = self.model.plant
        tracker = SlipTracker(plant, recorder.last[2])

        def seen() -> Iterator[Slip]:
            t, mode = record[-1].t, record[-1].mode
            return tracker.see(t, plant.travel(recorder.last[0], t).tolist(), mode)

        for _ in recorder.follow(t_end, max_events, until_stick=False):
            yield from seen()
        recorder.close()
        yield from seen()


@suggests
def slips(
    model: Model,
    x: ArrayLike | None = None,
    v: ArrayLike | None = None,
    *,
    d: ArrayLike | None = None,
    t_end: float | None = None,
    rtol: float = 1e-15,
    max_events: int | None = None,
    engine: EngineName = "auto",
) -> SlipStream:
    """Follow a motion and tell its slips, one by one, without keeping the motion.

    Blocks that are coupled and slip at times that overlap take part in the same slip; a chain may
    have several at a time. Memory does not grow with the length of the motion.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    x, v, d, rtol, engine
        As in `simulate`.
    t_end : float, optional
        Time to follow, units of sqrt(m / k).
    max_events : int, optional
        Changes of mode to follow, with the status EVENT_LIMIT in the end.

    Returns
    -------
    SlipStream
        An iterator of `Slip`, in the order of their ends. Slips that had begun before the start
        are left out, and so are those that go on in the end. One of blocks that are let go at
        belt velocity, beyond their limits, begins at the start.

    Raises
    ------
    ValueError
        As `simulate`; neither `t_end` nor `max_events` is given.

    Examples
    --------
    >>> import stickslip as ss
    >>> chain = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=ss.Coulomb(mu=0.3))
    >>> slips = ss.slips(chain, *chain.sample_state(1), t_end=400)
    >>> sum(slip.moment for slip in slips if len(slip.blocks) == 3) > 0
    True
    """
    if t_end is None and max_events is None:
        raise ValueError("give an end: t_end= a time, max_events= changes of mode, or both")
    end = math.inf if t_end is None else end_time(t_end)
    most = (
        sys.maxsize
        if max_events is None
        else whole_number("max_events", max_events, what="changes of mode")
    )
    recorder = recorder_for(model, engine, rtol=tolerance(rtol), dense=False, last=1)
    start(recorder, model, x, v, d)
    return SlipStream(model, recorder, end, most)
