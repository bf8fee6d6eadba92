"""Regions of releases that no motion leaves: motions that enter one never return (rule 6)."""

# A release: one block leaves the belt backward while the other slips backward. Two numbers tell
# it, the other block's w and e, and so they do the next: turns are a map of the plane. A polygon
# is a trap if turns are smooth in it and take its border inside: see docs/theory/flow.md.

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, lru_cache, partial
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from stickslip.mechanics.eventmap._trap_kernels import cut_down
from stickslip.mechanics.eventmap.backend import NO_TRAPS, ScalarBackend
from stickslip.mechanics.eventmap.records import LONG, Controls, new_outputs
from stickslip.mechanics.flow.engine import engine_for
from stickslip.mechanics.flow.system import BACKWARD, STICK
from stickslip.numerics.arrays import GOLDEN
from stickslip.status import EVENT_LIMIT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats

# Starts that are tried for motions that stay, and motions that are tried for traps.
STARTS, TRIED = 24, 2
# Events after which a motion counts as one that stays: half of LONG, while it comes from afar.
STAYS = 128
# Turns by which a motion shows where it stays.
TURNS = 96
# Rings and rays on which turns are taken, places along each ray, corners of a trap.
RINGS, RAYS, PLACES, CORNERS = 14, 64, 64, 192
# How far from the centre regions are looked for, in units of the motion's farthest turn: farther
# they are met sooner, nearer turns are smooth in more of them.
ROOMS = (1.3, 1.15, 1.6, 2.0)
# Rays beside each other within which the rings change smoothly.
BESIDE = 2
# By which share of itself a turn has to shrink a trap: the first that one is found with.
SHRINKS = (0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
# Times that a region is cut down to what turns into it, to this share of itself.
CUTS, SETTLED = 4000, 1e-4
# Slope of a trap's border, in turns of 45 degrees.
STEEP = 2.0
# Part of the way to its border by which a trap may be wrong, and halvings of edges to find out.
SAFE, HALVINGS = 0.5, 4


@lru_cache(maxsize=64)
def traps_of(model: TwoBlock, name: str, rtol: float) -> Floats:
    """Return rows of the released block and corners, of regions that no motion leaves."""
    engine = engine_for(model, "exact" if name == "exact" else "adaptive")
    backend = ScalarBackend(model, engine, Controls(rtol, LONG, math.inf), threads=1)
    low, high = model.domain
    rows, tried = NO_TRAPS, 0
    for k in range(STARTS):
        found = _staying(backend, low + (high - low) * ((k + 0.5) * GOLDEN % 1.0), rows)
        if found is None:
            continue
        block, place = found
        way = turned(backend, block, place[None], TURNS, rows).place[0]
        if not np.isfinite(way).all():
            continue
        corners = trap(way, partial(_next, backend, block))
        if corners is not None:
            row = np.array([[block, *corners.ravel()]])
            rows = np.concatenate([rows, row]) if rows.size else row
        tried += 1
        if tried == TRIED:
            break
    return rows


def _staying(backend: ScalarBackend, d: float, traps: Floats) -> tuple[int, Floats] | None:
    """Return the last release of one block alone, if a motion goes on: which, w, e of the other."""
    modes = np.zeros((STAYS + 1, 2), dtype=np.int8)
    most = STAYS
    while True:
        outputs = backend.room(1)
        backend.task(np.array([[d]]), outputs, most, section=traps, itinerary=modes)(0, 1)
        if outputs.status[0] != EVENT_LIMIT:
            return None
        if most < STAYS:
            motion = backend.scratch(backend.no_directions, traps).motion
            block = int(motion.event[1] != 0)
            return block, np.array([motion.w[1 - block], motion.e[1 - block]])
        both = (modes[1:STAYS] == BACKWARD).all(axis=1)
        alone = (np.sort(modes[: STAYS - 1], axis=1) == [BACKWARD, STICK]).all(axis=1)
        (releases,) = (both & alone).nonzero()
        if releases.size == 0:
            return None
        most = int(releases[-1]) + 1


def turned(
    backend: ScalarBackend, block: int, places: Floats, n: int = 1, traps: Floats = NO_TRAPS
) -> Turned:
    """Go on from releases of a block to its next n: places (m, n, 2), the rest of the last."""
    points = np.insert(places, 0, block, axis=1)
    outputs = new_outputs(points.shape, 0)
    outputs = outputs._replace(value=np.full((len(points), n, 3), np.nan))
    backend.task(points, outputs, LONG, watch=True, section=traps)(0, len(points))
    return Turned(outputs.value[:, :, 1:], outputs.margin, outputs.label)


def _next(backend: ScalarBackend, block: int, places: Floats) -> Turned:
    found = turned(backend, block, places)
    return found._replace(place=found.place[:, 0])


class Turned(NamedTuple):
    """Releases one turn after others."""

    place: Floats  # (m, 2), NaN where there is none
    margin: Floats
    label: NDArray[np.uint64]

    @property
    def is_one(self) -> NDArray[np.bool_]:
        """Which turns came to an end, by the way of the first."""
        found: NDArray[np.bool_] = np.isfinite(self.place[:, 0]) & (self.label == self.label[0])
        return found


Turn: TypeAlias = Callable[["Floats"], Turned]


def trap(way: Floats, turn: Turn) -> Floats | None:
    """Return the corners (CORNERS, 2) of a trap around releases that follow each other, if any."""
    for room in ROOMS:
        rings = _rings(way, turn, room)
        corners = None if rings is None else _within(rings, turn)
        if corners is not None:
            return corners
    return None


def _within(rings: _Rings, turn: Turn) -> Floats | None:
    """Return the corners of a trap within rings, if any."""
    whole = rings.reach_of_corners()
    if not whole.min() > 0.0:
        return None
    gauge = _Gauge(rings.image_at(PLACES))
    for shrink in SHRINKS:
        reach = _kept(gauge, whole, 1.0 - shrink)
        if reach is not None and _holds(reach, rings, turn):
            return rings.centre + (reach[:, None] * _directions(CORNERS)) @ rings.out.T
    return None


class _Rings(NamedTuple):
    """Turns from rings around a centre, in coordinates in which the motion's turns are round."""

    centre: Floats
    out: Floats  # (2, 2): from there to w and e
    into: Floats
    reach: Floats  # (RAYS,): of the last ring
    image: Floats  # (RINGS + 1, RAYS, 2): of the centre, then of the rings
    margin: Floats

    def turned(self, turn: Turn, places: Floats) -> tuple[Floats, Turned]:
        """Turn places, the centre before them; return where they come in these coordinates."""
        points = np.vstack([np.zeros(2), places]) @ self.out.T + self.centre
        found = turn(points)
        return (found.place - self.centre) @ self.into.T, found

    def reach_of_corners(self) -> Floats:
        """How far rings are smooth towards each corner: no clearance halves from one to another."""
        m = self.margin
        cell = np.stack([m[:-1], m[1:], np.roll(m[:-1], -1, 1), np.roll(m[1:], -1, 1)])
        smooth = 2.0 * cell.min(axis=0) > cell.max(axis=0)
        smooth &= np.roll(smooth, 1, axis=1)
        last = np.where(smooth.all(axis=0), RINGS, np.argmin(smooth, axis=0))
        share = _ring_places()[last]
        shares = np.repeat(np.minimum(share, np.roll(share, -1)), CORNERS // RAYS)
        reach: Floats = shares * (_between_rays() @ self.reach)
        return reach

    def image_at(self, n: int) -> Floats:
        """Images (n, CORNERS, 2) of as many equal shares of the reach."""
        found: Floats = _between_rays() @ np.tensordot(_between_rings(n), self.image, 1)
        return found


def _rings(way: Floats, turn: Turn, room: float) -> _Rings | None:
    """Take turns around the centre of a motion, as far as they all go the same way."""
    centre = _fixed_point(way[2 * len(way) // 3 :], turn)
    size, axes = np.linalg.eigh(np.cov((way - centre).T, bias=True) + 1e-300 * np.eye(2))
    size = np.sqrt(np.maximum(size, 0.01 * size.max()))
    rings = _Rings(centre, axes * size, (axes / size).T, *np.zeros((3, 0)))
    farthest = np.hypot(*((way - centre) @ rings.into.T).T).max()
    rays = _directions(RAYS)
    near, far = np.zeros(RAYS), np.full(RAYS, room * farthest)
    for k in range(6):
        middle = far if k == 0 else 0.5 * (near + far)
        same = rings.turned(turn, middle[:, None] * rays)[1].is_one[1:]
        near, far = np.where(same, middle, near), np.where(same, far, middle)
    beside = np.arange(-BESIDE, BESIDE + 1)
    lowest = np.min([np.roll(near, k) for k in beside], axis=0)
    weights = 1.0 + np.cos(math.pi * beside / (BESIDE + 1))
    reach = sum(w * np.roll(lowest, k) for w, k in zip(weights, beside, strict=True))
    reach /= weights.sum()
    if not reach.min() > 0.0:
        return None
    places = (_ring_places()[1:, None, None] * reach[:, None] * rays).reshape(-1, 2)
    image, found = rings.turned(turn, places)
    if not found.is_one.all():
        return None

    def rows(values: Floats) -> Floats:
        first = np.broadcast_to(values[:1, None], (1, RAYS, *values.shape[1:]))
        return np.concatenate([first, values[1:].reshape(RINGS, RAYS, *values.shape[1:])])

    return rings._replace(reach=reach, image=rows(image), margin=rows(found.margin))


def _fixed_point(late: Floats, turn: Turn) -> Floats:
    """Point that turns into itself, near where a motion stays; else the middle of its releases."""
    middle = late.mean(axis=0)
    step = 1e-5 * np.maximum(np.ptp(late, axis=0), 1e-3)
    point = middle
    for _ in range(8):
        first, *beside = turn(point + np.vstack([np.zeros(2), np.diag(step)])).place
        slope = (np.array(beside) - first).T / step
        if not np.isfinite(slope).all() or np.linalg.det(np.eye(2) - slope) == 0.0:
            return middle
        point = point + np.linalg.solve(np.eye(2) - slope, first - point)
    size = np.ptp(late, axis=0)
    return point if (np.abs(point - middle) <= size).all() else middle


def _kept(gauge: _Gauge, whole: Floats, share: float) -> Floats | None:
    """Return the reach of what turns into that share of itself, cut out of a whole; None: nothing.

    `gauge`: of places along the ray of each corner.
    """
    reach, most = whole.copy(), 1.0 + STEEP * 2.0 * math.pi / CORNERS
    how = share, most, SETTLED, CUTS, whole, reach, np.empty((2, CORNERS))
    return reach if cut_down(gauge.first, gauge.second, gauge.sector, *how) else None


class _Gauge:
    """By which factor a polygon around 0 grows or shrinks to reach each of some points."""

    def __init__(self, points: Floats) -> None:
        step = 2.0 * math.pi / CORNERS
        turned = np.arctan2(points[..., 1], points[..., 0]) % (2.0 * math.pi)
        self.sector = (turned / step).astype(int) % CORNERS
        past = turned - self.sector * step
        size = np.hypot(points[..., 0], points[..., 1]) / math.sin(step)
        self.first, self.second = size * np.sin(step - past), size * np.sin(past)

    def within(self, reach: Floats) -> Floats:
        """Gauge of the points for a polygon whose corners are so far from 0."""
        near = 1.0 / reach
        found: Floats = (
            self.first * near[self.sector] + self.second * np.roll(near, -1)[self.sector]
        )
        return found


def _holds(reach: Floats, rings: _Rings, turn: Turn) -> bool:
    """Whether turns take the border of a polygon inside, and keep orientation within."""
    first = reach[:, None] * _directions(CORNERS)
    last = np.roll(first, -1, axis=0)
    nearest = (_cross(first, last) / np.hypot(*(last - first).T)).min()
    corners, found = rings.turned(turn, first)
    if not found.is_one.all():
        return False
    image = corners[1:], np.roll(corners[1:], -1, axis=0)
    for _ in range(HALVINGS):
        middle = 0.5 * (first + last)
        between, found = rings.turned(turn, middle)
        if not found.is_one.all():
            return False
        between = between[1:]
        # The image of an edge bends off its chord by about as much as in the middle.
        bend = np.hypot(*(between - 0.5 * (image[0] + image[1])).T)
        most = np.max([_Gauge(x).within(reach) for x in (*image, between)], axis=0)
        (open_,) = (~(most + bend / (SAFE * nearest) < 1.0)).nonzero()
        if open_.size == 0 or not (most < 1.0).all():
            break
        (first, last), image = (
            (np.vstack([a[open_], c[open_]]), np.vstack([c[open_], b[open_]]))
            for a, c, b in ((first, middle, last), (image[0], between, image[1]))
        )
    if open_.size > 0:
        return False
    # Orientation, on the rings that reach inside.
    along, around = np.diff(rings.image, axis=0), np.roll(rings.image, -1, 1) - rings.image
    turns = _cross(along, around[1:])
    inside = _ring_places()[:-1, None] * rings.reach <= reach[:: CORNERS // RAYS]
    return bool((turns[inside] > 0.0).all() or (turns[inside] < 0.0).all())


def _cross(one: Floats, other: Floats) -> Floats:
    found: Floats = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return found


@cache
def _directions(n: int) -> Floats:
    angle = 2.0 * math.pi * np.arange(n) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


@cache
def _ring_places() -> Floats:
    """Of the centre and all rings: dense at both ends, where polynomials through them err most."""
    return 0.5 - 0.5 * np.cos(math.pi * np.arange(RINGS + 1) / RINGS)


@cache
def _between_rings(n: int) -> Floats:
    """Values at n equal steps from those on the rings: Lagrange's polynomials."""
    nodes, x = _ring_places(), np.arange(1, n + 1) / n
    apart = nodes[:, None] - nodes + np.eye(RINGS + 1)
    powers = np.stack(
        [np.prod(np.delete(x[:, None] - nodes, k, axis=1), axis=1) for k in range(RINGS + 1)], 1
    )
    return powers / np.prod(apart, axis=1)


@cache
def _between_rays() -> Floats:
    """Values at all corners from those on the rays: trigonometric polynomials."""
    parts = np.fft.rfft(np.eye(RAYS), axis=0)
    parts[-1] *= 0.5  # the highest is shared by two
    found: Floats = np.fft.irfft(parts, CORNERS, axis=0) * (CORNERS / RAYS)
    return found
