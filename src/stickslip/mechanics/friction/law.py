"""The contract of a kinetic friction law: one-sided, relative to the block's static limit."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from functools import cached_property
from numbers import Real
from typing import Annotated, Any, ClassVar, Self, get_args, get_origin, get_type_hints, overload

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import Many, flag, instance, model_number, real_numbers, shown
from stickslip.mechanics.friction.formula import Formula, TracedFormula, builtin_formula, quietly
from stickslip.numerics.arrays import Floats
from stickslip.vocabulary import did_you_mean


@dataclasses.dataclass(frozen=True)
class Range:
    """Values that a parameter may have; stands in the annotation of its field."""

    low: float
    high: float = math.inf
    above: bool = False


@dataclasses.dataclass(frozen=True)
class Choice:
    """A field that selects between formulas and takes one of a few values."""

    values: tuple[int, ...]


NonNegative = Annotated[float, Range(0.0)]
Positive = Annotated[float, Range(0.0, above=True)]
Share = Annotated[float, Range(0.0, 1.0)]


# F(0) this close to 0 or 1 is taken for it: (1 - delta) / 1 + delta rounds.
AT_LIMIT = 4 * np.finfo(float).eps

# Annotated fields of each law class; not functools.cache, which asks types for their hash.
_fields: dict[type[Any], dict[str, Range | Choice]] = {}
_parameter_names: dict[type[Any], tuple[str, ...]] = {}


@dataclasses.dataclass(frozen=True)
class FrictionLaw:
    """Kinetic friction F(s) of a block that slips with speed ``s = |w| >= 0`` on the belt.

    The force is divided by the block's static limit and opposes the slip, so that a block
    with limit L feels ``-sign(w) L F(|w|)``; ``0 <= F(0) <= 1``. Laws are immutable values:
    equal parameters make equal laws.

    A law of its own is a subclass: a frozen dataclass whose fields are annotated with the
    range of each parameter, and the equation as one static method ``expression``.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> import stickslip as ss
    >>> from stickslip.mechanics.friction.law import NonNegative
    >>> @dataclass(frozen=True)
    ... class Falling(ss.FrictionLaw):
    ...     rate: NonNegative
    ...     @staticmethod
    ...     def expression(s, rate):
    ...         return 1 / (1 + rate * s)
    >>> Falling(rate=2.0).force([0.0, 0.5])
    array([1. , 0.5])
    """

    name: ClassVar[str] = ""

    def __post_init__(self) -> None:
        """Check the parameters, then F(0)."""
        if type(self) is FrictionLaw:
            raise TypeError(
                "FrictionLaw has no equation: take one of its subclasses, such as ss.Coulomb, or "
                "ss.friction_law(force) for a law of your own."
            )
        for name, allowed in self.fields().items():
            object.__setattr__(self, name, self._checked(name, allowed))
        self._check_static_value()

    def _checked(self, name: str, allowed: Range | Choice) -> float:
        value = getattr(self, name)
        owner = f"the friction law {self.name}"
        if isinstance(allowed, Range):
            above = allowed.low if allowed.above else -math.inf
            low, high = allowed.low, allowed.high
            return model_number(name, value, above=above, at_least=low, at_most=high, of=owner)
        is_number = isinstance(value, Real) and not isinstance(value, bool)
        if not is_number or value not in allowed.values:
            choices = " or ".join(map(str, allowed.values))
            raise ValueError(
                f"{name} = {shown(value)} of {owner} is not allowed: {name} must be {choices}."
            )
        return int(value)

    def _check_static_value(self) -> None:
        for value in self._at_rest:
            if not -AT_LIMIT <= value <= 1.0 + AT_LIMIT:
                raise ValueError(
                    f"F(0) = {value!r} of the friction law {self.title}; allowed: 0 <= F(0) <= 1, "
                    "relative to the static limit (a block that starts to slip never feels more "
                    "than that limit: if forces were measured, raise the limit that they are "
                    "divided by)"
                )

    # --- parameters -----------------------------------------------------------------------

    @classmethod
    def fields(cls) -> dict[str, Range | Choice]:
        """Return what the constructor takes, and the values it allows."""
        if cls not in _fields:
            hints = get_type_hints(cls, include_extras=True)
            _fields[cls] = {
                field.name: get_args(hints[field.name])[1]
                for field in dataclasses.fields(cls)
                if get_origin(hints[field.name]) is Annotated
            }
        return _fields[cls]

    @classmethod
    def parameter_names(cls) -> tuple[str, ...]:
        """Names of all real parameters of the formula."""
        if cls not in _parameter_names:
            kinds = cls.fields().items()
            _parameter_names[cls] = tuple(n for n, kind in kinds if isinstance(kind, Range))
        return _parameter_names[cls]

    @classmethod
    def from_values(cls, values: Mapping[str, float]) -> Self:
        """Make the law with these fields; ValueError names one that is unknown or missing."""
        known = cls.fields()
        for name in instance("values", values, Mapping, "parameters by name"):
            if name not in known:
                raise ValueError(
                    f"friction law {cls.name} has no parameter {shown(name)}. "
                    f"{did_you_mean(name, known)}"
                )
        for field in dataclasses.fields(cls):
            if field.name not in values and field.default is dataclasses.MISSING:
                raise ValueError(
                    f"friction law {cls.name} needs a value for {field.name!r} "
                    f"(parameters: {', '.join(known)})"
                )
        return cls(**values)

    @property
    def arguments(self) -> dict[str, float]:
        """Value of every real parameter of the formula."""
        return {name: getattr(self, name) for name in self.parameter_names()}

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters by name, as they appear among a model's parameters."""
        return self.arguments

    @property
    def options(self) -> dict[str, int]:
        """Choices between formulas: fields that are no real parameters."""
        fields = self.fields().items()
        return {name: getattr(self, name) for name, kind in fields if isinstance(kind, Choice)}

    @property
    def names(self) -> tuple[str, ...]:
        """Everything `replace` accepts."""
        return (*self.arguments, *self.options)

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some parameters changed; without changes, the law itself.

        Raises
        ------
        ValueError
            The law has no parameter of that name, or the value is not allowed.
        """
        for name in changes:
            if name not in self.names:
                raise ValueError(
                    f"friction law {self.title} has no parameter {shown(name)}. "
                    f"{did_you_mean(name, self.names)}"
                )
        return self._replaced(changes) if changes else self

    def _replaced(self, changes: dict[str, Any]) -> Self:
        return dataclasses.replace(self, **changes)

    def __str__(self) -> str:
        """Write the law as ``parse_law`` reads it."""
        values = {**self.parameters, **self.options}
        return f"{self.title}:" + ",".join(f"{name}={value!r}" for name, value in values.items())

    @property
    def title(self) -> str:
        """What messages call the law."""
        return self.name

    # --- the equation ---------------------------------------------------------------------

    @property
    def formula(self) -> Formula:
        """The equation, apart from the values of its parameters."""
        options = tuple(self.options.items())
        return builtin_formula(self.expression, self.parameter_names(), options)

    @staticmethod
    def expression(s: Any, *parameters: Any) -> Any:
        """Return F(s), by operations and functions of `numpy` only."""
        raise NotImplementedError

    @property
    def traceable(self) -> bool:
        """Whether Taylor series can be made of the law."""
        return isinstance(self.formula, TracedFormula)

    @property
    def symmetric(self) -> bool:
        """Whether the force is the same in both directions of slip."""
        return self.formula.symmetric

    @property
    def pieces(self) -> tuple[tuple[float, Mapping[str, float]], ...]:
        """Where each smooth piece of the law ends, ascending, and its numbers in the formula."""
        return ((math.inf, self.arguments),)

    @property
    def knots(self) -> tuple[float, ...]:
        """Speeds at which the law is not smooth; a crossing ends an integration step."""
        return tuple(end for end, _ in self.pieces[:-1])

    @overload
    def force(self, s: float, *, forward: bool = ...) -> float: ...
    @overload
    def force(self, s: Many, *, forward: bool = ...) -> Floats: ...
    @overload
    def force(self, s: ArrayLike, *, forward: bool = ...) -> float | Floats: ...
    def force(self, s: ArrayLike, *, forward: bool = False) -> float | Floats:
        """Friction force over the static limit.

        Parameters
        ----------
        s : array_like of float
            Slip speeds ``|w| >= 0``, dimensionless.
        forward : bool
            For a block faster than the belt (w > 0); differs in asymmetric laws only.

        Returns
        -------
        float or ndarray
            F(s) of the same shape as `s`.

        Raises
        ------
        ValueError
            Some speed is negative or NaN.
        """
        return self._over_speeds(self._force, s, flag("forward", forward))

    @overload
    def slope(self, s: float, *, forward: bool = ...) -> float: ...
    @overload
    def slope(self, s: Many, *, forward: bool = ...) -> Floats: ...
    @overload
    def slope(self, s: ArrayLike, *, forward: bool = ...) -> float | Floats: ...
    def slope(self, s: ArrayLike, *, forward: bool = False) -> float | Floats:
        """dF/ds; arguments as in `force`."""
        return self._over_speeds(self._slope, s, flag("forward", forward))

    def static_value(self, *, forward: bool = False) -> float:
        """F(0), exactly 0 or 1 where it differs from them by rounding only."""
        value = self._at_rest[flag("forward", forward)]
        for limit in (0.0, 1.0):
            if abs(value - limit) <= AT_LIMIT:
                return limit
        return value

    @cached_property
    def _at_rest(self) -> tuple[float, float]:
        """F(0) of backward and of forward slip, as computed."""
        backward, forward = (
            float(quietly(self._force, np.float64(0.0), forward)) for forward in (False, True)
        )
        return backward, forward

    def _force(self, s: Any, forward: bool) -> Any:
        assert isinstance(self.formula, TracedFormula)
        return self.formula.force(s, self.arguments, forward)

    def _slope(self, s: Any, forward: bool) -> Any:
        assert isinstance(self.formula, TracedFormula)
        return self.formula.slope(s, self.arguments, forward)

    def _over_speeds(self, function: Any, s: ArrayLike, forward: bool) -> Any:
        speeds = real_numbers("s", s)
        bad = ~(speeds >= 0.0)
        if bad.any():
            value = float(speeds[bad].flat[0])
            raise ValueError(
                f"s = {value!r}; allowed: s >= 0 (laws are functions of the slip speed s = |w|)"
            )
        values = quietly(function, speeds, forward)
        result = np.empty_like(speeds)
        result[...] = values
        return result if speeds.ndim else float(result)
