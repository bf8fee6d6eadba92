"""Basins proven: cells of the domain, each of which the map takes into what is proven already.

Docs: proofs, basins.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from math import ceil, floor
from typing import Any, Final, TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray

from stickslip.analysis.attractors.bands import merged
from stickslip.proofs.jet import outward
from stickslip.proofs.power import FORKS, Region, follow, step
from stickslip.proofs.system import decimal
from stickslip.proofs.verify.words import MOST_CELLS
from stickslip.proofs.wave import Undecided

Whole: TypeAlias = NDArray[np.int64]
Cells: TypeAlias = NDArray[np.int64]  # rows of two ends, in units

PLACES: Final = 12  # of the ends of cells
UNIT: Final = Fraction(1, 10**PLACES)
SHARE_PLACES: Final = 6
FIRST: Final = 1024  # cells to begin with
NARROWEST: Final = 1e-7  # of the domain
TRAPS: Final = tuple(m * 10.0**-k for k in range(1, 11) for m in (5, 2, 1))  # half widths to try
PARTS: Final = 32  # of such an interval
BEYOND: Final = np.iinfo(np.int64).max


class Basins:
    """Starts proven to tend to orbits that attract, for every parameter value of a region."""

    def __init__(self, region: Region, orbits: Sequence[tuple[float, int]], share: float) -> None:
        self._region = region
        self._domain = 2 * floor(region.setting.end / UNIT)
        self._traps = [self._trap(d, period) for d, period in orbits]
        self._proven = [_Union([[_units(x) for x in trap["interval"]]]) for trap in self._traps]
        self._order: list[tuple[Cells, int]] = []
        self._cover(share)

    @property
    def share(self) -> float:
        """Of the domain, how much is proven."""
        return sum(union.length for union in self._proven) / self._domain

    def entries(self) -> dict[str, Any]:
        """Describe what is proven."""
        shares = [
            floor(union.length * UNIT / (2 * self._region.setting.end) * 10**SHARE_PLACES)
            for union in self._proven
        ]
        return {
            **self._region.entries(),
            "attractors": [
                {**trap, "share": f"{share / 10**SHARE_PLACES:.{SHARE_PLACES}f}"}
                for trap, share in zip(self._traps, shares, strict=True)
            ],
            "cells": [
                [_text(low), _text(high), k]
                for rows, k in self._order
                for low, high in merged(rows, 0).tolist()
            ],
        }

    def _trap(self, d: float, period: int) -> dict[str, Any]:
        """Prove that a power of the map contracts an interval around a point into itself."""
        reason: Exception = Undecided("")
        for half in TRAPS:
            low, high = (round((Fraction(d) + sign * Fraction(half)) / UNIT) for sign in (-1, 1))
            if max(-low, high) > self._domain // 2:
                continue  # the map goes on beyond the domain, where no motion starts
            edges = np.linspace(low, high, PARTS + 1).astype(np.int64)
            try:
                parts = [
                    self._round(_ball(*map(int, ends)), period)
                    for ends in itertools.pairwise(edges)
                ]
            except (Undecided, ValueError) as error:
                reason = error
                continue
            words, *others = [part[0] for part in parts]
            points = [
                reduce(arb.union, part) for part in zip(*(part[1] for part in parts), strict=True)
            ]
            if (
                all(other == words for other in others)
                and all(points[0].contains_interior(part[2].range) for part in parts)
                and all(abs(part[2].gradient[0]) < 1 for part in parts)
                and not any(a.overlaps(b) for a, b in itertools.combinations(points, 2))
            ):
                return {"period": period, "itinerary": words, "interval": [_text(low), _text(high)]}
        raise Undecided(f"no interval around d = {d:.6g} is shown to be attracted: {reason}")

    def _round(self, box: arb, period: int) -> tuple[list[str], list[arb], Any]:
        """Follow an interval for a period: itinerary, ranges and the last value."""
        points, words, end = follow(self._region.setting, *self._region.around(box), period)
        return words, [x.range for x in points], end

    def _cover(self, share: float) -> None:
        """Prove cells whose images are proven; halve those whose images are so in part."""
        end = self._domain // 2
        edges = np.linspace(-end, end, FIRST + 1).astype(np.int64)
        cells = np.column_stack([edges[:-1], edges[1:]])
        images = [self._images(cell) for cell in cells]
        narrowest, looks = end, len(cells)
        while True:
            taken = np.full(len(cells), -1)
            for k, union in enumerate(self._proven):
                taken[[taken[i] < 0 and union.holds(image) for i, image in enumerate(images)]] = k
            for k, union in enumerate(self._proven):
                if len(rows := cells[taken == k]):
                    self._order.append((rows, k))
                    union.add(rows)
            left = taken < 0
            for union in self._proven:
                left &= ~union.within(cells)
            images = [image for image, stays in zip(images, left, strict=True) if stays]
            cells = cells[left]
            if (taken >= 0).any():
                continue
            if self.share >= share or narrowest < NARROWEST * self._domain or looks > MOST_CELLS:
                return
            split = cells[:, 1] - cells[:, 0] > narrowest
            split &= [any(union.meets(image) for union in self._proven) for image in images]
            if not split.any():
                narrowest //= 2
                continue
            low, high = cells[split].T
            middle = (low + high) // 2
            new = np.vstack([np.column_stack(half) for half in ((low, middle), (middle, high))])
            images = [image for image, halved in zip(images, split, strict=True) if not halved]
            images += [self._images(cell) for cell in new]
            looks += len(new)
            cells = np.vstack([cells[~split], new])

    def _images(self, cell: Whole) -> Cells:
        """Return all intervals into which the map may take a cell."""
        d, parameters = self._region.around(_ball(*map(int, cell)))
        try:
            pieces = step(self._region.setting, d, parameters, forks=FORKS)
        except Undecided:
            return np.array([[-BEYOND, BEYOND]])
        return np.array([_outside(piece.value.range) for piece in pieces], dtype=np.int64)


class _Union:
    """A union of intervals: disjoint ones in order."""

    def __init__(self, rows: Any) -> None:
        self._rows = np.asarray(rows, dtype=np.int64)

    @property
    def length(self) -> int:
        return int((self._rows[:, 1] - self._rows[:, 0]).sum())

    def add(self, rows: Cells) -> None:
        self._rows = merged(np.vstack([self._rows, rows]), 0)

    def within(self, rows: Cells) -> NDArray[np.bool_]:
        """Which intervals lie in it."""
        at = np.searchsorted(self._rows[:, 0], rows[:, 0], side="right") - 1
        return (at >= 0) & (rows[:, 1] <= self._rows[at, 1])

    def meets(self, rows: Cells) -> bool:
        """Whether one of some intervals has a point in common with it."""
        at = np.searchsorted(self._rows[:, 0], rows[:, 1], side="right") - 1
        return bool(((at >= 0) & (rows[:, 0] <= self._rows[at, 1])).any())

    def holds(self, rows: Cells) -> bool:
        return bool(self.within(rows).all())


def _units(x: str) -> int:
    return round(Fraction(x) / UNIT)


def _ball(low: int, high: int) -> arb:
    return (arb(low).union(arb(high))) / arb(10) ** PLACES


def _outside(x: arb) -> tuple[int, int]:
    """Return the ends of a ball in units, rounded outward."""
    low, high = outward(x)
    return floor(Fraction(low) / UNIT), ceil(Fraction(high) / UNIT)


def _text(units: int) -> str:
    return decimal(units * UNIT)
