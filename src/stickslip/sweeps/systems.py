"""What a sweep varies: models of two and more blocks, and maps of the user's own, seen alike."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.checks import shown
from stickslip.mechanics.cycle.return_map import LineReturnMap
from stickslip.mechanics.eventmap.cuda import check_model, check_traced
from stickslip.mechanics.eventmap.event_map import BlocksEventMap, EventMap
from stickslip.mechanics.eventmap.follow import follow
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.eventmap.records import Controls, ModelTable, new_followed
from stickslip.mechanics.flow.engine import engine_for
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.long_run import new_long_run
from stickslip.sweeps.blocks_systems import BlocksSystem, LineSystem, MotionSystem
from stickslip.sweeps.identity import function_identity, law_identity
from stickslip.sweeps.system import Run, System, follow_maps, rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Followed
    from stickslip.mechanics.flow.engine import Engine, EngineName
    from stickslip.numerics.arrays import Floats
    from stickslip.numerics.long_run import LongRun
    from stickslip.sweeps.system import Columns

OWN = ("alpha", "beta", "V")  # parameters that the kernels take as numbers, not through the law


@lru_cache(maxsize=4096)
def _engine_of(model: TwoBlock, name: EngineName) -> Engine:
    """Prepare the engine of a model; laws come back in tile after tile."""
    return engine_for(model, name)


def as_system(given: Any) -> System:
    """Take a model, its event map or a map of the user's own."""
    if isinstance(given, BeltModel):
        if given.n_blocks == 1 or given.plant.is_forced or not given.plant.rubs_as_one:
            return MotionSystem(given)
        given = event_map(given)
    if type(given) is EventMap and isinstance(given.model, TwoBlock):
        return ModelSystem(given)
    if isinstance(given, EventMap | LineReturnMap):
        return LineSystem(given)
    if isinstance(given, BlocksEventMap):
        return BlocksSystem(given)
    if isinstance(given, PiecewiseMap):
        return MapSystem(given)
    raise ValueError(
        f"system = {shown(given)}: a sweep takes a model, its event map, its return map if that "
        "is one of a line, or a PiecewiseMap."
    )


class ModelSystem(LineSystem):
    """Two equal blocks: kernels that follow the orbits of many models."""

    def __init__(self, f: EventMap, device: str = "cpu") -> None:
        super().__init__(f)
        self.model: TwoBlock = f.model
        self.settings = {name: f.settings[name] for name in (*Controls._fields, "engine")}
        self.device = device

    def on(self, device: str) -> ModelSystem:
        """Return the same system, followed on a device."""
        if device == "cuda":
            check_model(self.model)
            check_traced(_engine_of(self.model, self.settings["engine"]))
        return ModelSystem(self.f, device)

    def identity(self) -> dict[str, Any]:
        """Describe the system in values that JSON can hold."""
        laws = self.model.laws if isinstance(self.model.friction, tuple) else self.model.laws[:1]
        numbers = {**self.model.parameters, "damping": self.model.damping}
        options = [law.options | law_identity(law) for law in laws]
        settings = {name: str(value) for name, value in self.settings.items()}
        return {"model": "two_block", "parameters": numbers, "laws": options, "engine": settings}

    def domains(self, columns: Columns, size: int) -> tuple[Floats, Floats]:
        """Return the ends of the domains."""
        alpha, beta = (self._column(columns, name, size) for name in ("alpha", "beta"))
        end = (1.0 + beta) / (1.0 + 2.0 * alpha)
        return -end, end

    def follow(
        self, columns: Columns, starts: Floats, run: Run, tail: int
    ) -> tuple[LongRun, Followed]:
        """Follow orbits."""
        verdicts, followed = new_long_run(starts.size), new_followed(starts.size, tail)
        of_start = np.repeat(np.arange(len(starts)), starts.shape[1])
        for models, chosen in self._by_kernels(columns, len(starts)):
            where = np.flatnonzero(chosen[of_start])
            some = (starts.ravel()[where], of_start[where])
            found = self._followed(models, columns, *some, run, tail)
            for results, part in zip((verdicts, followed), found, strict=True):
                for whole, piece in zip(results, part, strict=True):
                    whole[where] = piece
        return verdicts, followed

    def _followed(
        self,
        models: list[tuple[TwoBlock, NDArray[np.bool_]]],
        columns: Columns,
        starts: Floats,
        of_start: NDArray[np.int64],
        run: Run,
        tail: int,
    ) -> tuple[LongRun, Followed]:
        """Follow the starts of grid points whose models share their kernels."""
        size = len(models[0][1])
        if self._by_maps(models[0][0]):
            if self.device == "cuda":
                check_model(models[0][0])
            points = np.unique(of_start)
            own = {name: column[points] for name, column in columns.items()}
            maps = map(self.map_at, rows(own, points.size))
            return follow_maps(maps, starts.reshape(points.size, -1), run, tail)
        engines = [_engine_of(model, self.settings["engine"]) for model, _ in models]
        law_row = np.zeros(size, dtype=np.int64)
        for row, (_, chosen) in enumerate(models):
            law_row[chosen] = row
        table = ModelTable(
            alpha=self._column(columns, "alpha", size),
            beta=self._column(columns, "beta", size),
            V=self._column(columns, "V", size),
            laws=np.stack([engine.laws for engine in engines]),
            law_row=law_row,
            of_start=of_start,
        )
        controls = Controls(*(self.settings[name] for name in Controls._fields))
        return follow(
            engines[0],
            table,
            starts,
            controls=controls,
            transient=run.transient,
            n=run.n,
            max_period=run.max_period,
            tail=tail,
            device=self.device,
        )

    def _by_kernels(
        self, columns: Columns, size: int
    ) -> list[tuple[list[tuple[TwoBlock, NDArray[np.bool_]]], NDArray[np.bool_]]]:
        """Group grid points by kernels: models that differ in alpha, beta, V alone."""
        # Returns, for each set of kernels, its models with their grid points, and all of these.
        names = [name for name in columns if name not in OWN]
        table = (
            np.stack([columns[name] for name in names], axis=1) if names else np.empty((size, 0))
        )
        distinct, inverse = np.unique(table, axis=0, return_inverse=True)
        groups: dict[str, list[tuple[TwoBlock, NDArray[np.bool_]]]] = {}
        for number, values in enumerate(distinct):
            model = self.model.replace(**dict(zip(names, values.tolist(), strict=True)))
            by_maps = self._by_maps(model)
            key = "maps" if by_maps else _engine_of(model, self.settings["engine"]).key
            groups.setdefault(key, []).append((model, inverse.ravel() == number))
        return [
            (models, np.any([chosen for _, chosen in models], axis=0)) for models in groups.values()
        ]

    def _by_maps(self, model: TwoBlock) -> bool:
        """Whether orbits of a model are followed by its map: damped, or quicker side by side."""
        if model.damping > 0.0:
            return True
        return self.device == "cpu" and EventMap(model, **self.f.settings).kin is not None

    def _column(self, columns: Columns, name: str, size: int) -> Floats:
        if name in columns:
            return np.ascontiguousarray(columns[name])
        return np.full(size, getattr(self.model, name))


class MapSystem(System):
    """A map of the user's own."""

    lacks: Mapping[str, str] = MappingProxyType(
        {
            "events": "a map of one's own has no events",
            "model": "a map of one's own has no motion in time",
        }
    )

    def __init__(self, f: PiecewiseMap) -> None:
        self.f = f

    @property
    def names(self) -> Collection[str]:
        """Names of the numbers that may vary."""
        return self.f.parameters

    def identity(self) -> dict[str, Any]:
        """Describe the system in values that JSON can hold."""
        functions = {role: function_identity(each) for role, each in self.f.callables.items()}
        numbers = {"domain": list(self.f.domain), "breakpoints": self.f.breakpoints.tolist()}
        return {"map": functions, "parameters": self.f.parameters, **numbers}

    def map_at(self, values: Mapping[str, float]) -> PiecewiseMap:
        """Make the map at some parameter values."""
        return self.f.replace(**values)

    def domains(self, columns: Columns, size: int) -> tuple[Floats, Floats]:
        """Return the ends of the domains."""
        low, high = self.f.domain
        return np.full(size, low), np.full(size, high)
