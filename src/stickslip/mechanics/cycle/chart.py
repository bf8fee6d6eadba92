"""Coordinates of a section: where one contact is released, or lands."""

# Derivation: docs/theory/return-map.md. What is said of `Reduced` holds for complex numbers too.

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.checks import shown
from stickslip.mechanics.eventmap.records import Section, still
from stickslip.mechanics.flow.blocks.system import sparse, sparse_changes
from stickslip.mechanics.model.plant import ROUNDING, TINY, Plant, Reduced

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.mechanics.model.plant import Numbers
    from stickslip.numerics.arrays import Floats


PHASE: Final = "phase"


@dataclass(frozen=True, eq=False)
class Chart:
    """Which entries of a state (x, v), and the phase of the forcing, are a point of a section."""

    plant: Plant
    contact: int  # from 0
    mode: int  # of its slip, which a release begins and a landing ends
    released: bool
    kept: tuple[int, ...]  # entries of the state
    gauge: tuple[int, ...]  # entries that tell how far what turns freely has turned

    # --- names ------------------------------------------------------------------------------

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers of a point."""
        own = names_of(self.plant)
        return (PHASE,) * self.plant.is_forced + tuple(own[k] for k in self.kept)

    # --- between points and coordinates -----------------------------------------------------

    def into(self, reduced: Reduced) -> Numbers:
        """Matrix of (y, w) by (waves, point, 1), shape (n, waves + numbers + 1)."""
        n_waves, n = reduced.n_waves, reduced.matrix.shape[1] - reduced.n_waves
        states = states_of(reduced, self.plant.n_positions)
        rows = np.concatenate(
            [self.conditions(reduced), states[list(self.gauge)], states[list(self.kept)]]
        )
        first = int(self.plant.is_forced)
        given = np.zeros((n, first + len(self.kept)))
        given[n - len(self.kept) :, first:] = np.eye(len(self.kept))
        right = np.concatenate([-rows[:, :n_waves], given, -rows[:, -1:]], axis=1)
        return np.ascontiguousarray(np.linalg.solve(rows[:, n_waves:-1], right))

    def out(self, reduced: Reduced) -> Numbers:
        """Matrix of the point by (waves, y, w, 1); a phase is no such row, and 0."""
        states = states_of(reduced, self.plant.n_positions)
        own = slice(reduced.n_waves, -1)
        turned = states[:, own] @ self.plant.turns
        gauge, kept = list(self.gauge), list(self.kept)
        rows = states[kept] - turned[kept] @ np.linalg.solve(turned[gauge], states[gauge])
        return np.concatenate([np.zeros((int(self.plant.is_forced), rows.shape[1])), rows])

    def conditions(self, reduced: Reduced) -> Numbers:
        """Rows of (waves, y, w, 1) that vanish on the section: w and, released, e -+ L."""
        n, m = reduced.matrix.shape[1], len(reduced.mass)
        still = np.zeros((1, n + 1))
        still[0, n - m + self.contact] = 1.0
        if not self.released:
            return still
        needed, limit = n - m + self.contact, n + self.contact
        rows = np.column_stack([reduced.matrix, reduced.constant])
        return np.concatenate([still, rows[needed : needed + 1] + self.mode * rows[limit]])

    # --- for kernels ------------------------------------------------------------------------

    @cached_property
    def section(self) -> Section:
        """The section, with changes in the numbers of a point."""
        reduced = self.plant.reduced
        into, out = self.into(reduced), self.out(reduced)
        n = len(out)
        return Section(
            contact=self.contact,
            mode=self.mode,
            released=self.released,
            period=self.plant.period if self.plant.is_forced else 0.0,
            into=into,
            out=sparse(out[:, :-1], out[:, -1]),
            changes=still(n, n, into, len(reduced.frequency)),
        )

    def along(self, change: Reduced | None) -> Section:
        """Return the section with its change when the plant changes like this."""
        reduced, n = self.plant.reduced, len(self.section.out.constant)
        unchanged = still(1, n, self.section.into, len(reduced.frequency))
        unchanged = unchanged._replace(point=np.zeros((1, n)))
        if change is None:
            return self.section._replace(changes=unchanged)
        pairs = zip(reduced, change, strict=True)
        moved = Reduced(*(value + 1j * TINY * slope for value, slope in pairs))
        into, out = (np.imag(rows) / TINY for rows in (self.into(moved), self.out(moved)))
        changes = unchanged._replace(
            into=into[None],
            out=sparse_changes([sparse(out[:, :-1], out[:, -1])], n, [True]),
            period=np.array([self.plant.period_change(change)]),
            frequency=np.asarray(change.frequency)[None],
            phase=np.asarray(change.phase)[None],
        )
        return self.section._replace(changes=changes)


def chart(
    plant: Plant, contact: int, mode: int, released: bool, names: Sequence[str] | None
) -> Chart:
    """Choose the coordinates of a section, or take those named; ValueError if they do not do."""
    reduced = plant.reduced
    states = plant.jacobians[0]
    known = names_of(plant)
    free = np.array([names is None or name not in names for name in known])
    bare = Chart(plant, contact, mode, released, (), ())
    rows = bare.conditions(reduced)[:, reduced.n_waves : -1] @ np.linalg.inv(states)
    gauge = _pivots((states @ plant.turns).T, free, plant.n_positions)
    gone = gauge + _pivots(rows, free, plant.n_positions)
    kept = tuple(k for k in range(len(known)) if k not in gone)
    made = Chart(plant, contact, mode, released, kept, tuple(gauge))
    determined = len(rows) + plant.turns.shape[1]
    if names is not None and (made.names != tuple(names) or len(gone) < determined):
        whole = chart(plant, contact, mode, released, None)
        if not (example := whole.names):
            return whole
        raise ValueError(
            f"coordinates = {shown(tuple(names))} do not tell a point of the section: "
            f"{len(example)} are needed, such as {example}, in the order of "
            f"{', '.join((PHASE,) * plant.is_forced + known)}."
        )
    return made


def _pivots(rows: Floats, free: NDArray[np.bool_], n_positions: int) -> list[int]:
    """Entries that rows determine when all others are given, positions first; no longer free."""
    rows, chosen = rows.copy(), []
    for k, row in enumerate(rows):
        size = np.abs(row) * free
        size[size <= ROUNDING * np.abs(row).max(initial=0.0)] = 0.0
        j = int(np.argmax(size[:n_positions] if size[:n_positions].any() else size))
        if size[j] == 0.0:
            continue  # what is left over shows in the count of coordinates
        free[j] = False
        chosen.append(j)
        rows[k + 1 :] -= np.outer(rows[k + 1 :, j] / row[j], row)
    return chosen


def names_of(plant: Plant) -> tuple[str, ...]:
    """Names of the entries of a state (x, v)."""
    n_q = plant.n_positions
    n_x = n_q or len(plant.mass)
    speeds = range(1, len(plant.mass) + 1) if n_q else ()
    return tuple(f"x_{k + 1}" for k in range(n_x)) + tuple(f"v_{k}" for k in speeds)


def states_of(reduced: Reduced, n_positions: int) -> Numbers:
    """Matrix of the state by (waves, y, w, 1): positions, then velocities."""
    n_waves = reduced.n_waves
    positions = np.eye(n_positions, reduced.matrix.shape[1] + 1, n_waves)
    return np.concatenate([positions, np.column_stack([reduced.out_matrix, reduced.out_constant])])
