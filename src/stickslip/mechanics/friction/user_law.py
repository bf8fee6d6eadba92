"""Friction laws that a user writes: as a plain Python function, or as a formula in a text."""

from __future__ import annotations

import copy
import inspect
import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import Parameter
from numbers import Real
from typing import Any, ClassVar, Final, Self

import numpy as np

from stickslip.checks import instance, model_number, shown
from stickslip.mechanics.friction.code import pointwise
from stickslip.mechanics.friction.formula import (
    CallableFormula,
    Formula,
    TracedFormula,
    UserFunction,
    quietly,
    traced_formula,
)
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.numerics.expression import NotTraceable
from stickslip.numerics.formula_text import FormulaText
from stickslip.numerics.tracing import plain_function
from stickslip.vocabulary import did_you_mean, suggests


def user_function(function: Any, given: Sequence[str], owner: str) -> UserFunction:
    """Check that a function takes a speed, then parameters that have a default or are `given`."""
    if not isinstance(function, Hashable) or not callable(function):
        raise ValueError(f"{owner} is no function but {shown(function)}")
    taken = _signature(function, owner)
    positional = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    if not taken or taken.pop(0).kind not in positional:
        raise ValueError(f"{owner} takes no speed s as its first argument")
    for parameter in taken:
        if parameter.kind not in (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY):
            raise ValueError(f"{owner}: parameter {parameter} cannot be passed by name")
        if parameter.default is Parameter.empty and parameter.name not in given:
            name = shown(parameter.name)
            speed = " (a formula calls the speed s)" if isinstance(function, FormulaText) else ""
            raise ValueError(f"{owner} needs a value for {name}: parameters={{{name}: ...}}{speed}")
    names = [parameter.name for parameter in taken]
    return UserFunction(function, tuple(name for name in given if name in names))


def _signature(function: Any, owner: str) -> list[Parameter]:
    try:
        return list(inspect.signature(plain_function(function)).parameters.values())
    except (TypeError, ValueError):
        raise ValueError(f"{owner} does not tell its parameters; wrap it in a def") from None


def parameter_names(function: Callable[..., Any]) -> list[str]:
    """Return the names that a function takes after the speed."""
    return [parameter.name for parameter in _signature(function, "force")[1:]]


# A law is tried at these speeds when it is made.
SAMPLE = (0.0, *(float(s) for s in np.geomspace(1e-6, 10.0, 50)))
# What a trace, or a slope given with the law, may differ from the law's own values.
AGREEMENT = 1e-9
RESERVED: Final = frozenset({"law", "forward"})
"""What stands beside the values of a formula in a file."""
SLOPE_AGREEMENT = 1e-6


@suggests
def friction_law(
    force: Callable[..., float] | str,
    *,
    parameters: Mapping[str, float] | None = None,
    slope: Callable[..., float] | None = None,
    forward: Callable[..., float] | str | None = None,
) -> UserLaw:
    """Make a friction law of a plain Python function, or of a formula in a text.

    Parameters
    ----------
    force : callable or str
        ``force(s, a, ...)``: kinetic friction over the static limit at the slip speed
        ``s >= 0``, with ``0 <= F(0) <= 1``. It opposes the slip. As text, in `s` and the
        parameters: numbers, names, ``+ - * / **``, parentheses and ``exp, expm1, log, log1p,
        sqrt, sin, cos, tan, sinh, cosh, tanh, atan, asinh, abs``; nothing in it runs as Python.
    parameters : mapping of str to float, optional
        The named parameters and their values. They count among a model's parameters.
    slope : callable, optional
        ``slope(s, a, ...)``, dF/ds. Needed only where the law cannot be differentiated
        exactly, see Notes; differences are the default there.
    forward : callable or str, optional
        A different law for a block that is faster than the belt.

    Returns
    -------
    UserLaw

    Raises
    ------
    ValueError
        The parameters do not fit the functions; the law is not finite for 0 <= s <= 10; F(0)
        is outside [0, 1]; the law can be neither recorded as a formula nor compiled; a text
        cannot be read.

    Notes
    -----
    A law made of arithmetic and the usual functions of `numpy` or `math` is recorded as a
    formula by calling it once with a number-like argument: slope, parameter derivatives and
    Taylor series are exact then, and kernels are kept between runs. A law that does anything
    else, such as branch on `s`, is compiled as it stands, once per process. Exponents: ``s**2``
    is recorded; ``s**a`` with a parameter `a`, which may make F singular at s = 0, is compiled.
    Texts are recorded, never compiled as they stand; model files and the command line take them
    too.

    Examples
    --------
    >>> law = friction_law(lambda s, a: a + (1 - a) / (1 + s), parameters={"a": 0.3})
    >>> law.force(1.0)
    0.65
    >>> ss.friction_law("a + (1 - a) / (1 + s)", parameters={"a": 0.3}).force(1.0)
    0.65
    """
    given = {} if parameters is None else parameters
    values = dict(instance("parameters", given, Mapping, "names with their values"))
    function, other = _read("force", force), _read("forward", forward)
    for text in (other, function):
        if not isinstance(text, FormulaText):
            continue
        if taken := RESERVED.intersection(text.names):
            raise ValueError(
                f"the formula {shown(text.text)} has a parameter {min(taken)}: model files mean "
                "something else by that word. Take another name."
            )
        # In their order there: equal texts, equal kernels.
        values = {name: values[name] for name in text.names if name in values} | values
    return UserLaw(function, tuple(values.items()), slope, other)


def _read(name: str, given: Any) -> Any:
    """Read a formula, if it is one."""
    if not isinstance(given, str):
        return given
    try:
        return FormulaText(given)
    except ValueError as reason:
        raise ValueError(f"{name} = {shown(given)}: {reason}") from None


@dataclass(frozen=True, repr=False)
class UserLaw(FrictionLaw):
    """What `friction_law` makes."""

    name: ClassVar[str] = "user"

    function: Callable[..., float]
    values: tuple[tuple[str, float], ...]
    slope_function: Callable[..., float] | None = None
    forward_function: Callable[..., float] | None = None
    _formula: Formula = field(init=False, compare=False)

    def __post_init__(self) -> None:
        """Check the functions and values, then record the law or compile it."""
        self._set("values", tuple((name, self._value(name, x)) for name, x in self.values))
        functions = self._callable_formula()
        known = self._plain_values(functions)
        try:
            traced = self._trace(functions, known)
            self._set("_formula", traced)
            self._check_slope(functions)
        except NotTraceable as reason:
            self._set("_formula", functions)
            self._compile(functions, known, str(reason))
        self._check_values()

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    @property
    def title(self) -> str:
        """Name of the function; a formula in quotation marks."""
        name = getattr(self.function, "__name__", type(self.function).__name__)
        return shown(name) if isinstance(self.function, FormulaText) else name

    @property
    def formula(self) -> Formula:
        """The law as a graph, or as its functions."""
        return self._formula

    @property
    def text(self) -> dict[str, str] | None:
        """Formulas of ``force`` and perhaps ``forward``, where they were given as text."""
        given = {"force": self.function, "forward": self.forward_function}
        texts = {name: f.text for name, f in given.items() if isinstance(f, FormulaText)}
        others = (f for f in (*given.values(), self.slope_function) if f is not None)
        return texts if all(isinstance(f, FormulaText) for f in others) else None

    # --- parameters ---------------------------------------------------------------------------

    @property
    def arguments(self) -> dict[str, float]:
        """Value of every parameter."""
        return dict(self.values)

    def _value(self, name: str, value: Any) -> float:
        if not str(name).isidentifier():
            raise ValueError(
                f"{shown(name)} in parameters cannot name a parameter of the friction law "
                f"{self.title}"
            )
        return model_number(name, value, of=f"the friction law {self.title}")

    def _replaced(self, changes: dict[str, Any]) -> Self:
        values = tuple((name, changes.get(name, value)) for name, value in self.values)
        if isinstance(self._formula, TracedFormula):
            law = copy.copy(self)  # the formula stays: only the values are new
            law.__dict__.pop("_at_rest", None)
            law._set("values", tuple((name, law._value(name, x)) for name, x in values))
            if self._formula.is_analytic_at_rest(law.arguments):
                law._check_values()
                return law
        return type(self)(self.function, values, self.slope_function, self.forward_function)

    def _callable_formula(self) -> CallableFormula:
        given = tuple(self.arguments)

        def checked(function: Callable[..., Any], role: str) -> UserFunction:
            return user_function(function, given, f"{role} of the friction law {self.title}")

        backward = checked(self.function, "force")
        forward, slope = backward, None
        if self.forward_function is not None:
            forward = checked(self.forward_function, "forward force")
        if self.slope_function is not None:
            slope = checked(self.slope_function, "slope")
        for name in given:
            if name not in backward.parameters and name not in forward.parameters:
                known = did_you_mean(name, parameter_names(self.function))
                raise ValueError(
                    f"friction law {self.title} has no parameter {shown(name)}. {known}"
                )
        return CallableFormula(given, backward, forward, slope)

    # --- checks -------------------------------------------------------------------------------

    def _plain_values(self, formula: CallableFormula) -> dict[UserFunction, list[float]]:
        """Call the functions in plain Python; NaN where only that overflows."""
        functions = dict.fromkeys((formula.backward, formula.forward))
        return {user: [self._called(user, s) for s in SAMPLE] for user in functions}

    def _called(self, user: UserFunction, s: float) -> float:
        plain = UserFunction(plain_function(user.function), user.parameters)
        try:
            value = quietly(plain, s, self.arguments)
        except OverflowError:  # of the math module; numpy and kernels go on with infinity
            return math.nan
        except Exception as error:
            raise ValueError(
                f"friction law {self.title} failed at s = {s:g}: {type(error).__name__}: {error}"
            ) from error
        if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
            raise ValueError(
                f"friction law {self.title}: F({s:g}) is a {type(value).__name__}, not a float"
            )
        return float(value)

    def _trace(
        self, functions: CallableFormula, known: Mapping[UserFunction, list[float]]
    ) -> TracedFormula:
        """Record the law as a graph that has a series at s = 0 and agrees with the function."""
        forward = None if functions.symmetric else functions.forward
        traced = traced_formula(functions.parameters, functions.backward, forward)
        if not traced.is_analytic_at_rest(self.arguments):
            raise NotTraceable("it has no Taylor series at s = 0")
        for direction, user in ((False, functions.backward), (True, functions.forward)):
            values = quietly(traced.force, np.array(SAMPLE), self.arguments, direction)
            if not _agree(values, known[user]):
                raise NotTraceable("what it computes depends on the type of its argument")
        return traced

    def _compile(
        self,
        functions: CallableFormula,
        known: Mapping[UserFunction, list[float]],
        not_traced: str,
    ) -> None:
        if self.text is not None:
            raise ValueError(f"the friction law {self.title} cannot be used: {not_traced}")
        for user in dict.fromkeys((functions.backward, functions.forward, functions.slope)):
            if user is None:
                continue
            try:
                values = [quietly(user.compiled(), s, self.arguments) for s in SAMPLE]
            except Exception as error:
                raise ValueError(
                    f"friction law {self.title} can be neither recorded as a formula "
                    f"({not_traced}) nor compiled ({_reason(error)})"
                ) from error
            if user in known and not _agree(values, known[user]):
                raise ValueError(
                    f"friction law {self.title} gives other values when it is compiled; "
                    "it may depend on integer arithmetic or on something that changes"
                )

    def _check_values(self) -> None:
        """Check that F is finite at every sample speed, and F(0) allowed."""
        for forward in (False, True):
            values = quietly(self._force, np.array(SAMPLE), forward) + np.zeros(len(SAMPLE))
            for s, value in zip(SAMPLE, values.tolist(), strict=True):
                if not math.isfinite(value):
                    raise ValueError(
                        f"friction law {self.title}: F({s:g}) = {value}; "
                        "a law must be finite for 0 <= s <= 10"
                    )
        self._check_static_value()

    def _check_slope(self, functions: CallableFormula) -> None:
        """Check a slope given with a law that is differentiated exactly anyway."""
        if functions.slope is None:
            return
        for s, exact in zip(SAMPLE, self.slope(SAMPLE).tolist(), strict=True):
            given = self._called(functions.slope, s)
            if abs(given - exact) > SLOPE_AGREEMENT * max(1.0, abs(exact)):
                raise ValueError(
                    f"slope of the friction law {self.title} is {given} at s = {s:g}, "
                    f"but dF/ds is {exact}"
                )

    # --- values -------------------------------------------------------------------------------

    def _force(self, s: Any, forward: bool) -> Any:
        if isinstance(self._formula, TracedFormula):
            return super()._force(s, forward)
        user = (self._formula.forward if forward else self._formula.backward).compiled()
        return np.vectorize(lambda speed: user(speed, self.arguments), otypes=[float])(s)

    def _slope(self, s: Any, forward: bool) -> Any:
        if isinstance(self._formula, TracedFormula):
            return super()._slope(s, forward)
        row, slope = pointwise(self, "slope")
        m = 1 if forward else -1
        return np.vectorize(lambda speed: slope(row, m, speed), otypes=[float])(s)

    def __str__(self) -> str:
        """Write a law of formulas as ``parse_law`` reads it."""
        if self.text is None:
            return super().__str__()
        force, *forward = self.text.values()
        rest = [f"forward={text}" for text in forward]
        return ", ".join([force, *rest, *(f"{name}={value!r}" for name, value in self.values)])

    def __repr__(self) -> str:
        """Show the call that makes it."""
        function, forward = (
            repr(f.text) if isinstance(f, FormulaText) else otherwise
            for f, otherwise in ((self.function, self.title), (self.forward_function, "..."))
        )
        parameters = f", parameters={dict(self.values)!r}" if self.values else ""
        more = "" if self.forward_function is None else f", forward={forward}"
        return f"friction_law({function}{parameters}{more})"


def _agree(values: Any, known: list[float]) -> bool:
    """Whether values are those of plain Python, wherever that has some."""
    reference = np.array(known)
    there = np.isfinite(reference)
    found = np.broadcast_to(values, reference.shape)[there]
    return bool(np.allclose(found, reference[there], rtol=AGREEMENT, atol=AGREEMENT))


def _reason(error: Exception) -> str:
    """One line of what numba says, without its advice and traces."""
    lines = [line.strip() for line in str(error).splitlines()]
    skipped = ("Failed in", "During", "File", "-", "<source", "This error", "Invalid use of")
    telling = [line for line in lines if line and not line.startswith(skipped)]
    return (telling or lines or [type(error).__name__])[0]
