"""Friction laws as text and as plain values, checked key by key."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, Final

from stickslip.checks import shown
from stickslip.mechanics.friction import LAWS, TabulatedFriction, UserLaw, friction_law
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.mechanics.friction.user_law import RESERVED
from stickslip.numerics.formula_text import FormulaText
from stickslip.vocabulary import closest, did_you_mean


def parse_law(text: str, numbers: Mapping[str, float] = MappingProxyType({})) -> FrictionLaw:
    """Read ``"coulomb:mu=0.22"`` or ``"a + (1 - a) / (1 + s), a=0.3"``; ``str(law)`` writes it.

    Its `numbers` come before those in the text, and may be of other things.
    """
    law, values = _split(text)
    mine = {name: numbers[name] for name in _names(law, values) if name in numbers}
    return _made(law, values | mine, in_table=False)


def taken(text: str, numbers: Collection[str]) -> set[str]:
    """Tell which of these names a law that is written so can take a value for."""
    return set(numbers).intersection(_names(*_split(text)))


NAMED: Final = re.compile(r"\s*([\w-]*)\s*:(.*)", re.DOTALL)
"""What begins with the name of a law."""
VALUE: Final = re.compile(r",(?=\s*[^\W\d]\w*\s*=)")
"""Before each value that follows a formula."""
FORWARD: Final = "forward"
"""Key of a second formula, beside the values of the first."""


def _split(text: str) -> tuple[str, dict[str, Any]]:
    """Return a law as it is named or written, and the values behind it."""
    named = NAMED.match(text)
    law, *items = [named[1], *named[2].split(",")] if named else VALUE.split(text)
    return law.strip(), _items(items, text)


def _built_in(law: str) -> type[FrictionLaw] | None:
    return LAWS.get(law.strip().lower().replace("_", "-"))


def _names(law: str, values: Mapping[str, Any]) -> list[str]:
    """Return all names that a law takes values for."""
    if (known := _built_in(law)) is not None:
        return list(known.fields())
    texts = [law, *(values[name] for name in values if name == FORWARD)]
    return list(dict.fromkeys(name for text in texts for name in FormulaText(text).names))


def _made(law: str, values: Mapping[str, Any], *, in_table: bool) -> FrictionLaw:
    """Make a law that is named or written as a formula."""
    if (known := _built_in(law)) is not None:
        if in_table:
            refuse_unknown(values, known.fields())
        return known.from_values(values)
    looks_like_a_name = law.isidentifier() or closest(law, list(LAWS))
    if looks_like_a_name and law not in ("s", *values):
        known_names = LAWS_IN_FILES if in_table else LAWS
        raise ValueError(f"there is no friction law {shown(law)}. {did_you_mean(law, known_names)}")
    forward = values.get(FORWARD)
    if not isinstance(forward, str | None):
        raise ValueError(f"{FORWARD} = {shown(forward)} must be a formula in quotation marks")
    names = _names(law, values)
    numbers = {name: value for name, value in values.items() if name != FORWARD}
    if missing := [name for name in names if name not in numbers and name not in RESERVED]:
        raise ValueError(f"the formula {shown(law)} {_lacking(missing, numbers, names, in_table)}")
    if in_table:
        refuse_unknown(numbers, names)
    return friction_law(law, forward=forward, parameters=numbers)


def _lacking(
    missing: Sequence[str], given: Iterable[str], names: Collection[str], in_table: bool
) -> str:
    """Say which values a formula needs, where they go, and which stand there for nothing."""
    needs = f"values for {', '.join(missing)}" if missing[1:] else f"a value for {missing[0]}"
    if in_table:
        write = "".join(f"{name} = ... " for name in missing) + "below it"
    else:
        write = repr("".join(f", {name}=..." for name in missing)) + " behind it"
    left = [name for name in given if name not in names]
    return f"needs {needs}: write {write}" + (f"; it has no {', '.join(left)}" if left else "")


def _items(items: Sequence[str], text: str) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for item in filter(None, (part.strip() for part in items)):
        key, equals, value = (part.strip() for part in item.partition("="))
        if not equals:
            raise ValueError(f"{shown(item)} in {shown(text)} is not of the form NAME=VALUE")
        if key in values:
            raise ValueError(f"{shown(key)} is given twice in {shown(text)}")
        values[key] = value if key == FORWARD else _number(key, value)
    return values


def _number(key: str, text: str) -> float:
    try:
        return int(text) if text.lstrip("+-").isdigit() else float(text)
    except ValueError:
        raise ValueError(f"{key} = {shown(text)} of a friction law is not a number") from None


TABLE: Final = ("speed", "force")
ABOVE_TABLES: Final = (
    *("kind", "alpha", "beta", "V", "damping", "static", "mass", "stiffness", "support", "ends"),
    *("friction", "units", "physical", "forcing", "force", "contact", "A", "B", "C", "a"),
)
"""Keys of models, of any kind, which slip under a table that is written too early."""
LAWS_IN_FILES: Final = (*LAWS, TabulatedFriction.name)


def law_values(law: FrictionLaw) -> dict[str, Any]:
    """Return a law as plain values; ValueError for a Python function, which a file cannot hold."""
    if isinstance(law, TabulatedFriction):
        return {"law": law.name, "speed": list(law.speeds), "force": list(law.forces)}
    if isinstance(law, UserLaw) and law.text is not None:
        return {"law" if k == "force" else k: text for k, text in law.text.items()} | law.parameters
    if LAWS.get(law.name) is not type(law):
        raise ValueError(
            f"the friction law {law.title} is a Python function, which a file cannot hold. "
            f"Laws in files: {', '.join(LAWS_IN_FILES)}, or a formula as text."
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
        "parameters, or [[friction]] so for each block, in their order; or one text such as "
        '"coulomb:mu=0.22" or "a + (1 - a) * exp(-s), a=0.3".'
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
    return _made(name, values, in_table=True)


def refuse_unknown(
    table: Mapping[str, Any], known: Collection[str], *, is_whole: bool = False
) -> None:
    """Raise ValueError for a key that is not known, in a table or in the `is_whole` file."""
    for name in table:
        if name not in known:
            hint = did_you_mean(name, known)
            if name in ABOVE_TABLES and not is_whole:
                hint += " If it is one of the model's, write it before any [table]."
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
