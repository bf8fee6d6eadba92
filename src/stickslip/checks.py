"""One place where numbers are checked, so that every message reads alike."""

from __future__ import annotations

from math import inf, isfinite
from numbers import Real
from typing import Any

import numpy as np

__all__ = ["checked_interval", "finite_number"]


def finite_number(
    name: str,
    value: object,
    *,
    above: float = -inf,
    at_least: float = -inf,
    at_most: float = inf,
    of: str = "",
    why: str = "",
    remedy: str = "",
) -> float:
    """Return a parameter as a float, or say what is wrong with it.

    Parameters
    ----------
    name : str
        The parameter, as the user wrote it.
    value : object
        What arrived. Python and numpy real scalars are accepted, except bools.
    above, at_least, at_most : float, optional
        Exclusive and inclusive lower bound, inclusive upper bound.
    of : str, optional
        Whose parameter it is, where that needs saying: ``"the friction law coulomb"``.
    why : str, optional
        Reason for the range, a full sentence.
    remedy : str, optional
        What to do instead; by default, to give a number in the range.

    Returns
    -------
    float
        The value, finite and in range.

    Raises
    ------
    ValueError
        Not a real scalar, not finite, or out of range.
    """
    allowed = f"a finite number{_range(name, above, at_least, at_most)}"
    whose = f" of {of}" if of else ""
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise ValueError(
            f"{name} = {value!r} ({type(value).__name__}){whose} is not a real number: "
            f"{name} must be {allowed}. Give one number, not an array or text."
        )
    try:
        number = float(value)
    except OverflowError:
        number = inf
    if isfinite(number) and number > above and at_least <= number <= at_most:
        return number + 0.0  # no negative zero
    shown = repr(number if hasattr(value, "dtype") else value)
    if len(shown) > 24:  # an integer beyond the floats
        shown = f"{shown[:12]}... ({len(shown)} digits)"
    sentences = [why, remedy or f"Give {name} a value in that range."]
    told = " ".join(filter(None, sentences))
    raise ValueError(f"{name} = {shown}{whose} is not allowed: {name} must be {allowed}. {told}")


def _range(name: str, above: float, at_least: float, at_most: float) -> str:
    low, sign = (above, "<") if above > -inf else (at_least, "<=")
    if at_most < inf:
        return f", {low:g} {sign} {name} <= {at_most:g}"
    return "" if low == -inf else f" {sign.replace('<', '>')} {low:g}"


def checked_interval(name: str, ends: Any) -> tuple[float, float]:
    """Return the ends of an interval as floats.

    Raises
    ------
    ValueError
        Not a pair of finite numbers in ascending order; ``name`` is what the user called it.
    """
    try:
        low, high = (float(end) for end in ends)
    except (TypeError, ValueError) as reason:
        raise ValueError(f"{name} = {ends!r}: a pair of numbers (lo, hi) is needed.") from reason
    if not (isfinite(low) and isfinite(high) and low < high):
        raise ValueError(
            f"{name} = ({low:.12g}, {high:.12g}): finite ends with lo < hi are needed."
        )
    return low, high
