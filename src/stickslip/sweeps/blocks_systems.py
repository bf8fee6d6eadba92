"""Models of the family of any number of blocks in a sweep: with an event map, or with none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.mechanics.eventmap.blocks_map import BlocksEventMap
from stickslip.mechanics.eventmap.records import new_followed
from stickslip.numerics.long_run import (
    PERIODIC,
    RECURRENCE,
    UNDECIDED,
    Path,
    new_long_run,
    read_off,
    recurs,
)
from stickslip.status import OK
from stickslip.sweeps.identity import digest, law_identity
from stickslip.sweeps.system import System, spread_shares

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Followed
    from stickslip.mechanics.model.belt_model import BeltModel
    from stickslip.numerics.arrays import Floats
    from stickslip.numerics.long_run import LongRun
    from stickslip.sweeps.job import Points
    from stickslip.sweeps.system import Run


class MotionSystem(System):
    """A model without an event map: one block, or a forced one."""

    def __init__(self, model: BeltModel) -> None:
        self.model = model
        what = "a forced model" if model.structure.is_forced else "a single block"
        why = f"{what} has no event map; 'limit_cycles' and functions of one's own are for it"
        self.lacks: Mapping[str, str] = dict.fromkeys(("orbits", "events", "line", "d"), why)

    def identity(self) -> dict[str, Any]:
        """Describe the model in values that JSON can hold."""
        structure = self.model.structure
        arrays = (structure.mass, structure.stiffness, structure.damping, structure.static)
        return {
            "model": type(self.model).__name__,
            "parameters": self.model.parameters,
            "structure": digest(b"".join(array.astype("<f8").tobytes() for array in arrays)),
            "laws": [law.options | law_identity(law) for law in self.model.laws],
        }

    def model_at(self, values: Mapping[str, float]) -> BeltModel:
        """Make the model at some parameter values."""
        return self.model.replace(**values)

    def map_at(self, values: Mapping[str, float]) -> Any:
        """Return the model, which functions of the user's own take in place of a map."""
        return self.model_at(values)

    def starts(self, points: Points, n_starts: int) -> Floats:
        """Return NaN: there are no points of a map to start from."""
        return np.full((points.size, n_starts), np.nan)


class BlocksSystem(MotionSystem):
    """Two blocks or more without forcing: points of an orbit are vectors of differences."""

    def __init__(self, f: BlocksEventMap) -> None:
        self.model, self.settings = f.model, {**f.settings, "threads": 1}
        self.lacks = {}
        if f.dimension > 1:
            why = f"points of the event map of {f.model.n_blocks} blocks are not numbers"
            self.lacks = {"line": why, "d": why}

    def identity(self) -> dict[str, Any]:
        """Describe the model in values that JSON can hold."""
        settings = {name: str(value) for name, value in self.settings.items() if name != "threads"}
        return {**super().identity(), "engine": settings}

    def map_at(self, values: Mapping[str, float]) -> BlocksEventMap:
        """Make the map at some parameter values."""
        return BlocksEventMap(self.model.replace(**values), **self.settings)

    def starts(self, points: Points, n_starts: int) -> Floats:
        """Draw global stick phases, needed forces even between their limits; NaN for none."""
        shares = spread_shares(points.seed, points.index, n_starts, self.model.n_blocks)
        starts = np.empty((*shares.shape[:2], self.model.n_blocks - 1))
        for point, values in enumerate(points.values()):
            model = self.model_at(values)
            starts[point] = np.diff(model.structure.sticking(shares[point]), axis=-1)
            if n_starts == 1 and points.d is not None:
                starts[point] = points.d[point]
            starts[point, ~model.contains(starts[point])] = np.nan
        return starts

    def follow_one(
        self, f: BlocksEventMap, starts: Floats, run: Run, tail: int
    ) -> tuple[LongRun, Followed]:
        """Follow the orbits of one grid point; ``tail`` holds first differences."""
        m, steps = len(starts), run.transient + run.n
        verdicts, followed = new_long_run(m), new_followed(m, tail)
        widths = np.ptp(f.spread(256), axis=0)
        orbits = np.full((m, steps + 1, f.dimension), np.nan)
        admitted = np.isfinite(starts).all(axis=1)
        orbits[admitted] = f.iterate(starts[admitted], steps)
        for i in np.flatnonzero(admitted).tolist():
            defined = np.isfinite(orbits[i]).all(axis=1)
            if not defined.all():
                last = int(np.argmin(defined)) - 1
                followed.steps[i] = last
                followed.status[i] = f.carry(orbits[i, last : last + 1]).status[0]
                continue
            points = orbits[i, run.transient :]
            motions = f.carry(points[:-1], slope=True)
            followed.status[i], followed.steps[i] = OK, steps
            followed.tail[i] = points[run.n + 1 - tail :, 0]
            followed.mean_events[i] = motions.n_events.mean()
            followed.most_events[i] = motions.n_events.max()
            followed.mean_duration[i] = motions.duration.mean()
            _read_off(
                points, motions.label, motions.derivative, widths, run.max_period, verdicts, i
            )
        return verdicts, followed


def _read_off(
    points: Floats,
    labels: NDArray[np.uint64],
    jacobians: Floats,
    widths: Floats,
    max_period: int,
    verdicts: LongRun,
    i: int,
) -> None:
    """Fill in entry `i` of the verdicts, as `numerics.long_run.read_off` does on the line."""
    # The exponent is the largest one: growth of one tangent vector, or of a cycle log of the
    # spectral radius of its monodromy matrix per step.
    paths = [Path(np.ascontiguousarray(x), labels, _growth(jacobians)) for x in points.T]
    tolerances = RECURRENCE * widths
    # Without periods: exponent, error, and whether that is chaos.
    read_off(paths[0], -np.inf, np.inf, 0, verdicts, i)
    for period in range(1, min(max_period, len(labels) // 2) + 1):
        if not all(map(recurs, paths, [period] * len(paths), tolerances)):
            continue
        monodromy = np.eye(len(widths))
        for jacobian in jacobians[len(labels) - period :]:
            monodromy = jacobian @ monodromy
        radius = float(np.abs(np.linalg.eigvals(monodromy)).max())
        verdicts.exponent[i] = np.log(radius) / period if radius > 0 else -np.inf
        verdicts.error[i] = 0.0
        verdicts.kind[i] = PERIODIC if radius < 1 else UNDECIDED
        verdicts.period[i] = period if radius < 1 else 0
        return


def _growth(jacobians: Floats) -> Floats:
    """Logarithm of the growth of a tangent vector in each step."""
    tangent = np.ones(jacobians.shape[-1])
    logs = np.empty(len(jacobians))
    with np.errstate(divide="ignore"):
        for k, jacobian in enumerate(jacobians):
            tangent = jacobian @ (tangent / np.linalg.norm(tangent))
            size = float(np.linalg.norm(tangent))
            logs[k] = np.log(size)
            if size == 0.0:
                tangent = np.ones(len(tangent))  # superstable: the mean is -inf whatever follows
    return logs
