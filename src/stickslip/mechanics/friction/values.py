"""Friction laws as text and as plain values, checked key by key."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

from stickslip.checks import shown
from stickslip.mechanics.friction import LAWS, TabulatedFriction
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.vocabulary import did_you_mean


def parse_law(text: str) -> FrictionLaw:
    """Read a built-in law, ``"coulomb:mu=0.22"``; the opposite of ``str(law)``."""
    name, _, rest = text.strip().partition(":")
    name = name.strip().lower().replace("_", "-")
    if name not in LAWS:
        raise ValueError(f"there is no friction law {shown(name)}. {did_you_mean(name, LAWS)}")
    law = LAWS[name]
    values: dict[str, float] = {}
    for item in filter(None, (part.strip() for part in rest.split(","))):
        key, equals, number = (part.strip() for part in item.partition("="))
        if not equals:
            raise ValueError(f"{shown(item)} in {shown(text)} is not of the form parameter=value")
        if key in values:
            raise ValueError(f"{shown(key)} is given twice in {shown(text)}")
        values[key] = _number(key, number, law)
    return law.from_values(values)


def _number(key: str, text: str, law: type[FrictionLaw]) -> float:
    try:
        return int(text) if text.lstrip("+-").isdigit() else float(text)
    except ValueError:
        raise ValueError(
            f"{key} = {shown(text)} of the friction law {law.name} is not a number"
        ) from None


TABLE: Final = ("speed", "force")
ABOVE_TABLES: Final = (
    *("kind", "alpha", "beta", "V", "damping", "static", "mass", "stiffness", "support", "ends"),
    *("friction", "units", "physical", "forcing"),
)
"""Keys of models, of any kind, which slip under a table that is written too early."""
LAWS_IN_FILES: Final = (*LAWS, TabulatedFriction.name)


def law_values(law: FrictionLaw) -> dict[str, Any]:
    """Return a law as plain values; ValueError for a Python function, which a file cannot hold."""
    if isinstance(law, TabulatedFriction):
        return {"law": law.name, "speed": list(law.speeds), "force": list(law.forces)}
    if LAWS.get(law.name) is not type(law):
        raise ValueError(
            f"the friction law {law.title} is a Python function, which a file cannot hold. "
            f"Laws in files: {', '.join(LAWS_IN_FILES)}."
        )
    return {"law": law.name, **law.parameters, **law.options}


def friction_of(given: Any, n_blocks: int | None) -> FrictionLaw | tuple[FrictionLaw, ...]:
    """Read ``[friction]``, or ``[[friction]]`` once for each block (of any number if None)."""
    match given:
        case dict():
            with within("[friction] "):
                return _law(given)
        case [dict(), *rest] if all(isinstance(item, dict) for item in rest):
            if n_blocks in (None, len(given)):
                return tuple(_law_of_block(block, law) for block, law in enumerate(given, start=1))
            raise ValueError(
                f"[[friction]] stands {len(given)} times for {n_blocks} blocks. "
                "Write [friction] once for all, or [[friction]] for each block, in their order."
            )
    raise ValueError(
        f"friction = {shown(given)} must be a table: a line [friction], under it law and its "
        "parameters."
    )


def _law_of_block(block: int, table: dict[str, Any]) -> FrictionLaw:
    with within(f"[[friction]] of block {block}: "):
        return _law(table)


def _law(table: dict[str, Any]) -> FrictionLaw:
    """Make a law of its table; the law checks its parameters."""
    values = dict(table)
    name = values.pop("law", None)
    if name is None:
        raise ValueError(f"lacks law. {listed(LAWS_IN_FILES)}")
    if not isinstance(name, str):
        raise ValueError(
            f"law = {shown(name)} must be text in quotation marks. {listed(LAWS_IN_FILES)}"
        )
    if name == TabulatedFriction.name:
        refuse_unknown(values, TABLE)
        refuse_missing(values, TABLE)
        return TabulatedFriction(**values)
    if name not in LAWS:
        raise ValueError(
            f"law = {shown(name)} is no friction law. {did_you_mean(name, LAWS_IN_FILES)}"
        )
    law = LAWS[name]
    refuse_unknown(values, law.fields())
    return law.from_values(values)


def refuse_unknown(
    table: Mapping[str, Any], known: Collection[str], *, is_whole: bool = False
) -> None:
    """Raise ValueError for a key that is not known, in a table or in the `is_whole` file."""
    for name in table:
        if name not in known:
            hint = did_you_mean(name, known)
            if name in ABOVE_TABLES and not is_whole:
                hint = "In TOML a key belongs to the table above it: write it before any [table]."
            raise ValueError(f"unknown key {shown(name)}. {hint}")


def refuse_missing(table: Mapping[str, Any], needed: Collection[str]) -> None:
    """Raise ValueError where a key is missing."""
    if missing := [name for name in needed if name not in table]:
        raise ValueError(f"lacks {', '.join(missing)}")


def listed(known: Collection[str]) -> str:
    """Say what is known."""
    return f"Known: {', '.join(known)}."


@contextmanager
def within(place: str) -> Iterator[None]:
    """Put the place before the message of a ValueError."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{place}{error}") from error
