"""One table of names: symbol, meaning, scale and equation of everything that has a name.

Axis labels, attributes, documentation and messages read it. Equations are Galvanetto's (2001).
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType
from typing import Any, Final, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Term:
    """What one name stands for."""

    name: str  # as in code, files and on the command line
    symbol: str  # mathtext without dollar signs, in the paper's notation
    meaning: str  # a phrase that can follow "the"
    scale: str = ""  # what one dimensionless unit is; empty for a pure number
    equation: str = ""
    physical: str = ""  # symbol of what is not made dimensionless, in the paper's notation


_LENGTH = "f_s1 / k"
_TIME = "sqrt(m / k)"
_VELOCITY = "f_s1 / sqrt(k m)"
_FORCE = "f_s1"
_ENERGY = "f_s1^2 / k"

_TABLE = (
    # parameters of models
    Term("alpha", r"\alpha", "coupling ratio k12 / k", "", "6a"),
    Term("beta", r"\beta", "static-friction ratio f_s2 / f_s1", "", "6a"),
    Term("V", r"V_{\mathrm{dr}}", "driving velocity", _VELOCITY, "6a"),
    # parameters of friction laws
    Term("mu", r"\mu_{\mathrm{k}}", "kinetic over static friction", "", "8"),
    Term("gamma", r"\gamma", "rate at which friction falls with slip speed", "1 / velocity", "9"),
    Term("delta", r"\delta", "share of friction that never falls", "", "9"),
    Term("eta", r"\eta", "growth of friction with slip speed squared", "1 / velocity^2", "9"),
    Term("viscous", r"\chi", "viscous friction per slip speed", "1 / velocity"),
    Term("speed", r"s_{0}", "slip speed over which friction falls", _VELOCITY),
    Term("exponent", "q", "exponent of the slip speed in the falling part"),
    # state
    Term("t", r"\tau", "time", _TIME, "6a", "t"),
    Term("x", "X", "displacement of a block from where all springs are slack", _LENGTH, "6a", "x"),
    Term("v", r"\dot{X}", "velocity of a block", _VELOCITY, "7a", r"\dot{x}"),
    Term("w", "w", "relative velocity X' - V", _VELOCITY),
    Term("s", "s", "slip speed |X' - V|", _VELOCITY, "8"),
    Term("force", r"F_{\mathrm{k}}", "kinetic friction over the block's static limit", "", "8, 9"),
    Term("spring_force", "R", "force that a block needs to stay with the belt", _FORCE, "6a"),
    Term("friction", "F", "friction force on a block", _FORCE, "7a", "f"),
    Term("energy", "E", "energy", _ENERGY),
    # event map
    Term("d", "d", "relative displacement X_2 - X_1 in global stick", _LENGTH, "11"),
    Term("value", "f(d)", "relative displacement of the next global stick", _LENGTH, "12"),
    Term("derivative", "f'(d)", "slope of the event map; over an orbit, its multiplier"),
    Term("duration", r"\Delta\tau", "time between two global stick phases", _TIME),
    Term("n_events", "n", "number of changes of mode between two global stick phases"),
    Term("label", "", "hash of the itinerary"),
    Term("margin", "", "distance of the motion from a change of its itinerary"),
    Term("status", "", "why the motion ended"),
    Term("multiplier", r"\lambda", "Floquet multiplier, slope of the map over one period"),
)

TERMS: Final = MappingProxyType({term.name: term for term in _TABLE})
"""Every term by its name, in the order of the documentation."""

QUANTITIES: Final = MappingProxyType(
    {
        _LENGTH: "displacement",
        _TIME: "time",
        _VELOCITY: "velocity",
        _FORCE: "force",
        _ENERGY: "energy",
    }
)
"""What `Units.scale` calls the scale of a term."""


def symbol(name: str, index: int | str | None = None, *, physical: bool = False) -> str:
    """Mathtext of a term, with a subscript: a block, as of "mu_2", or an iterate such as "n+1".

    Or of the physical quantity that it stands for.
    """
    if name not in TERMS and index is None:
        name, _, index = name.rpartition("_")
    base = TERMS[name].physical if physical else TERMS[name].symbol
    if index is None:
        return f"${base}$"
    if base.endswith("}") and "_{" in base:  # a symbol that has a subscript: join them
        return f"${base[:-1]},{index}}}$"
    return f"${base}_{{{index}}}$"


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Sentence that lists what exists and names the closest, if need be in other letter case."""
    known = list(known)
    return f"Known: {', '.join(known) or 'none'}. {closest(name, known)}".rstrip()


def closest(name: object, known: list[str]) -> str:
    """Question whether the closest known name was meant; empty where none is close."""
    name = name[:100] if isinstance(name, str) else ""
    close = get_close_matches(name, known, n=1) or _close_but_for_case(name, known)
    return f"Did you mean {close[0]!r}?" if close else ""


def _close_but_for_case(name: str, known: list[str]) -> list[str]:
    """Like `get_close_matches`, which finds no V for v."""
    folded = {item.casefold(): item for item in known}
    return [folded[item] for item in get_close_matches(name.casefold(), folded, n=1)]


def suggests(public: T) -> T:
    """Let a public function or class name the closest keyword it knows when one is misspelt."""
    if isinstance(public, type):
        public.__init__ = suggests(public.__init__)  # type: ignore[misc]
        return public
    function: Any = public
    code = function.__code__
    known = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]

    @functools.wraps(function)
    def checked(*args: Any, **keywords: Any) -> Any:
        for name in keywords:
            if name not in known:
                named = [one for one in known if one != "self"]
                raise TypeError(f"{name!r} is no keyword here. {did_you_mean(name, named)}")
        return function(*args, **keywords)

    return checked  # type: ignore[return-value]
