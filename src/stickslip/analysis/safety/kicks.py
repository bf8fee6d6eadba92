"""What kicks do: random ones after each step until a motion escapes, and the smallest of a block.

Derivations: docs/theory/safety.md.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, TypeAlias

import numpy as np

from stickslip.analysis.attractors.in_space.basins_nd import Estimate, binomial
from stickslip.analysis.attractors.in_space.fates import UNDECIDED
from stickslip.numerics.waiting import doing
from stickslip.numerics.zeros import halved
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats
    from stickslip.analysis.safety.surroundings import Surroundings

Distribution: TypeAlias = Literal["normal", "uniform"]

FEW: Final = 16  # points of the attractor where impulses are tried
HALVINGS: Final = 30  # of an impulse
SIZES: Final = (1e-3, 2.0)  # units of f_s1 / sqrt(k m): what a block's static limit can stop


@part
class Impulse(NamedTuple):
    """The smallest change of one velocity known that leads to another basin.

    Attributes
    ----------
    block : int
        From 1.
    by, error : float
        Change of its velocity as global stick ends, negative backward, and the width of its
        bracket; NaN if none of those tried led away.
    point : tuple of float
        The attractor's point where that is so.
    into : int
        Place of the other attractor; -1 undecided, -2 the motion leaves or does not come back.
    tested : int
        So many smaller ones, at points all over the attractor, were tried, and led back.
    """

    block: int
    by: float
    error: float
    point: tuple[float, ...]
    into: int
    tested: int


@part
class Escape(NamedTuple):
    """Escapes from a basin under a random kick after each step.

    Attributes
    ----------
    size : tuple of float
        Of the kicks, for each coordinate: standard deviation, or half the width.
    distribution : {"normal", "uniform"}
    mean : Estimate
        Mean steps until the orbit is in another basin; infinite if none escaped. The error
        of runs that all escaped is that of their mean; else escapes count as memoryless.
    escaped : Estimate
        Share of the runs that escaped within `within` steps.
    within, n_runs : int
    into : dict
        How many runs escaped into which basin.
    """

    size: tuple[float, ...]
    distribution: Distribution
    mean: Estimate
    escaped: Estimate
    within: int
    n_runs: int
    into: dict[int, int]


def escape(
    near: Surroundings,
    size: Floats,
    distribution: Distribution,
    within: int,
    n_runs: int,
    rng: np.random.Generator,
) -> Escape:
    """Follow kicked orbits from points of an attractor until they are in another basin."""
    draw = (
        rng.normal
        if distribution == "normal"
        else lambda _, half, shape: rng.uniform(-half, half, shape)
    )
    x = near.points[rng.integers(len(near.points), size=n_runs)]
    left, into, total, squares = 0, dict[int, int](), 0.0, 0.0
    for n in range(1, within + 1):
        doing(f"kicks: step {n} of at most {within}, {left} of {n_runs} runs escaped")
        x = near.step(x) + draw(0.0, size, x.shape)
        fate = near.fate(x)
        gone = (fate != near.k) & (fate != UNDECIDED)
        for k in fate[gone].tolist():
            into[k] = into.get(k, 0) + 1
        left += int(gone.sum())
        total, squares = total + n * gone.sum(), squares + n * n * gone.sum()
        x = x[~gone]
        if not len(x):
            break
    total += within * len(x)
    mean = total / left if left else math.inf
    if not left:
        error = math.nan
    elif len(x) or n_runs == 1:
        error = mean / math.sqrt(left)
    else:
        error = math.sqrt(max(squares / n_runs - mean**2, 0.0) / (n_runs - 1))
    sizes = tuple(size.tolist())
    return Escape(
        sizes, distribution, Estimate(mean, error), binomial(left, n_runs), within, n_runs, into
    )


def smallest_impulses(near: Surroundings, n_sizes: int) -> tuple[Impulse, ...]:
    """Try impulses of each velocity in both senses, the smallest first; none without velocities."""
    f: Any = near.f
    after = getattr(f, "after_impulse", None)
    if after is None or not n_sizes:
        return ()
    every = max(1, len(near.points) // FEW)
    points = near.points[::every][:FEW]
    sizes = np.geomspace(*SIZES, n_sizes)
    return tuple(
        _smallest(near, after, block, sense, points, sizes)
        for block in range(1, f.n_impulses + 1)
        for sense in (-1.0, 1.0)
    )


def _smallest(
    near: Surroundings, after: Any, block: int, sense: float, points: Floats, sizes: Floats
) -> Impulse:
    """Go through ascending sizes at all points; bisect below the first that leads away."""

    def fate(point: Floats, size: float) -> int:
        """Whose basin the motion lands in."""
        landed = after(point if len(point) > 1 else point[0], block, sense * size)
        return int(near.fate(np.reshape(landed, (1, -1)))[0])

    def bisected(point: Floats, low: float, high: float) -> tuple[float, float, Floats, int]:
        low, high = halved(lambda by: fate(point, by) == near.k, low, high, HALVINGS)
        return high, low, point, fate(point, high)

    tested, below = 0, 0.0
    for size in sizes.tolist():
        doing(f"change of velocity of block {block}: {sense * size:.3g} of up to {sizes[-1]:.3g}")
        away = [point for point in points if fate(point, size) not in (near.k, UNDECIDED)]
        tested += len(points) - len(away)
        if away:
            found = (bisected(point, below, size) for point in away)
            high, low, point, into = min(found, key=lambda each: each[0])
            at = tuple(point.tolist())
            return Impulse(block, sense * high, high - low, at, into, tested)
        below = size
    nowhere = (math.nan,) * points.shape[1]
    return Impulse(block, math.nan, math.nan, nowhere, UNDECIDED, tested)
