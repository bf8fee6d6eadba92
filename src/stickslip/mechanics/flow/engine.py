"""Which engine moves a model, and with which numbers: the step from models to kernels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import finite_number, one_of, shown
from stickslip.mechanics.flow.blocks.joint import settle_together
from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    BlockMotion,
    BlockSystem,
    BlockWork,
    block_directions,
    block_system,
    new_block_motion,
    new_block_work,
    widened,
)
from stickslip.mechanics.flow.blocks.transitions import settle, update_needed
from stickslip.mechanics.flow.system import (
    ALPHA,
    BETA,
    LAWS,
    START,
    VELOCITY,
    Motion,
    System,
    new_motion,
)
from stickslip.mechanics.flow.transitions import settle as settle_pair
from stickslip.mechanics.friction.code import LawCode, law_code
from stickslip.mechanics.friction.coulomb import is_constant
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.targets import instantiate

if TYPE_CHECKING:
    from stickslip.mechanics.flow.blocks.system import Bools
    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.mechanics.model.belt_model import BeltModel
    from stickslip.mechanics.model.plant import Reduced
    from stickslip.numerics.arrays import Floats


EngineName: TypeAlias = Literal["auto", "exact", "adaptive"]
ENGINES = ("auto", "exact", "adaptive")

FLOW = "stickslip.mechanics.flow"
LAW_KERNELS = (
    "FORCE_ROW",
    "GRADIENT_ROW",
    "N_ROWS",
    "N_PARAMETERS",
    "SLOPE_ROW",
    "force",
    "force_continued",
    "force_sharp",
    "gradient",
    "series",
    "series_tangent",
    "slope",
    "static_value",
)


@dataclass(frozen=True, eq=False)
class Engine:
    """Kernels that move two undamped equal blocks, and these in the form that they take."""

    is_pair: ClassVar = True
    n_states: ClassVar = 4
    name: str  # "exact", or of the adaptive engine "taylor", "collocation"
    key: str  # equal keys, equal machine code
    kernels: ModuleType  # advance, landing_rate, new_work, ...
    code: LawCode
    system: System
    laws: NDArray[np.float64]  # parameter rows, (2, columns)

    @property
    def n_law_parameters(self) -> int:
        """Friction parameters of one block in a row of `directions`."""
        return self.code.N_PARAMETERS

    @property
    def n_directions(self) -> int:
        """Entries of a row of `directions`."""
        return LAWS + 2 * self.n_law_parameters

    def new_work(self) -> Any:
        """Scratch arrays of the kernels for one motion."""
        return self.kernels.new_work()

    def new_motion(self, directions: Floats) -> Motion:
        """Arrays for one motion with a tangent for each direction."""
        motion = new_motion(len(directions), self.n_law_parameters)
        return motion._replace(directions=directions)

    def settle(self, motion: Motion, _work: Any) -> bool:
        """Change the modes of a motion at an event; tell whether any changed."""
        before = motion.mode.copy()
        settle_pair(self.system, motion)
        return bool((motion.mode != before).any())

    def directions(self, starts: Floats | None = None) -> Floats:
        """Rows of `directions`: of the starting d, if it is given."""
        rows = np.zeros((0 if starts is None else len(starts), self.n_directions))
        rows[:, START] = 1.0
        return rows

    def along(self, model: TwoBlock, name: str) -> Floats:
        """Row of `directions` for a derivative in a parameter that the model has."""
        row = np.zeros((1, self.n_directions))
        own = {"alpha": ALPHA, "beta": BETA, "V": VELOCITY}
        if name in own:
            row[0, own[name]] = 1.0
            return row
        for block, own_name in model.law_parameters[name]:
            j = self.code.parameter_index(model.laws[block], own_name)
            row[0, LAWS + block * self.n_law_parameters + j] = 1.0
        return row

    def widened(self, directions: Floats, n_more: int) -> Floats:
        """Directions with some more that change nothing."""
        rows = np.zeros((len(directions) + n_more, directions.shape[1]))
        rows[: len(directions)] = directions
        return rows

    def columns(self, directions: Floats) -> Floats:
        """Return an entry for each direction."""
        return directions


def engine_for(model: TwoBlock, engine: EngineName = "auto") -> Engine:
    """Choose the engine for a model; ValueError for "exact" where motion has no closed form."""
    one_of("engine", engine, ENGINES)
    exact = all(map(is_constant, model.laws))
    if engine == "exact" and not exact:
        raise ValueError(
            f"engine = 'exact' is for constant kinetic friction, Coulomb(mu), and not for "
            f"{shown(model.friction)}. Take engine='auto' or 'adaptive'."
        )
    code, rows = _code_and_rows(model.laws)
    name = "exact" if exact and engine != "adaptive" else _stepper(code)
    return Engine(
        name=name,
        key="exact" if name == "exact" else f"{name}-{code.key}",
        kernels=_kernels(name, code),
        code=code,
        system=System(model.alpha, model.beta, model.V),
        laws=rows.copy(),
    )


@lru_cache(maxsize=16)
def _code_and_rows(laws: tuple[FrictionLaw, ...]) -> tuple[LawCode, Floats]:
    """Kernels and parameter rows of laws: models beside each other have the same."""
    code = law_code(laws)
    return code, code.parameter_rows(laws)


def _stepper(code: LawCode) -> str:
    return "taylor" if code.traceable else "collocation"


def tolerance(rtol: object) -> float:
    """Return the local truncation error of the adaptive engine, in (0, 1e-3], at least 1e-16."""
    why = "rtol is the local truncation error of the adaptive engine."
    number = finite_number("rtol", rtol, above=0.0, at_most=1e-3, why=why)
    return max(number, 1e-16)


def time_limit(value: object) -> float:
    """Return the longest time of one motion, which may be infinite."""
    if isinstance(value, float) and value == math.inf:
        return value
    return finite_number("max_time", value, above=0.0, why="max_time limits one motion's time.")


@lru_cache(maxsize=64)
def _kernels(name: str, code: LawCode) -> ModuleType:
    if name == "exact":
        from stickslip.mechanics.flow import _exact_kernels

        return _exact_kernels
    bindings = {role: getattr(code, role) for role in LAW_KERNELS}
    sliding = sliding_kernels(code)
    bindings |= {role: getattr(sliding, role) for role in ("landing_rate", "slides_for_ever")}
    template = f"{FLOW}._{name}_kernels"
    return instantiate(template, code.key, **bindings)


def sliding_kernels(code: LawCode) -> ModuleType:
    """Return ``least_slope`` of some laws, and what two blocks make of it."""
    bindings = {role: getattr(code, role) for role in ("force", "slope", "static_value")}
    return instantiate(f"{FLOW}._sliding_kernels", code.key, **bindings)


STEPPER = "stickslip.mechanics.flow.blocks._stepper_kernels"


@dataclass(frozen=True, eq=False)
class BlockEngine:
    """Kernels that move a plant, and the plant in the form that they take."""

    is_pair: ClassVar = False
    name: ClassVar = "series"
    key: str  # equal keys, equal machine code
    kernels: ModuleType  # advance, landing_rate, slides_for_ever, ORDER
    code: LawCode
    system: BlockSystem
    laws: NDArray[np.float64]  # parameter rows, (n, columns)

    def new_work(self) -> BlockWork:
        """Scratch arrays of the kernels for one motion."""
        return new_block_work(self.system, self.code.N_ROWS, self.kernels.ORDER)

    @property
    def n_states(self) -> int:
        """Numbers of a state."""
        return len(self.system.constant) - len(self.system.mass)

    def new_motion(self, directions: BlockDirections) -> BlockMotion:
        """Arrays for one motion with a tangent for each direction."""
        return new_block_motion(self.system, directions)

    def along(self, model: BeltModel, name: str) -> BlockDirections:
        """Direction of change with a parameter."""
        return self.directions(changes=[self.change(model, name)])

    def widened(self, directions: BlockDirections, n_more: int) -> BlockDirections:
        """Directions with some more that change nothing."""
        return widened(directions, n_more)

    def columns(self, directions: BlockDirections) -> Bools:
        """Return an entry for each direction."""
        return directions.varies

    @property
    def has_feet(self) -> bool:
        """Whether a contact is elastic."""
        return bool((self.system.foot >= 0).any())

    def refresh(self, motion: BlockMotion) -> None:
        """Compute the needed forces of a motion in its present state and modes."""
        if self.system.joint is None and not self.has_feet:
            update_needed(self.system, motion)
        else:
            self.kernels.refresh(self.system, self.laws, motion)

    def settle(self, motion: BlockMotion, work: BlockWork) -> bool:
        """Change the modes of a motion at an event; tell whether any changed."""
        if self.system.joint is None:
            return bool(settle(self.system, self.laws, motion, work.rates))
        return bool(settle_together(self.system, self.laws, motion))

    def directions(
        self,
        starts: Floats | int = 0,
        changes: Sequence[tuple[Reduced | None, Floats]] = (),
    ) -> BlockDirections:
        """Directions of change: of the start (as many as it has rows), then of parameters."""
        m, free = len(self.system.mass), len(self.system.mass) - 1
        start = np.zeros((starts, free)) if isinstance(starts, int) else starts
        none = np.zeros((m, self.code.N_PARAMETERS))
        every = [(None, none)] * len(start) + list(changes)
        laws = np.array([law for _, law in every]).reshape(len(every), *none.shape)
        start = np.concatenate([start, np.zeros((len(changes), free))])
        return block_directions(self.system, [plant for plant, _ in every], laws, start)

    def change(self, model: BeltModel, name: str) -> tuple[Reduced | None, Floats]:
        """Change of the model with a parameter: of its plant, or None, and of its laws."""
        laws = np.zeros((model.n_blocks, self.code.N_PARAMETERS))
        owners = model.law_parameters.get(name)
        if owners is None:
            return model.plant_direction(name), laws
        for block, own_name in owners:
            laws[block, self.code.parameter_index(model.laws[block], own_name)] = 1.0
        return None, laws


def block_engine(model: BeltModel, engine: EngineName = "auto") -> BlockEngine:
    """Prepare the engine for a model; ValueError for "exact", or a law that cannot be traced."""
    if one_of("engine", engine, ENGINES) == "exact":
        raise ValueError(
            "engine = 'exact' is that of two equal undamped blocks with constant friction; other "
            "models have one engine, whose series are exact to rounding. Take engine='auto'."
        )
    code, rows = _code_and_rows(model.laws)
    if not code.traceable:
        raise ValueError(
            "a friction law of this model cannot be traced, and models of many blocks need its "
            "series: write the law with arithmetic and numpy functions, without branches."
        )
    plant = model.plant
    key = f"blocks-{code.key}" + "-coupled" * plant.is_coupled + "-feet" * bool(plant.elastic)
    return BlockEngine(
        key=key,
        kernels=_stepper_of(code, key, plant.is_coupled, bool(plant.elastic)),
        code=code,
        system=block_system(plant),
        laws=rows.copy(),
    )


@lru_cache(maxsize=64)
def _stepper_of(code: LawCode, key: str, coupled: bool, feet: bool) -> ModuleType:
    bindings: dict[str, Any] = {role: getattr(code, role) for role in LAW_KERNELS}
    bindings["least_slope"] = sliding_kernels(code).least_slope
    return instantiate(STEPPER, key, COUPLED=coupled, FEET=feet, **bindings)
