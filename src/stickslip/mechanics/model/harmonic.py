"""Harmonic forcing of the blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.checks import MOST_KEPT, dimensions, finite_number, real_numbers, whole_number
from stickslip.vocabulary import suggests


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
