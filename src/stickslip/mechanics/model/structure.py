"""The one linear model behind every arrangement of blocks: masses, springs, dampers, limits."""

#     M X'' + C X' + K X = friction + g(t),      g_i = amplitude_i cos(frequency t + phase)

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Self

import numpy as np

from stickslip.checks import (
    MOST_KEPT,
    dimensions,
    finite_number,
    flag,
    random_generator,
    real_numbers,
    whole_number,
)
from stickslip.results.parts import part
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.numerics.arrays import Floats


@suggests
@dataclass(frozen=True)
class Harmonic:
    """Forces ``g_i = amplitude_i cos(frequency t + phase)`` on the blocks.

    Parameters
    ----------
    amplitude : float or sequence of float
        One for all blocks, or one per block; units of f_s1.
    frequency : float
        Angular, > 0, units of sqrt(k / m).
    phase : float
        Radians.

    Raises
    ------
    ValueError
        A number is not finite, or the frequency not positive.
    """

    amplitude: float | tuple[float, ...]
    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        """Check every number once."""
        given = self.amplitude
        if dimensions(given) == 0:
            amplitude: float | tuple[float, ...] = _amplitude("amplitude", given)
        else:
            amplitude = tuple(
                _amplitude(f"amplitude[{i}]", value)
                for i, value in enumerate(real_numbers("amplitude", given).ravel())
            )
        object.__setattr__(self, "amplitude", amplitude)
        why = "A forcing repeats after 2 pi / frequency."
        frequency = finite_number("frequency", self.frequency, above=0.0, why=why)
        object.__setattr__(self, "frequency", frequency)
        phase = finite_number("phase", self.phase, why="The phase is an angle in radians.")
        object.__setattr__(self, "phase", phase)

    @property
    def period(self) -> float:
        """Time after which the forcing repeats, 2 pi / frequency."""
        return 2.0 * np.pi / self.frequency

    def amplitudes(self, n_blocks: int) -> tuple[float, ...]:
        """Amplitude on each block.

        Raises
        ------
        ValueError
            As many amplitudes as blocks are needed, or one for all.
        """
        n_blocks = whole_number("n_blocks", n_blocks, at_most=MOST_KEPT)
        if not isinstance(self.amplitude, tuple):
            return (self.amplitude,) * n_blocks
        if len(self.amplitude) != n_blocks:
            raise ValueError(
                f"forcing amplitude has {len(self.amplitude)} entries for {n_blocks} blocks: "
                "give one number for all blocks, or one per block."
            )
        return self.amplitude


def _amplitude(name: str, value: object) -> float:
    return finite_number(name, value, why="An amplitude is a force in units of f_s1.")


MOST_STATES = 10**8
"""That may be drawn at once."""


@part
@dataclass(frozen=True, eq=False)
class Structure:
    """Numbers of a model with n blocks, dimensionless."""

    mass: Floats  # (n,), as static and amplitude
    stiffness: Floats  # (n, n), symmetric, as damping
    damping: Floats
    static: Floats
    V: float
    amplitude: Floats  # of the forcing, as frequency (angular) and phase
    frequency: float
    phase: float

    @property
    def n_blocks(self) -> int:
        """Number of blocks."""
        return len(self.mass)

    @property
    def is_forced(self) -> bool:
        """Whether a force depends on time."""
        return bool(self.amplitude.any())

    @property
    def loading(self) -> Floats:
        """Growth of each needed force while all blocks ride, per unit of time: V K 1."""
        return np.asarray(self.V * self.stiffness.sum(axis=1))

    def needed_force(self, x: ArrayLike, v: ArrayLike, t: float = 0.0) -> Floats:
        """Force that friction must supply for each block to ride, shape (..., n) as `x` and `v`."""
        springs = np.asarray(x, dtype=np.float64) @ self.stiffness
        dampers = np.asarray(v, dtype=np.float64) @ self.damping
        forcing = self.amplitude * np.cos(self.frequency * t + self.phase)
        return np.asarray(springs + dampers - forcing)

    def direction_to(self, other: Self) -> Self:
        """Difference of every number to another structure: a direction of change."""
        return type(self)(
            *(getattr(other, item.name) - getattr(self, item.name) for item in fields(self))
        )

    def sample_sticking(self, n: int, rng: np.random.Generator | int | None = None) -> Floats:
        """Draw displacements, shape (n, n_blocks), of riding blocks; uniform needed forces."""
        n = whole_number("n", n, 0, at_most=MOST_STATES)
        return self.sticking(random_generator("rng", rng).uniform(size=(n, self.n_blocks)))

    def sticking(self, share: ArrayLike) -> Floats:
        """Displacements with needed forces at a `share` of their limits: 0 lower, 1 upper."""
        force = self.static * (2.0 * np.asarray(share) - 1.0)
        return self._displacements(force, np.full(self.n_blocks, self.V))

    def sample_state(
        self, rng: np.random.Generator | int | None = None, *, riding: bool = False
    ) -> tuple[Floats, Floats]:
        """Draw a legal state, displacements and velocities, shape (n_blocks,); see `BeltModel`."""
        generator = random_generator("rng", rng)
        v = np.full(self.n_blocks, self.V)
        if not flag("riding", riding):
            v = v + generator.uniform(-1.0, 1.0, size=self.n_blocks)
        return self._displacements(generator.uniform(-self.static, self.static), v), v

    def _displacements(self, force: Floats, v: Floats) -> Floats:
        """Displacements that need given forces at given velocities."""
        rest = self.needed_force(np.zeros(self.n_blocks), v)
        return np.asarray(np.linalg.solve(self.stiffness, (force - rest).T).T)
