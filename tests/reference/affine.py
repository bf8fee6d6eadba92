"""Orbits of piecewise-affine maps by brute force: every word, one linear equation each."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from stickslip.analysis.maps.piecewise_map import PiecewiseMap


@dataclass(frozen=True)
class Affine:
    """x -> slopes[i] x + offsets[i] on [edges[i], edges[i + 1])."""

    edges: tuple[float, ...]
    slopes: tuple[float, ...]
    offsets: tuple[float, ...]

    def as_map(self):
        slopes, offsets = np.array(self.slopes), np.array(self.offsets)
        inner = np.array(self.edges[1:-1])

        def branch(x):
            return np.searchsorted(inner, x, side="right")

        return PiecewiseMap(
            lambda x: slopes[branch(x)] * x + offsets[branch(x)],
            (self.edges[0], self.edges[-1]),
            derivative=lambda x: slopes[branch(x)],
            breakpoints=inner,
        )

    def limits(self, i):
        """Values left and right of inner edge i, counted from 1."""
        x = self.edges[i]
        return tuple(self.slopes[k] * x + self.offsets[k] for k in (i - 1, i))

    def along(self, word):
        """Slope and offset of the composition."""
        a, b = 1.0, 0.0
        for i in word:
            a, b = self.slopes[i] * a, self.slopes[i] * b + self.offsets[i]
        return a, b

    def path(self, x, word):
        points = [x]
        for i in word[:-1]:
            points.append(self.slopes[i] * points[-1] + self.offsets[i])
        return points

    def room(self, points, word):
        """Smallest distance of the points from the ends of their branches, < 0 if outside."""
        return min(
            (
                min(x - self.edges[i], self.edges[i + 1] - x)
                for x, i in zip(points, word, strict=False)
            ),
            default=np.inf,
        )


def periodic_points(affine, p, border):
    """Orbits of minimal period p as sorted tuples of points, and whether any is on a border."""
    orbits, doubtful = {}, False
    for word in product(range(len(affine.slopes)), repeat=p):
        if any(word == word[q:] + word[:q] for q in range(1, p)):
            continue
        a, b = affine.along(word)
        if abs(a - 1) < border:
            doubtful = True
            continue
        points = affine.path(b / (1 - a), word)
        room = affine.room(points, word)
        doubtful |= abs(room) < border
        if room > 0:
            start = int(np.argmin(points))
            orbits[min(word[q:] + word[:q] for q in range(p))] = (
                points[start:] + points[:start],
                a,
            )
    return sorted(orbits.values()), doubtful


def jump_orbits(affine, p, border):
    """Infinitely unstable orbits of period p as (jump, y), and whether any is on a border."""
    found, doubtful = [], False
    for i in range(1, len(affine.slopes)):
        low, high = sorted(affine.limits(i))
        for word in product(range(len(affine.slopes)), repeat=p - 1):
            a, b = affine.along(word)
            y = (affine.edges[i] - b) / a
            points = affine.path(y, word)
            room = min(affine.room(points, word), y - low, high - y)
            doubtful |= abs(room) < border
            if room > 0:
                found.append((affine.edges[i], y))
    return sorted(found), doubtful
