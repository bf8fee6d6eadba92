"""From models with n blocks to kernels: the stepper of their laws, their numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.flow.blocks.system import (
    BlockSystem,
    BlockWork,
    block_system,
    new_block_work,
)
from stickslip.mechanics.flow.engine import LAW_KERNELS, sliding_kernels
from stickslip.mechanics.friction.code import LawCode, law_code
from stickslip.numerics.targets import instantiate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.belt_model import BeltModel
    from stickslip.mechanics.model.two_block import TwoBlock

STEPPER = "stickslip.mechanics.flow.blocks._stepper_kernels"


@dataclass(frozen=True, eq=False)
class BlockEngine:
    """Kernels that move a model with n blocks, and the model in the form that they take."""

    key: str  # equal keys, equal machine code
    kernels: ModuleType  # advance, landing_rate, slides_for_ever, ORDER
    code: LawCode
    system: BlockSystem
    laws: NDArray[np.float64]  # parameter rows, (n, columns)

    def new_work(self) -> BlockWork:
        """Scratch arrays of the kernels for one motion."""
        return new_block_work(len(self.system.mass), self.code.N_ROWS, self.kernels.ORDER)


def block_engine(model: BeltModel | TwoBlock) -> BlockEngine:
    """Prepare the engine for a model; ValueError for a law that cannot be traced."""
    code = law_code(model.laws)
    if not code.traceable:
        raise ValueError(
            "a friction law of this model cannot be traced, and models of many blocks need its "
            "series: write the law with arithmetic and numpy functions, without branches."
        )
    return BlockEngine(
        key=f"blocks-{code.key}",
        kernels=_kernels(code),
        code=code,
        system=block_system(model.structure),
        laws=code.parameter_rows(model.laws),
    )


@lru_cache(maxsize=64)
def _kernels(code: LawCode) -> ModuleType:
    bindings = {role: getattr(code, role) for role in LAW_KERNELS}
    bindings["least_slope"] = sliding_kernels(code).least_slope
    return instantiate(STEPPER, f"blocks-{code.key}", **bindings)
