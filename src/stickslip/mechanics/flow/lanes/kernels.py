"""Kernels that step many lanes."""

from __future__ import annotations

from types import ModuleType

from stickslip.mechanics.flow.lanes.text import lanes_text
from stickslip.mechanics.friction.series import LawSeries
from stickslip.numerics.targets import generated_module


def lane_kernels(series: LawSeries) -> ModuleType:
    """Make ``step_one``, ``step_both``, ``tangent_one``, ``tangent_both`` and ``SIZE``."""
    return generated_module("lanes", series.key, lambda: lanes_text(series.force, series.slope))
