"""Signatures of the generated steps of lanes, for the type checker alone: see `lanes.text`."""

from __future__ import annotations

from stickslip.mechanics.flow.system import Floats

SIZE: int


def step_one(
    x: Floats,
    taken: Floats,
    p: Floats,
    q: Floats,
    c: Floats,
    log_rtol: float,
) -> None:
    """Step lanes of which the first block slips; the second rides."""
    raise NotImplementedError


step_both = tangent_one = tangent_both = step_one
