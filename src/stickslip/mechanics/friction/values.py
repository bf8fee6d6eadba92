"""Friction laws as text and as plain values, checked key by key."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Final

from stickslip.checks import shown
from stickslip.mechanics.friction import LAWS, TabulatedFriction, UserLaw, friction_law
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.vocabulary import did_you_mean


def parse_law(text: str) -> FrictionLaw:
    """Read ``"coulomb:mu=0.22"`` or ``"a + (1 - a) / (1 + s), a=0.3"``; ``str(law)`` writes it."""
    if NAMED.match(text) is None:
        force, *items = text.split(",")
        return _formula({"force": force.strip(), **_items(items, text)})
    name, _, rest = text.strip().partition(":")
    name = name.strip().lower().replace("_", "-")
    if name not in LAWS:
        raise ValueError(f"there is no friction law {shown(name)}. {did_you_mean(name, LAWS)}")
    law = LAWS[name]
    return law.from_values(_items(rest.split(","), text))


NAMED: Final = re.compile(r"\s*[\w-]*\s*(:|$)")
"""What starts with the name of a law; all else is a formula."""
FORMULA: Final = "formula"
TEXTS: Final = ("force", "forward")
"""Of a formula law; its other keys are its parameters."""


def _items(items: Sequence[str], text: str) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for item in filter(None, (part.strip() for part in items)):
        key, equals, value = (part.strip() for part in item.partition("="))
        if not equals:
            raise ValueError(f"{shown(item)} in {shown(text)} is not of the form parameter=value")
        if key in values:
            raise ValueError(f"{shown(key)} is given twice in {shown(text)}")
        values[key] = value if key in TEXTS else _number(key, value)
    return values


def _number(key: str, text: str) -> float:
    try:
        return int(text) if text.lstrip("+-").isdigit() else float(text)
    except ValueError:
        raise ValueError(f"{key} = {shown(text)} of a friction law is not a number") from None


def _formula(values: Mapping[str, Any]) -> UserLaw:
    refuse_missing(values, ("force",))
    texts = {name: values[name] for name in TEXTS if name in values}
    for name, text in texts.items():
        if not isinstance(text, str):
            raise ValueError(f"{name} = {shown(text)} must be a formula in quotation marks")
    numbers = {name: value for name, value in values.items() if name not in TEXTS}
    return friction_law(**texts, parameters=numbers)


TABLE: Final = ("speed", "force")
ABOVE_TABLES: Final = (
    *("kind", "alpha", "beta", "V", "damping", "static", "mass", "stiffness", "support", "ends"),
    *("friction", "units", "physical", "forcing", "force", "contact", "A", "B", "C", "a"),
)
"""Keys of models, of any kind, which slip under a table that is written too early."""
LAWS_IN_FILES: Final = (*LAWS, TabulatedFriction.name, FORMULA)


def law_values(law: FrictionLaw) -> dict[str, Any]:
    """Return a law as plain values; ValueError for a Python function, which a file cannot hold."""
    if isinstance(law, TabulatedFriction):
        return {"law": law.name, "speed": list(law.speeds), "force": list(law.forces)}
    if isinstance(law, UserLaw) and law.text is not None:
        return {"law": FORMULA, **law.text, **law.parameters}
    if LAWS.get(law.name) is not type(law):
        raise ValueError(
            f"the friction law {law.title} is a Python function, which a file cannot hold. "
            f"Laws in files: {', '.join(LAWS_IN_FILES)}."
        )
    return {"law": law.name, **law.parameters, **law.options}


def friction_of(given: Any, n_blocks: int | None) -> FrictionLaw | tuple[FrictionLaw, ...]:
    """Read ``[friction]``, or ``[[friction]]`` once for each block (of any number if None)."""
    match given:
        case str():
            with within("friction: "):
                return parse_law(given)
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
        'parameters; or a text such as "coulomb:mu=0.22" or "a + (1 - a) * exp(-s), a=0.3".'
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
    if name == FORMULA:
        return _formula(values)
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
