"""What goes into the event map's kernels besides a motion, and what comes out of them."""

# No class is part of a template: numba would look its type up slowly.

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.loop import Loop
from stickslip.mechanics.flow._lane_kernels import CoulombConstants
from stickslip.mechanics.flow.blocks.system import RowChanges, Rows, sparse_changes
from stickslip.mechanics.flow.system import Floats, Ints, Motion

# From this many events on a motion of two blocks is one that lasts: it may never return.
LONG = 256
# Numbers of a point that is a state of two blocks at an event: modes, events, relative velocities,
# forces in units of the limits.
STATE = 8


class Controls(NamedTuple):
    """Tolerance of the adaptive engine and the limits of a motion."""

    rtol: float
    max_events: int
    max_time: float


class Outputs(NamedTuple):
    """What a motion leaves, an entry for each start; of n > 2 blocks `value` is (m, n - 1).

    In kernels it is (m, steps, n - 1).
    """

    value: Floats
    derivative: Floats  # (m, columns), (m, n - 1, columns)
    duration: Floats
    n_events: NDArray[np.int64]
    label: NDArray[np.uint64]
    margin: Floats
    status: NDArray[np.int64]


UNTOLD = -1.0  # a margin that lanes leave to one motion at a time
START = ""  # what tangents go with, if not with a parameter: no parameter has this name


class Scratch(NamedTuple):
    """Arrays of one thread."""

    motion: Any  # Motion or BlockMotion, as the next four
    long_motion: Any  # twin with the columns of a loop
    light: Any  # twins without the tangents of the start
    long_light: Any
    saved: Any
    loop: Loop
    work: Any  # of the engine
    section: Any  # Section; None of two undamped equal blocks
    point: Floats  # (numbers of a point,)


class Pools(NamedTuple):
    """Three pools of motions (`flow.lanes.layout`), and arrays for the one at an event."""

    x: Floats  # (3, KEPT): numbers of the motions
    numbers: Floats  # (3, NUMBERS * PLACES): those of their models beside them
    laws: Floats  # (3, 2, parameters * PLACES): and those of the laws, the first block's first
    models: NDArray[np.int64]  # (3, PLACES): whose numbers are there, -1 for none
    taken: Floats  # (SIZE,): the step taken last, of one of the pools
    tags: NDArray[np.int64]  # (3, places, 4), as labels: `Tags`
    labels: NDArray[np.uint64]
    counts: NDArray[np.int64]  # motions in each pool
    flagged: NDArray[np.int64]  # lanes with an event
    rows: NDArray[np.int64]  # that may go on
    motion: Motion
    signal: Floats
    reciprocals: Floats  # 1 / k


class Models(NamedTuple):
    """Models whose motions share pools, an entry each, and which of them each orbit belongs to."""

    laws: Floats  # (models, 2, columns): parameter rows of the scalar engine
    rows: Floats  # (models, 2, parameters): and of `friction.series`
    numbers: Floats  # (models, 3, NUMBERS): of the contacts, in the order of each pool
    of: Ints


class Asked(NamedTuple):
    """What the scalar engine is asked: which motions of orbits never return, an entry each."""

    step: Ints  # of the orbit, from 0 on; -1: not asked yet
    state: Floats  # (orbits, STATE): from which it goes on


class Tags(NamedTuple):
    """What a motion in a pool is known by: its row, events so far, modes, last event, label."""

    row: int
    n_events: int
    code: int
    before: int
    label: np.uint64


class Clock(NamedTuple):
    """What a motion in a pool adds up: steps, time of its earlier phases, smallest margin."""

    steps: float
    duration: float
    margin: float
    last_term: float  # log2 of what the last terms of a step may be


class Mark(NamedTuple):
    """A state to which a motion may come back: of the block without an event, and the modes."""

    w: float
    e: float
    modes: float
    turn: float  # how far from the mark before it


class SectionChanges(NamedTuple):
    """Derivatives of a section and its points, an entry for each direction."""

    point: Floats  # (directions, numbers of a point)
    into: Floats  # (directions, n, waves + numbers + 1)
    out: RowChanges
    period: Floats
    frequency: Floats  # (directions, harmonics)
    phase: Floats


class Section(NamedTuple):
    """Where motions start and end: ``(y, w) = into (waves, point, 1)``; global stick, if -1."""

    contact: int
    mode: int  # of its slip, which a release begins and a landing ends
    released: bool  # else it lands
    period: float  # of the phase that is a point's first number; 0 for none
    into: Floats  # (n, waves + numbers + 1)
    out: Rows  # the point at a state z
    changes: SectionChanges


def still(count: int, n_point: int, into: Floats, n_harmonics: int) -> SectionChanges:
    """Return changes of a section that does not change itself, only with its point."""
    none = np.zeros((count, n_harmonics))
    return SectionChanges(
        point=np.eye(count, n_point),
        into=np.zeros((count, *into.shape)),
        out=sparse_changes([None] * count, n_point, [False] * count),
        period=np.zeros(count),
        frequency=none,
        phase=none,
    )


def global_stick(n: int) -> Section:
    """Global stick of n + 1 blocks, and differences as the point; changes in their directions."""
    into = np.zeros((0, 0))
    pairs = np.arange(n)[:, None] + np.array([0, 1])
    out = Rows(2 * np.arange(n + 1), pairs.ravel(), np.tile([-1.0, 1.0], n), np.zeros(n))
    return Section(-1, 0, False, 0.0, into, out, still(max(n, 1), n, into, 0))


def new_outputs(shape: tuple[int, ...], n_columns: int) -> Outputs:
    """Arrays for what the motions from points of that shape leave."""
    n = shape[0]
    value, derivative, margin = np.empty(shape), np.empty((*shape, n_columns)), np.empty(n)
    value.fill(np.nan)
    derivative.fill(np.nan)
    margin.fill(np.inf)
    duration, n_events, status = np.zeros(n), np.zeros(n, np.int64), np.zeros(n, np.int64)
    return Outputs(value, derivative, duration, n_events, np.zeros(n, np.uint64), margin, status)


class ModelTable(NamedTuple):
    """Models of two blocks, one entry each, and which starting point belongs to which."""

    alpha: Floats
    beta: Floats
    V: Floats
    laws: Floats  # (rows, 2, columns): parameter rows
    law_row: Ints
    of_start: Ints  # the model of each starting point


class Followed(NamedTuple):
    """What is kept of each orbit besides the verdict."""

    status: NDArray[np.int8]  # OK, or why the last motion has no value
    steps: NDArray[np.int64]  # maps applied, the transient included
    tail: Floats  # (m, kept): last points
    mean_events: Floats  # of a step after the transient, as the rest
    most_events: Ints
    mean_duration: Floats


class Batch(NamedTuple):
    """Orbits that are followed side by side, a slot for each, and scratch of `_lane_kernels`."""

    rows: Floats  # (numbers of a constants, slots)
    x: Floats
    orbit: Ints  # number of the orbit in the slot
    value: Floats  # of the next step, as slope
    slope: Floats
    point: Floats  # (slots, n + 1), paths as label and log_slope (slots, n)
    label: NDArray[np.uint64]
    log_slope: Floats
    streams: Floats
    lists: NDArray[np.uint64]


def new_batch(slots: int, n: int, streams: Floats, lists: NDArray[np.uint64]) -> Batch:
    """Arrays for `slots` orbits whose last n steps are recorded."""
    return Batch(
        np.zeros((len(CoulombConstants._fields), slots)),
        *(np.zeros(slots), np.zeros(slots, dtype=np.int64), np.zeros(slots), np.zeros(slots)),
        *(np.zeros((slots, n + 1)), np.zeros((slots, n), dtype=np.uint64), np.zeros((slots, n))),
        *(streams, lists),
    )


def new_followed(m: int, tail: int) -> Followed:
    """Arrays for m orbits."""
    return Followed(
        np.zeros(m, dtype=np.int8),
        np.zeros(m, dtype=np.int64),
        np.full((m, tail), np.nan),
        np.full(m, np.nan),
        np.zeros(m, dtype=np.int64),
        np.full(m, np.nan),
    )
