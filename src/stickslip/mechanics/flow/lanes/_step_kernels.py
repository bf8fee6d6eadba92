"""One step of all lanes, and of its tangents, written from a law's series (`steps`)."""

# Template (`numerics.targets.instantiate`): the code is bound. `step_one`, `tangent_one` and
# `turns_one` are for motions of which one block slips and the other rides, `step_both` and so on
# for those of which both slip. `p` and `q` are the laws' parameters, `c` the contacts' numbers.

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.targets import kernel
from stickslip.numerics.vector import wide_vectors

if TYPE_CHECKING:

    def write_step_one(x: Floats, taken: Floats, p: Floats, q: Floats, c: Floats) -> None: ...

    write_step_both = write_tangent_one = write_tangent_both = write_step_one

    def write_turns_one(x: Floats, taken: Floats, c: Floats) -> None: ...

    write_turns_both = write_turns_one


@kernel(fused=True)
def step_one(x: Floats, taken: Floats, p: Floats, q: Floats, c: Floats) -> None:
    """Step lanes of which the first block slips; the second rides."""
    wide_vectors()
    write_step_one(x, taken, p, q, c)


@kernel(fused=True)
def step_both(x: Floats, taken: Floats, p: Floats, q: Floats, c: Floats) -> None:
    """Step lanes of which both blocks slip."""
    wide_vectors()
    write_step_both(x, taken, p, q, c)


@kernel(fused=True)
def tangent_one(x: Floats, taken: Floats, p: Floats, q: Floats, c: Floats) -> None:
    """Carry derivatives through the step that `step_one` has taken."""
    wide_vectors()
    write_tangent_one(x, taken, p, q, c)


@kernel(fused=True)
def tangent_both(x: Floats, taken: Floats, p: Floats, q: Floats, c: Floats) -> None:
    """Carry derivatives through the step that `step_both` has taken."""
    wide_vectors()
    write_tangent_both(x, taken, p, q, c)


@kernel(fused=True)
def turns_one(x: Floats, taken: Floats, c: Floats) -> None:
    """Flag lanes in which a signal may have turned back on the step that `step_one` has taken."""
    wide_vectors()
    write_turns_one(x, taken, c)


@kernel(fused=True)
def turns_both(x: Floats, taken: Floats, c: Floats) -> None:
    """Flag lanes in which a signal may have turned back on the step that `step_both` has taken."""
    wide_vectors()
    write_turns_both(x, taken, c)
