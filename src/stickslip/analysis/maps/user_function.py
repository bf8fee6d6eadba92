"""A user's function of a point and of named parameters: how to call it, and what it returns."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final, Self, TypeAlias

import numpy as np

from stickslip.checks import finite_number, instance, parameter_name, shown
from stickslip.results.parts import equal

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels

Function: TypeAlias = Callable[..., Any]

LARGEST_LABEL: Final = 2.0 ** (np.iinfo(np.int64).bits - 2)


class UserMap:
    """What maps by a user's function have in common: it, and parameters with names."""

    _func: Function
    _parameters: dict[str, float]
    _moved: set[str]  # parameters that `replace` has moved once, of all copies

    @property
    def func(self) -> Function:
        """The function, as given."""
        return self._func

    @property
    def parameters(self) -> dict[str, float]:
        """Names and values; a copy."""
        return dict(self._parameters)

    def replace(self, **changes: float) -> Self:
        """Return the same map with other parameter values.

        Raises
        ------
        ValueError
            A name is not one of the map's parameters, a value is not a finite number, a callable
            fails on the new values, or a given derivative does not follow a parameter.
        """
        for name in changes:
            self._check_name(name)
        other = copy.copy(self)
        other._parameters = {**self._parameters, **checked_parameters(changes)}
        other._adapt()
        # The first time that each moves: to check takes a hundred times as long as to copy.
        now, before = other._parameters, self._parameters
        moved = {name for name in changes if now[name] != before[name]} - self._moved
        if moved:
            other._check_derivatives()
            self._moved |= moved
        return other

    def _adapt(self) -> None:
        """Find anew what depends on the parameters' values."""

    def _check_derivatives(self) -> None:
        """Refuse given derivatives that are not those of the values."""
        raise NotImplementedError

    def __eq__(self, other: object) -> bool:
        """Whether another map has the same functions, domain and parameters."""
        return isinstance(other, type(self)) and equal(self._given, other._given)

    def __hash__(self) -> int:
        return hash((id(self._func), *self._parameters.values()))

    @property
    def _given(self) -> tuple[Any, ...]:
        """What makes two maps the same."""
        raise NotImplementedError

    def _check_name(self, name: object) -> None:
        parameter_name("name", name, self._parameters, of=self)

    def _shown(self) -> tuple[str, str]:
        """Name of the function, and the parameters with a comma before each."""
        values = "".join(f", {key}={value:.12g}" for key, value in self._parameters.items())
        return getattr(self._func, "__name__", type(self._func).__name__), values


def apply(func: Function, x: Floats, parameters: Mapping[str, float], in_arrays: bool) -> Floats:
    """Evaluate a callable at points, shape (n,), as one array or one number at a time."""
    with np.errstate(all="ignore"):
        if not in_arrays:
            return np.array([float(func(float(v), **parameters)) for v in x], dtype=np.float64)
        result = np.asarray(func(x, **parameters), dtype=np.float64)
    # A constant branch may come back as one number.
    return np.broadcast_to(result, x.shape).astype(np.float64)


def takes_arrays(role: str, func: Function, x: Floats, parameters: Mapping[str, float]) -> bool:
    """Tell whether a callable works elementwise on arrays; a ValueError if it works in no way."""
    checked_callable(role, func)
    try:
        one_by_one = apply(func, x, parameters, in_arrays=False)
    except Exception as reason:
        name = getattr(func, "__name__", type(func).__name__)
        keywords = "".join(f", {each}=..." for each in parameters)
        raise ValueError(
            f"{role} = {name}: the call {name}(x{keywords}) failed at "
            f"x = {x[0]:.6g} with {type(reason).__name__}: {reason}. It must accept a "
            "point of the domain and every parameter by its name, and return a number."
        ) from reason
    try:
        together = apply(func, x, parameters, in_arrays=True)
    except Exception:  # any failure on arrays means: one number at a time
        return False
    return bool(np.allclose(together, one_by_one, rtol=1e-12, atol=0, equal_nan=True))


def checked_callable(role: str, func: object) -> None:
    """Refuse what cannot be called."""
    if not callable(func):
        raise ValueError(
            f"{role} = {shown(func)} cannot be called: a function of the point and of the "
            "parameters by name is needed."
        )


def as_labels(numbers: NDArray[Any]) -> Labels:
    """Turn whole numbers of any type into labels; those of a gap, NaN, mean nothing."""
    if numbers.dtype == np.uint64:
        return numbers.copy()
    if numbers.dtype.kind == "f":
        # Beyond the integers, one label for all.
        numbers = np.clip(np.nan_to_num(numbers), -LARGEST_LABEL, LARGEST_LABEL)
    # Labels may be negative: two's complement keeps them apart.
    return numbers.astype(np.int64).astype(np.uint64)


def checked_parameters(parameters: Mapping[str, float]) -> dict[str, float]:
    """Return parameters as floats; refuse any that is not finite."""
    instance("parameters", parameters, Mapping, 'names with their values, {"r": 3.5}')
    for name in parameters:
        instance("a name in parameters", name, str, "text")
    return {name: finite_number(name, value) for name, value in parameters.items()}
