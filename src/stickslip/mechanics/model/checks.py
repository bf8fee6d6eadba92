"""One place where a model's numbers are checked, so that every message reads alike."""

from __future__ import annotations

from math import inf, isfinite
from numbers import Real

import numpy as np

__all__ = ["finite_number"]


def finite_number(
    name: str,
    value: object,
    *,
    above: float = -inf,
    at_least: float = -inf,
    why: str,
    remedy: str = "",
) -> float:
    """Return a parameter as a float, or say what is wrong with it.

    Parameters
    ----------
    name : str
        The parameter, as the user wrote it.
    value : object
        What arrived. Python and numpy real scalars are accepted, except bools.
    above, at_least : float, optional
        Exclusive and inclusive lower bound.
    why : str
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
    if above > -inf:
        allowed = f"a finite number > {above:g}"
    elif at_least > -inf:
        allowed = f"a finite number >= {at_least:g}"
    else:
        allowed = "a finite number"
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise ValueError(
            f"{name} = {value!r} ({type(value).__name__}) is not a real number: "
            f"{name} must be {allowed}. Give one Python or numpy number, not an array or text."
        )
    try:
        number = float(value)
    except OverflowError:
        number = inf
    if isfinite(number) and number > above and number >= at_least:
        return number + 0.0  # no negative zero
    shown = repr(number if hasattr(value, "dtype") else value)
    if len(shown) > 24:  # an integer beyond the floats
        shown = f"{shown[:12]}... ({len(shown)} digits)"
    remedy = remedy or f"Give {name} a value in that range."
    raise ValueError(f"{name} = {shown} is not allowed: {name} must be {allowed}. {why} {remedy}")
