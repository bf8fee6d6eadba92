"""Models of the family in a sweep: with a map of the line, one of R^n, or with none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.sweeps.identity import digest, law_identity
from stickslip.sweeps.system import System, rows, spread_shares

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stickslip.mechanics.cycle.return_map import LineReturnMap
    from stickslip.mechanics.eventmap.event_map import BlocksEventMap, EventMap
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats
    from stickslip.sweeps.job import Points
    from stickslip.sweeps.system import Columns


class FamilySystem(System):
    """A model of the family."""

    model: Model

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers that may vary."""
        return self.model.replaceable

    def identity(self) -> dict[str, Any]:
        """Describe the model in values that JSON can hold."""
        plant = self.model.plant
        arrays = (plant.mass, plant.stiffness, plant.damping, plant.into, plant.out, plant.static)
        return {
            "model": type(self.model).__name__,
            "parameters": self.model.parameters,
            "structure": digest(b"".join(array.astype("<f8").tobytes() for array in arrays)),
            "laws": [law.options | law_identity(law) for law in self.model.laws],
        }

    def check(self, values: Mapping[str, float]) -> None:
        """Raise ValueError if some values are not allowed."""
        self.model.replace(**values)

    def model_at(self, values: Mapping[str, float]) -> Model:
        """Make the model at some parameter values."""
        return self.model.replace(**values)


class MotionSystem(FamilySystem):
    """A model without an event map: one block, or a forced one."""

    def __init__(self, model: Model) -> None:
        self.model = model
        single = model.n_blocks == model.plant.n_bodies == 1
        alone = "a single block" if single else "a model of more than blocks on a belt"
        what = "a forced model" if model.plant.is_forced else alone
        swept = "its return_map is swept if it is one of a line, or 'limit_cycles', or functions"
        why = f"{what} has no event map; {swept}"
        self.lacks = dict.fromkeys(("orbits", "events", "line", "d"), why)

    def map_at(self, values: Mapping[str, float]) -> Any:
        """Return the model, which functions of the user's own take in place of a map."""
        return self.model_at(values)

    def starts(self, points: Points, n_starts: int) -> Floats:
        """Return NaN: there are no points of a map to start from."""
        return np.full((points.size, n_starts), np.nan)


WHERE = ("device", "threads")  # settings of maps that say where values are computed, not which


class LineSystem(FamilySystem):
    """Maps of the line: points of an orbit are numbers."""

    def __init__(self, f: EventMap | BlocksEventMap | LineReturnMap) -> None:
        self.model = f.model
        self.f: Any = type(f)(f.model, **{**f.settings, "threads": 1})

    def identity(self) -> dict[str, Any]:
        """Describe the model in values that JSON can hold."""
        given = self.f.settings.items()
        settings = {name: str(value) for name, value in given if name not in WHERE}
        return {**super().identity(), "engine": settings}

    def map_at(self, values: Mapping[str, float]) -> Any:
        """Make the map at some parameter values."""
        return self.f.replace(**values)

    def domains(self, columns: Columns, size: int) -> tuple[Floats, Floats]:
        """Return the ends of the domains."""
        ends = [self.map_at(values).domain for values in rows(columns, size)]
        low, high = np.reshape(ends, (size, 2)).T
        return low, high


class BlocksSystem(LineSystem):
    """Three blocks or more without forcing: points of an orbit are vectors of differences."""

    def __init__(self, f: BlocksEventMap) -> None:
        super().__init__(f)
        why = f"points of the event map of {f.model.n_blocks} blocks are not numbers"
        self.lacks = {"line": why, "d": why}

    def starts(self, points: Points, n_starts: int) -> Floats:
        """Draw global stick phases, needed forces even between their limits; NaN for none."""
        shares = spread_shares(points.seed, points.index, n_starts, self.model.n_blocks)
        starts = np.empty((*shares.shape[:2], self.model.n_blocks - 1))
        for point, values in enumerate(points.values()):
            model = self.model_at(values)
            starts[point] = np.diff(model.plant.sticking(shares[point]), axis=-1)
            if n_starts == 1 and points.d is not None:
                starts[point] = points.d[point]
            starts[point, ~model.contains(starts[point])] = np.nan
        return starts
