"""Friction laws that a user writes as a plain Python function."""

from __future__ import annotations

import copy
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, ClassVar, Self

import numpy as np

from stickslip.mechanics.friction.code import compiled, pointwise
from stickslip.mechanics.friction.formula import (
    CallableFormula,
    Formula,
    TracedFormula,
    UserFunction,
    quietly,
    traced_formula,
)
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.mechanics.friction.ranges import real, unknown_name
from stickslip.numerics.expression import NotTraceable
from stickslip.numerics.tracing import plain_function

# A law is tried at these speeds when it is made.
SAMPLE = (0.0, *(float(s) for s in np.geomspace(1e-6, 10.0, 50)))
# What a trace, or a slope given with the law, may differ from the law's own values.
AGREEMENT = 1e-9
SLOPE_AGREEMENT = 1e-6


def friction_law(
    force: Callable[..., float],
    *,
    parameters: Mapping[str, float] | None = None,
    slope: Callable[..., float] | None = None,
    forward: Callable[..., float] | None = None,
) -> UserLaw:
    """Make a friction law of a plain Python function.

    Parameters
    ----------
    force : callable
        ``force(s, a, ...)``: kinetic friction over the static limit at the slip speed
        ``s >= 0``, with ``0 <= F(0) <= 1``. It opposes the slip.
    parameters : mapping of str to float, optional
        The named parameters and their values. They count among a model's parameters.
    slope : callable, optional
        ``slope(s, a, ...)``, dF/ds. Needed only where the law cannot be differentiated
        exactly, see Notes; differences are the default there.
    forward : callable, optional
        A different law for a block that is faster than the belt.

    Returns
    -------
    UserLaw

    Raises
    ------
    ValueError
        The parameters do not fit the functions; the law is not finite for 0 <= s <= 10; F(0)
        is outside [0, 1]; the law can be neither recorded as a formula nor compiled.

    Notes
    -----
    A law made of arithmetic and the usual functions of `numpy` or `math` is recorded as a
    formula by calling it once with a number-like argument: slope, parameter derivatives and
    Taylor series are exact then, and kernels are kept between runs. A law that does anything
    else, such as branch on `s`, is compiled as it stands, once per process. Exponents: ``s**2``
    is recorded; ``s**a`` with a parameter `a`, which may make F singular at s = 0, is compiled.

    Examples
    --------
    >>> law = friction_law(lambda s, a: a + (1 - a) / (1 + s), parameters={"a": 0.3})
    >>> law.force(1.0)
    0.65
    """
    values = tuple((parameters or {}).items())
    return UserLaw(force, values, slope, forward)


@dataclass(frozen=True, repr=False)
class UserLaw(FrictionLaw):
    """What `friction_law` makes."""

    name: ClassVar[str] = "user"

    function: Callable[..., float]
    values: tuple[tuple[str, float], ...]
    slope_function: Callable[..., float] | None = None
    forward_function: Callable[..., float] | None = None
    _traced: TracedFormula | None = field(init=False, compare=False, default=None)
    _formula: Formula = field(init=False, compare=False)

    def __post_init__(self) -> None:
        """Check the functions and values, then record the law or compile it."""
        values = tuple((name, self._value(name, value)) for name, value in self.values)
        self._set("values", values)
        callable_formula = self._callable_formula()
        self._check_sample(callable_formula)
        try:
            traced = self._trace(callable_formula)
            self._set("_traced", traced)
            self._set("_formula", traced)
            self._check_slope(callable_formula)
        except NotTraceable as reason:
            self._set("_formula", callable_formula)
            self._compile(str(reason))
        self._check_static_value()

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    @property
    def title(self) -> str:
        """Name of the function."""
        return getattr(self.function, "__name__", type(self.function).__name__)

    @property
    def formula(self) -> Formula:
        """The law as a graph, or as its functions."""
        return self._formula

    # --- parameters ---------------------------------------------------------------------------

    @property
    def arguments(self) -> dict[str, float]:
        """Value of every parameter."""
        return dict(self.values)

    def _value(self, name: str, value: Any) -> float:
        if not str(name).isidentifier():
            raise ValueError(f"{name!r} cannot name a parameter of the friction law {self.title}")
        owner = f"{name} of the friction law {self.title}"
        return real(owner, value, "any finite number")

    def _replaced(self, changes: dict[str, Any]) -> Self:
        values = tuple((name, changes.get(name, value)) for name, value in self.values)
        if self._traced is None or not isinstance(self._formula, TracedFormula):
            return type(self)(self.function, values, self.slope_function, self.forward_function)
        law = copy.copy(self)  # the formula stays: only the values are new
        law._set("values", tuple((name, law._value(name, value)) for name, value in values))
        if not self._traced.is_analytic_at_rest(law.arguments):
            return type(self)(self.function, values, self.slope_function, self.forward_function)
        for forward in (False, True):
            for s, value in zip(SAMPLE, law.force(SAMPLE, forward=forward), strict=True):
                law._check_value(s, value)
        law._check_static_value()
        return law

    def _user_function(self, function: Callable[..., Any], role: str) -> UserFunction:
        """With the parameters it takes, checked against those given."""
        owner = f"{role} of the friction law {self.title}"
        if not callable(function):
            raise ValueError(f"{owner} is no function but {function!r}")
        try:
            signature = inspect.signature(plain_function(function))
        except (TypeError, ValueError):
            raise ValueError(f"{owner} does not tell its parameters; wrap it in a def") from None
        taken = list(signature.parameters.values())
        positional = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        if not taken or taken.pop(0).kind not in positional:
            raise ValueError(f"{owner} takes no speed s as its first argument")
        given = self.arguments
        for p in taken:
            if p.kind not in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY):
                raise ValueError(f"{owner}: parameter {p} cannot be passed by name")
            if p.default is p.empty and p.name not in given:
                raise ValueError(
                    f"{owner} needs a value for {p.name!r}: parameters={{{p.name!r}: ...}}"
                )
        names = [p.name for p in taken]
        return UserFunction(function, tuple(name for name in given if name in names))

    def _callable_formula(self) -> CallableFormula:
        backward = self._user_function(self.function, "force")
        forward, slope = backward, None
        if self.forward_function is not None:
            forward = self._user_function(self.forward_function, "forward force")
        if self.slope_function is not None:
            slope = self._user_function(self.slope_function, "slope")
        for name in self.arguments:
            if name not in backward.parameters and name not in forward.parameters:
                known = list(inspect.signature(plain_function(self.function)).parameters)[1:]
                raise unknown_name(name, known, f"friction law {self.title}")
        return CallableFormula(tuple(self.arguments), backward, forward, slope)

    # --- checks -------------------------------------------------------------------------------

    def _check_sample(self, formula: CallableFormula) -> None:
        for user in dict.fromkeys((formula.backward, formula.forward)):
            for s in SAMPLE:
                self._check_value(s, self._called(user, s))

    def _called(self, user: UserFunction, s: float) -> Any:
        plain = UserFunction(plain_function(user.function), user.parameters)
        try:
            return quietly(plain, s, self.arguments)
        except Exception as error:
            raise ValueError(
                f"friction law {self.title} failed at s = {s:g}: {type(error).__name__}: {error}"
            ) from error

    def _check_value(self, s: float, value: Any) -> None:
        if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
            raise ValueError(
                f"friction law {self.title}: F({s:g}) is a {type(value).__name__}, not a float"
            )
        if not np.isfinite(float(value)):
            raise ValueError(
                f"friction law {self.title}: F({s:g}) = {value}; "
                "a law must be finite for 0 <= s <= 10"
            )

    def _trace(self, formula: CallableFormula) -> TracedFormula:
        """Record the law as a graph that has a series at s = 0 and agrees with the function."""
        traced = traced_formula(
            formula.parameters,
            formula.backward,
            None if formula.symmetric else formula.forward,
        )
        if not traced.is_analytic_at_rest(self.arguments):
            raise NotTraceable("it has no Taylor series at s = 0")
        for forward, user in ((False, formula.backward), (True, formula.forward)):
            values = [self._called(user, s) for s in SAMPLE]
            recorded = quietly(traced.force, np.array(SAMPLE), self.arguments, forward)
            if not np.allclose(recorded, values, rtol=AGREEMENT, atol=AGREEMENT):
                raise NotTraceable("what it computes depends on the type of its argument")
        return traced

    def _check_slope(self, formula: CallableFormula) -> None:
        if formula.slope is None:
            return
        exact = self.slope(SAMPLE)
        for s, value in zip(SAMPLE, exact, strict=True):
            given = self._called(formula.slope, s)
            if not abs(given - value) <= SLOPE_AGREEMENT * max(1.0, abs(value)):
                raise ValueError(
                    f"slope of the friction law {self.title} is {given} at s = {s:g}, "
                    f"but dF/ds is {value}"
                )

    def _compile(self, not_traced: str) -> None:
        formula = self._formula
        assert isinstance(formula, CallableFormula)
        for user in dict.fromkeys((formula.backward, formula.forward, formula.slope)):
            if user is None:
                continue
            try:
                UserFunction(compiled(user.function), user.parameters)(0.0, self.arguments)
            except Exception as error:
                raise ValueError(
                    f"friction law {self.title} can be neither recorded as a formula "
                    f"({not_traced}) nor compiled ({_reason(error)})"
                ) from error

    # --- values -------------------------------------------------------------------------------

    def _force(self, s: Any, forward: bool) -> Any:
        if isinstance(self._formula, TracedFormula):
            return super()._force(s, forward)
        user = self._formula.forward if forward else self._formula.backward
        return np.vectorize(lambda speed: self._called(user, speed), otypes=[float])(s)

    def _slope(self, s: Any, forward: bool) -> Any:
        if isinstance(self._formula, TracedFormula):
            return super()._slope(s, forward)
        row, slope = pointwise(self, "slope")
        m = 1 if forward else -1
        return np.vectorize(lambda speed: slope(row, m, speed), otypes=[float])(s)

    def __repr__(self) -> str:
        """Show the call that makes it."""
        parameters = f", parameters={dict(self.values)!r}" if self.values else ""
        more = "" if self.forward_function is None else ", forward=..."
        return f"friction_law({self.title}{parameters}{more})"


def _reason(error: Exception) -> str:
    """One line of what numba says, without its advice and traces."""
    lines = [line.strip() for line in str(error).splitlines()]
    skipped = ("Failed in", "During", "File", "-", "<source", "This error", "Invalid use of")
    telling = [line for line in lines if line and not line.startswith(skipped)]
    return (telling or lines or [type(error).__name__])[0]
