"""Where many points of R^n end: cells around known attractors, and orbits that stay in them."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.maps.map import kernels_of
from stickslip.analysis.maps.protocol import SAME, Floats, Integers, MapND, reduced, sample, turns
from stickslip.analysis.scales import HALVINGS, IN_A_ROW
from stickslip.analysis.work import Work
from stickslip.status import GIVEN_UP

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.attractors.attractor import AttractorListND

    Labels = NDArray[np.int16]

CORNERS: Final = 6  # dimension up to which all corners about a point are marked
UNDECIDED, LEFT, UNFOLLOWED = -1, -2, -3
BELOW: Final = 1.0 - SAME  # the end of a period belongs to its last cell
MOST_CELLS: Final = 1 << 24  # of an array that holds all
MOST_FOLLOWED: Final = int(np.iinfo(np.int32).max)  # steps of a start
TYPICAL: Final = 64  # steps until a start is decided
TILE: Final = 16384  # points that a thread follows in a row


@dataclass(frozen=True)
class Cells:
    """Cells of a grid that hold attractors, each with its label."""

    box: Floats
    per_cell: Floats
    counts: Integers
    keys: Integers  # ascending
    labels: Integers
    size: float  # of a cell, in widths

    def at(self, x: Floats) -> Integers:
        """Tell the label of each point (m, n); -1 where no attractor is, or for NaN."""
        held = ((x >= self.box[:, 0]) & (x <= self.box[:, 1])).all(axis=1)
        found = np.full(len(x), UNDECIDED)
        key = _key(x[held], self.box, self.per_cell, self.counts)
        slot = np.minimum(np.searchsorted(self.keys, key), len(self.keys) - 1)
        found[held] = np.where(self.keys[slot] == key, self.labels[slot], UNDECIDED)
        return found

    def table(self) -> NDArray[np.int16] | None:
        """Return the labels of all cells, attractors' and others; None of too many."""
        if float(np.prod(self.counts.astype(float))) >= MOST_CELLS:
            return None
        labels = np.full(int(self.counts.prod()), UNDECIDED, dtype=np.int16)
        labels[self.keys] = self.labels
        return labels


def _key(x: Floats, box: Floats, per_cell: Floats, counts: Integers) -> Integers:
    place = np.floor((x - box[:, 0]) * per_cell).astype(np.int64)
    key = place[:, 0]
    with np.errstate(over="ignore"):  # modulo 2^64 is meant
        for k in range(1, x.shape[1]):
            key = key * counts[k] + place[:, k]
    return np.asarray(key)


def cells_of(f: MapND, found: AttractorListND) -> Cells | None:
    """Mark the cells about attractors; fine enough to keep them apart; None if there is none."""
    if not len(found):
        return None
    size = found.resolution
    for _ in range(HALVINGS):
        made, apart = _marked(f, found, size)
        if apart:
            break
        size *= 0.5
    return made


def _marked(f: MapND, found: AttractorListND, size: float) -> tuple[Cells, bool]:
    step = size * found.widths
    n = len(step)
    points = np.concatenate([attractor.points for attractor in found])
    domain = getattr(f, "domain", None)
    low, high = np.asarray((-np.inf, np.inf) if domain is None else domain, dtype=np.float64).T
    ends = np.array([points.min(axis=0) - step, points.max(axis=0) + step])
    box = np.clip(ends, low, high).T.copy()
    whole = turns(f)
    angle = np.isfinite(whole[:, 1])
    box[angle] = whole[angle]
    counts = np.maximum(np.floor(np.ptp(box, axis=1) / step), 1.0).astype(np.int64) + 1
    per_cell = np.where(angle, counts * BELOW, counts - 1) / np.ptp(box, axis=1)
    sides = np.concatenate([-0.5 * np.eye(n), 0.5 * np.eye(n)])
    signs = np.array(list(itertools.product((-0.5, 0.5), repeat=n))) if n <= CORNERS else sides
    keys, labels = [], []
    for k, attractor in enumerate(found):
        about = (attractor.points[:, None] + signs * step).reshape(-1, n)
        about = np.clip(reduced(f, np.concatenate([attractor.points, about])), *box.T)
        keys.append(np.unique(_key(about, box, per_cell, counts)))
        labels.append(np.full(len(keys[-1]), k))
    joined, owners = np.concatenate(keys), np.concatenate(labels)
    order = np.argsort(joined, kind="stable")
    joined, owners = joined[order], owners[order]
    made = Cells(box, per_cell, counts, joined, owners, size)
    return made, bool((np.diff(joined) > 0).all())


@dataclass(frozen=True)
class Grid:
    """Points of a grid in a section, the last axis fastest: made in rows when needed."""

    axes: tuple[Floats, ...]
    coordinates: tuple[int, ...]
    point: Floats

    @property
    def inner(self) -> int:
        """Points of a row: those along the last axis, if there are others."""
        return len(self.axes[-1]) if len(self.axes) > 1 else 1

    def __len__(self) -> int:
        """Count the points."""
        return math.prod(map(len, self.axes))

    def __getitem__(self, number: Integers) -> Floats:
        """Return points by their numbers, (m, n)."""
        x = np.tile(self.point, (len(number), 1))
        places = np.unravel_index(number, tuple(map(len, self.axes)))
        for k, values, place in zip(self.coordinates, self.axes, places, strict=True):
            x[:, k] = values[place]
        return x

    def rows(self, start: int, stop: int) -> Floats:
        """Return the points of some rows, (m, n)."""
        first = self[self.inner * np.arange(start, stop)]
        x = np.repeat(first, self.inner, axis=0)
        if self.inner > 1:
            x.reshape(len(first), self.inner, -1)[..., self.coordinates[-1]] = self.axes[-1]
        return x


def fates(
    f: MapND,
    x: Floats | Grid,
    cells: Cells | None,
    max_steps: int,
    work: Work | None = None,
    hits: int = IN_A_ROW,
) -> tuple[Labels, NDArray[np.int32]]:
    """Return the label of the attractor that each point (m, n) comes to, and after how many steps.

    -2 for a point that leaves, -1 for one that did neither within `max_steps`, -3 if interrupted.
    """
    work = Work() if work is None else work
    compiled = kernels_of(f, TYPICAL, TYPICAL * len(x) * f.dimension)
    labels = None if compiled is None or cells is None else cells.table()
    fate, steps = np.full(len(x), UNFOLLOWED, dtype=np.int16), np.zeros(len(x), dtype=np.int32)
    if labels is None or cells is None:
        points = x.rows(0, len(x) // x.inner) if isinstance(x, Grid) else x
        with work.until_interrupted():
            _fates_by_steps(f, points, cells, (hits, max_steps, fate, steps), work)
        return fate, steps
    from stickslip.numerics.targets import available_threads, launch  # numba is there by now

    parameters, box = f.numbers  # type: ignore[attr-defined]
    table = (cells.box, cells.per_cell, cells.counts, labels)

    inner = x.inner if isinstance(x, Grid) else 1
    many, count = max(1, TILE // inner), work.steps(len(x))

    def task(start: int, stop: int) -> None:
        for first in range(start, stop, many):  # so few stay in the processor's cache
            last = min(first + many, stop)
            rows = x.rows(first, last) if isinstance(x, Grid) else x[first:last]
            part = slice(first * inner, last * inner)
            limits = (hits, max_steps, fate[part], steps[part])
            compiled.fates(np.ascontiguousarray(rows), parameters, box, *table, *limits)
            count(len(rows))

    with work.until_interrupted():
        launch(task, len(x) // inner, available_threads(), many)
    return fate, steps


def _fates_by_steps(
    f: MapND,
    x: Floats,
    cells: Cells | None,
    limits: tuple[int, int, Labels, NDArray[np.int32]],
    work: Work,
) -> None:
    hits, max_steps, fate, steps = limits
    last, run = np.full(len(x), UNDECIDED), np.zeros(len(x), dtype=np.int64)
    active, before = np.arange(len(x)), x
    for k in range(max_steps + 1):
        gone = ~f.contains(x)
        label = np.full(len(x), UNDECIDED) if cells is None else cells.at(x)
        run = np.where(label == last, run + 1, 1)
        last = label
        came = (label != UNDECIDED) & (run >= hits) & ~gone
        done = came | gone
        if gone.any():  # or motions are not followed to an end there
            lost = np.isin(sample(f, before[gone]).status, GIVEN_UP)
            label[gone] = np.where(lost, UNDECIDED, LEFT)
        fate[active[done]], steps[active[done]] = label[done], k
        active, x, run, last = active[~done], x[~done], run[~done], last[~done]
        if not active.size or k == max_steps:
            break
        work.tell(max(1 - len(active) / len(fate), k / max_steps))
        before, x = x, sample_values(f, x)
    fate[active], steps[active] = UNDECIDED, max_steps


def sample_values(f: Any, x: Floats) -> Floats:
    """Values alone at points of the domain."""
    return np.asarray(f(x)) if callable(f) else sample(f, x).value
