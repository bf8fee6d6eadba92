"""Numbers with an error, written for readers."""

from __future__ import annotations

import math


def digits(number: float, error: float) -> str:
    """Write a number to the decimal place of its error.

    Parameters
    ----------
    number : float
        What was computed.
    error : float
        Its absolute error; 0 for all 17 digits.

    Returns
    -------
    str
        Without exponent; in full precision where either is not finite.
    """
    if not math.isfinite(number) or not math.isfinite(error):
        return f"{number:.17g}"
    places = 17 if error <= 0.0 else min(17, max(0, math.ceil(-math.log10(error))))
    return f"{number:.{places}f}"


def with_error(number: float, error: float) -> str:
    """Write a number to the decimal place of its error, and the error."""
    return f"{digits(number, error)} ± {error:.0e}"
