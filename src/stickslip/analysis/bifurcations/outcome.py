"""What a border collision does to orbits and attractors, in one vocabulary for theory and sight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from stickslip.results.parts import part

OrbitOutcome: TypeAlias = Literal[
    "persist",
    "born in pairs",
    "die in pairs",
    "period-doubled",
    "lost at a jump",
    "born at a jump",
    "lost in a gap",
    "born at a gap",
    "undecided",
]
AttractorOutcome: TypeAlias = Literal[
    "none",
    "periodic",
    "chaotic",
    "period-adding",
    "period-incrementing",
    "undecided",
]

# One parameter value shows one member of these families: a cycle.
FAMILIES: Final = ("period-adding", "period-incrementing")


@part
@dataclass(frozen=True)
class LocalAttractor:
    """The attractor that takes part in a border collision, on one side of it.

    Attractors that are there on both sides, whatever the collision does, take no part.

    Attributes
    ----------
    kind : str
        ``none`` (orbits go elsewhere for good), ``periodic``, ``chaotic``,
        ``period-adding`` or ``period-incrementing`` (cycles whose periods grow without bound
        towards the collision) or ``undecided``.
    period : int
        Of a cycle; the number of bands of chaos; 0 if there is no one number. Counted in
        steps of the map f itself.
    base, offset : int
        Of a family: the simplest cycles have the periods ``base * n + offset``.
    """

    kind: AttractorOutcome
    period: int = 0
    base: int = 0
    offset: int = 0

    def __str__(self) -> str:
        """Return the kind in words."""
        if self.kind == "periodic":
            return f"a cycle of period {self.period}" if self.period else "a cycle"
        if self.kind == "chaotic":
            bands = {0: "", 1: " in one band"}.get(self.period, f" in {self.period} bands")
            return f"chaos{bands}"
        if self.kind in FAMILIES:
            return f"{self.kind} cycles of period {self.base} n + {self.offset} and their kin"
        return "no attractor nearby" if self.kind == "none" else "undecided"


@part
@dataclass(frozen=True)
class Outcome:
    """What happens to orbits and attractors as a parameter grows through a bifurcation.

    Attributes
    ----------
    orbits : str
        ``persist``, ``born in pairs``, ``die in pairs``, ``period-doubled`` (one orbit on
        either side, on one side with its double), ``lost at a jump``, ``born at a jump``,
        ``lost in a gap``, ``born at a gap`` or ``undecided``.
    attractors : str
        Kind of the attractor on the side of the larger parameter: see `LocalAttractor`.
    text : str
        The same in a sentence, with the numbers that decide.
    before, after : LocalAttractor or None
        Attractors on the side of the smaller and of the larger parameter.
    """

    orbits: OrbitOutcome
    attractors: AttractorOutcome
    text: str = ""
    before: LocalAttractor | None = None
    after: LocalAttractor | None = None


def disagreement(predicted: Outcome, observed: Outcome) -> str:
    """Say in what a prediction and an observation differ; empty if in nothing, or undecided."""
    parts = []
    if "undecided" not in (predicted.orbits, observed.orbits) and (
        predicted.orbits != observed.orbits
    ):
        parts.append(f"orbits: predicted {predicted.orbits!r}, observed {observed.orbits!r}")
    for side in ("before", "after"):
        theory, seen = getattr(predicted, side), getattr(observed, side)
        if theory is not None and seen is not None and not _same(theory, seen):
            parts.append(f"attractors {side}: predicted {theory}, observed {seen}")
    return "; ".join(parts)


def _same(theory: LocalAttractor, seen: LocalAttractor) -> bool:
    """Whether an observed attractor is one that the prediction allows."""
    if "undecided" in (theory.kind, seen.kind):
        return True
    if theory.kind in FAMILIES:
        # Cycles of an adding family mix two.
        any_period = theory.kind == "period-adding" or 0 in (theory.base, seen.period)
        fits = any_period or (seen.period - theory.offset) % theory.base == 0
        return seen.kind in (theory.kind, "periodic") and fits
    if theory.kind != seen.kind:
        return False
    return 0 in (theory.period, seen.period) or theory.period == seen.period
