"""One place where numbers are checked, so that every message reads alike."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import inf, isfinite, log10, nan
from numbers import Real
from reprlib import Repr
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from stickslip.vocabulary import did_you_mean

Floats: TypeAlias = NDArray[np.float64]
Many: TypeAlias = NDArray[Any] | Sequence[Any]
"""Points of which values come back as an array, unlike that of a float."""

T = TypeVar("T")

LARGEST_COUNT: Final = 2**63 - 1
MOST_STEPS: Final = 10**10
"""Of one orbit: what is kept of it would fill a large memory."""
MOST_KEPT: Final = 10**6
"""Of points, starts, values, periods: each is kept, and costs a computation of its own."""
MOST_VALUES: Final = 10**8
"""Of a grid."""
LARGEST: Final = 1e100
"""In size, of the numbers of a model."""
SMALLEST: Final = 1.0 / LARGEST
"""Of the numbers of a model that must be positive: it divides by them."""
TOO_LARGE: Final = (
    f"numbers of a model are at most {LARGEST:g} in size, and positive ones at least {SMALLEST:g}, "
    "so that their products are numbers, too. Choose units in which they are nearer to 1."
)
LONGEST: Final = 90
"""Characters of a value that a message shows."""


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
    """Return a parameter as a float in a range, or say what is wrong with it."""
    # `of` says whose parameter it is: "the friction law coulomb". `why` is the reason for the
    # range, a sentence; `remedy` what to do instead of giving a number in the range. Bools are no
    # numbers.
    is_real = isinstance(value, Real) and not isinstance(value, bool)  # nor is NumPy's bool one
    number = _float(value) if is_real else nan
    if isfinite(number) and number > above and at_least <= number <= at_most:
        return number + 0.0  # no negative zero
    allowed = f"a finite number{_range(name, above, at_least, at_most)}"
    whose = f" of {of}" if of else ""
    if not is_real:
        kind = f" ({type(value).__name__})"
        raise ValueError(
            f"{name} = {shown(value).removesuffix(kind)}{kind}{whose} is not a real number: "
            f"{name} must be {allowed}. Give one number, not an array or text."
        )
    given = str(value) if hasattr(value, "dtype") else shown(value)
    sentences = [why, remedy or f"Give {name} a value in that range."]
    told = " ".join(filter(None, sentences))
    raise ValueError(f"{name} = {given}{whose} is not allowed: {name} must be {allowed}. {told}")


def model_number(name: str, value: object, **limits: Any) -> float:
    """Return a number of a model, as `finite_number`, of a size that leaves room to compute."""
    number = finite_number(name, value, **limits)
    if abs(number) > LARGEST or (number < SMALLEST and limits.get("above") == 0.0):
        raise ValueError(f"{name} = {number!r} is not allowed: {TOO_LARGE}")
    return number


def _float(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


def _range(name: str, above: float, at_least: float, at_most: float) -> str:
    low, sign = (above, "<") if above > -inf else (at_least, "<=")
    if at_most < inf:
        return f", {low:g} {sign} {name} <= {at_most:g}"
    return "" if low == -inf else f" {sign.replace('<', '>')} {low:g}"


def whole_number(
    name: str,
    value: Any,
    at_least: int = 1,
    *,
    at_most: int = LARGEST_COUNT,
    what: str = "",
) -> int:
    """Return a count as an int, floats that are whole included, or say what is wrong with it."""
    is_real = isinstance(value, Real) and not isinstance(value, bool)
    try:  # as an int: a short float overflows when it is compared with the bounds
        number = int(value) if is_real else None
    except (OverflowError, ValueError):
        number = None  # infinite, or NaN
    if number is not None and value % 1 == 0 and at_least <= number <= at_most:
        return number
    bounds = f">= {at_least}" if at_most == LARGEST_COUNT else f"from {at_least} to {at_most}"
    counted = f" ({what})" if what else ""
    limit = (
        " that fits into 63 bits"
        if number is not None and number > at_most == LARGEST_COUNT
        else ""
    )
    raise ValueError(
        f"{name} = {shown(value)} is not allowed: {name}{counted} must be a whole number "
        f"{bounds}{limit}."
    )


def real_numbers(name: str, values: object) -> Floats:
    """Return numbers of any shape as floats, NaN included, or say what is not a number."""
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O":  # fractions and the like; what is no number fails here
            refused = [item for item in array.flat if not isinstance(item, Real)]
            array = array if refused else np.array(np.frompyfunc(_float, 1, 1)(array), np.float64)
    except (TypeError, ValueError) as reason:
        raise ValueError(_no_numbers(name, values)) from reason
    masked = isinstance(values, np.ndarray) and np.ma.is_masked(values)  # np.ma takes time to load
    if array.dtype.kind not in "iuf" or masked:
        raise ValueError(_no_numbers(name, values))
    with np.errstate(over="ignore"):  # longer floats may be infinite as floats
        return array.astype(np.float64, copy=False)


def _no_numbers(name: str, values: object) -> str:
    return (
        f"{name} = {shown(values)} is not made of real numbers: {name} must be a number, or an "
        "array of numbers with rows of one length."
    )


def checked_interval(name: str, ends: Any) -> tuple[float, float]:
    """Return the ends of an interval, finite and ascending, as floats."""
    try:
        low, high = ends
    except (TypeError, ValueError) as reason:
        raise ValueError(
            f"{name} = {shown(ends)}: a pair of numbers (lo, hi) is needed."
        ) from reason
    low, high = finite_number(f"{name}[0]", low), finite_number(f"{name}[1]", high)
    if not low < high:
        raise ValueError(
            f"{name} = ({low:.12g}, {high:.12g}): finite ends with lo < hi are needed."
        )
    return low, high


def one_each(name: str, given: Any, n: int, what: str = "") -> list[Any]:
    """Return a list with an entry for each of n things, coordinates if nothing else is said."""
    if np.iterable(given) and len(listed := list(given)) == n:
        return listed
    what = what or f"coordinate of a point (dimension = {n})"
    raise ValueError(f"{name} = {shown(given)} must hold {n} entries, one for each {what}.")


def grid(name: str, given: Any) -> Floats:
    """Return values of a parameter: a tuple ``(lo, hi, n)`` is a grid, anything else the values."""
    # Everywhere else a range is a pair ``(lo, hi)``. Whether the values must ascend, the caller
    # says.
    if isinstance(given, tuple):
        if len(given) != 3 or not isinstance(given[2], int | np.integer):
            raise ValueError(  # three floats look like values
                f"{name} = {shown(given)} is not allowed: a tuple is a grid (lo, hi, n) of n "
                "values, a whole number. Write the values themselves as a list, [...]."
            )
        ends = zip(("lo", "hi"), given, strict=False)
        whole = f"{name} = {shown(given)}"
        lo, hi = (finite_number(end, value, of=whole) for end, value in ends)
        what = f"values of {whole}"
        return np.linspace(lo, hi, whole_number("n", given[2], 2, at_most=MOST_VALUES, what=what))
    values = real_numbers(name, given)
    if values.ndim != 1 or values.size == 0 or not np.isfinite(values).all():
        raise ValueError(
            f"{name} = {shown(given)} is not allowed: a grid (lo, hi, n) or a list of finite "
            "numbers is needed."
        )
    return values


def dimensions(values: object) -> int:
    """Return the number of axes, 0 for a number; -1 for rows of different lengths."""
    try:
        return np.ndim(values)  # type: ignore[arg-type]
    except ValueError:
        return -1


def one_of(name: str, value: object, choices: Collection[str], *, remedy: str = "") -> str:
    """Return a word that must be one of a few; an error suggests the closest."""
    if isinstance(value, str) and value in choices:
        return value
    told = " ".join(filter(None, [did_you_mean(value, choices), remedy]))
    raise ValueError(f"{name} = {shown(value)} is unknown. {told}")


def parameter_name(role: str, name: object, known: Collection[str], *, of: object = None) -> str:
    """Return the name of a parameter among those known; an error suggests the closest."""
    if isinstance(name, str) and name in known:
        return name
    whose = "" if of is None else f" of {of}"
    told = did_you_mean(name, known)
    raise ValueError(f"{role} = {shown(name)} is not a parameter{whose}. {told}")


def instance(name: str, value: Any, kinds: type[T] | tuple[type[Any], ...], what: str) -> T:
    """Return an object of one of some classes, or say `what` is needed."""
    if isinstance(value, kinds):
        return value
    raise ValueError(f"{name} = {shown(value)} is not {what}.")


def random_generator(name: str, rng: Any) -> np.random.Generator:
    """Return a generator, that of a seed, or a fresh one for None."""
    # Other things that numpy takes, or fails on, are no seeds here: a TypeError.
    allowed = (
        f"{name} = {shown(rng)} is not allowed: {name} must be None, a seed (a whole number >= 0) "
        "or a numpy.random.Generator."
    )
    is_seed = isinstance(rng, int | np.integer) and not isinstance(rng, bool)
    if not (rng is None or is_seed or isinstance(rng, np.random.Generator)):
        raise TypeError(allowed)
    if is_seed and rng < 0:
        raise ValueError(allowed)
    return np.random.default_rng(int(rng) if is_seed else rng)


def flag(name: str, value: object) -> bool:
    """Return a switch, True or False alone."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise ValueError(f"{name} = {shown(value)} is not allowed: {name} must be True or False.")


def check_callback(name: str, value: object, what: str) -> None:
    """Check a function that is called on the way, or None."""
    if value is not None and not callable(value):
        raise ValueError(f"{name} = {shown(value)} cannot be called: give a function of {what}.")


class _Brief(Repr):
    """The beginning of a repr, however long or deep the whole may be."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = 2 * LONGEST  # `shown` cuts these at their end
        self.maxtuple = self.maxlist = self.maxarray = self.maxdict = self.maxset = 16

    def repr_int(self, x: int, level: int) -> str:
        """Show the first digits of a long number: Python does not write very long ones."""
        if abs(x) < 10**24:
            return repr(x)
        if abs(x) < 10**4000:
            return f"{str(x)[:12]}... ({len(str(abs(x)))} digits)"
        return f"a whole number of about {x.bit_length() * log10(2):.0f} digits"


_brief: Final = _Brief()


def shown(value: object) -> str:
    """Repr of what a user gave, short enough for one line of a message."""
    text = " ".join(_brief.repr(value).split())
    if len(text) > LONGEST:
        text = f"{text[: LONGEST - 3]}..."
    kind = type(value).__name__
    is_plain = value is None or isinstance(value, bool | int | float | str)
    return text if is_plain or text.startswith(("<", kind)) else f"{text} ({kind})"
