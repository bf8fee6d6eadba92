"""Zeros of a condition along one number: bracketed, or from a guess."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from stickslip.analysis.one_d.conditions import Condition, Reading
    from stickslip.analysis.protocol import Map1D

__all__ = ["Located", "solve", "solve_near"]

MapAt: TypeAlias = "Callable[[float], Map1D]"


@dataclass(frozen=True)
class Located:
    """A zero of a condition.

    Attributes
    ----------
    value : float
    error : float
        (abs(test function) + noise) / abs(slope), at least 2 ulp.
    residual : float
        Test function at `value`.
    interval : tuple of float
        Contains the zero: the last bracket, or ``value`` minus and plus ``error``.
    quality : str
        ``located``, ``bracketed`` or ``failed``.
    slope : float
        Of the test function.
    reading : Reading
        At `value`.
    """

    value: float
    error: float
    residual: float
    interval: tuple[float, float]
    quality: str
    slope: float
    reading: Reading


def solve(condition: Condition, at: MapAt, low: float, high: float) -> Located:
    """Find the zero of a condition between two numbers where its signs differ.

    Raises
    ------
    ConditionLost
        It does not exist all over the bracket.
    ValueError
        The signs at the ends agree.
    """
    raise NotImplementedError


def solve_near(
    condition: Condition,
    at: MapAt,
    guess: float,
    *,
    step: float,
    within: tuple[float, float] | None = None,
) -> Located:
    """Find the zero of a condition close to a guess.

    Parameters
    ----------
    step : float
        How far off the guess may be; also the first step of the secant.
    within : pair of float, optional
        Never evaluated outside.

    Raises
    ------
    ConditionLost
        It does not exist, or there is no zero nearby.
    """
    raise NotImplementedError
