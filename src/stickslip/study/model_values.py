"""Models as plain values, checked key by key: the content of model files and files of results."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from typing import Any, Final

from stickslip.mechanics.friction import LAWS, FrictionLaw, TabulatedFriction
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Units
from stickslip.vocabulary import did_you_mean

__all__ = ["model_of_values", "model_values", "within"]

NUMBERS: Final = ("alpha", "beta", "V")
PHYSICAL: Final = ("m", "k", "k12", "fs1", "fs2", "v_dr")
UNITS: Final = ("m", "k", "fs1")
TABLE: Final = ("speed", "force")
LAWS_IN_FILES: Final = (*LAWS, TabulatedFriction.name)
TWO_BLOCK_KEYS: Final = ("kind", *NUMBERS, "damping", "friction", "units", "physical")


def model_values(model: TwoBlock) -> dict[str, Any]:
    """Return a model as plain values, keyed as in a file; `model_of_values` makes it again.

    Parameters
    ----------
    model : TwoBlock
        With built-in friction laws.

    Returns
    -------
    dict
        Numbers and texts, then tables of such, or a list of tables.

    Raises
    ------
    ValueError
        A friction law is a Python function, which a file cannot hold.
    """
    values: dict[str, Any] = {"kind": "two_block"}
    values |= {name: getattr(model, name) for name in NUMBERS}
    if model.damping > 0.0:
        values["damping"] = model.damping
    if model.units is not None:
        values["units"] = {name: getattr(model.units, name) for name in UNITS}
    laws = [_law_values(law) for law in model.laws]
    values["friction"] = laws if isinstance(model.friction, tuple) else laws[0]
    return values


def _law_values(law: FrictionLaw) -> dict[str, Any]:
    if isinstance(law, TabulatedFriction):
        return {"law": law.name, "speed": list(law.speeds), "force": list(law.forces)}
    if LAWS.get(law.name) is not type(law):
        raise ValueError(
            f"the friction law {law.title} is a Python function, which a file cannot hold. "
            f"Laws in files: {', '.join(LAWS_IN_FILES)}."
        )
    return {"law": law.name, **law.parameters, **law.options}


def model_of_values(table: dict[str, Any]) -> TwoBlock:
    """Make the model of a file's content.

    Parameters
    ----------
    table : dict
        As `model_values` returns it, or in any other form that a file may have.

    Returns
    -------
    TwoBlock
        The model.

    Raises
    ------
    ValueError
        A key is unknown or missing, a value of the wrong type or out of its range.
    """
    if "kind" not in table:
        close = get_close_matches("kind", table, n=1)
        instead = f" in place of {close[0]!r}" if close else ""
        raise ValueError(f'lacks kind: write kind = "two_block"{instead}. {_listed(KINDS)}')
    kind = table["kind"]
    if not isinstance(kind, str):
        raise ValueError(f"kind = {kind!r} must be text in quotation marks. {_listed(KINDS)}")
    if kind not in KINDS:
        raise ValueError(f"kind = {kind!r} is no kind of model. {did_you_mean(kind, KINDS)}")
    return KINDS[kind](table)


def _two_block(table: dict[str, Any]) -> TwoBlock:
    _refuse_unknown(table, TWO_BLOCK_KEYS)
    # First: numbers that slipped under this table are missing above it.
    friction = _friction(table["friction"]) if "friction" in table else None
    physical = "physical" in table
    _refuse_missing(table, ("friction",) if physical else (*NUMBERS, "friction"))
    assert friction is not None
    if not physical:
        numbers = {name: table[name] for name in (*NUMBERS, "damping") if name in table}
        return TwoBlock(**numbers, friction=friction, units=_units(table))
    if twice := [name for name in (*NUMBERS, "damping", "units") if name in table]:
        raise ValueError(
            f"{', '.join(twice)} beside [physical], from which the dimensionless numbers and the "
            "units follow. Give either [physical] or the dimensionless numbers."
        )
    quantities = _numbers(table["physical"], "[physical]", PHYSICAL, optional=("c",))
    with within("[physical] "):
        return TwoBlock.from_physical(**quantities, friction=friction)


KINDS: Final[dict[str, Callable[[dict[str, Any]], TwoBlock]]] = {"two_block": _two_block}
"""Kinds of models, and who makes one of the file's content."""


def _units(table: Mapping[str, Any]) -> Units | None:
    if "units" not in table:
        return None
    quantities = _numbers(table["units"], "[units]", UNITS)
    with within("[units] "):
        return Units(**quantities)


def _numbers(
    table: Any, place: str, names: tuple[str, ...], optional: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Check that a table holds exactly these keys, and perhaps the optional ones."""
    if not isinstance(table, dict):
        raise ValueError(f"{place} must be a table with the keys {', '.join(names)}")
    with within(f"{place} "):
        _refuse_unknown(table, (*names, *optional))
        _refuse_missing(table, names)
    return table


def _friction(given: Any) -> FrictionLaw | tuple[FrictionLaw, FrictionLaw]:
    """Read ``[friction]``, or ``[[friction]]`` twice."""
    match given:
        case dict():
            with within("[friction] "):
                return _law(given)
        case [dict() as first, dict() as second]:
            return (_law_of_block(1, first), _law_of_block(2, second))
        case [dict(), *rest] if all(isinstance(item, dict) for item in rest):
            raise ValueError(
                f"[[friction]] stands {len(given)} times; there are two blocks. Write [friction] "
                "once for both, or [[friction]] twice: block 1, then block 2."
            )
    raise ValueError(
        f"friction = {given!r} must be a table: a line [friction], under it law and its parameters."
    )


def _law_of_block(block: int, table: dict[str, Any]) -> FrictionLaw:
    with within(f"[[friction]] of block {block}: "):
        return _law(table)


def _law(table: dict[str, Any]) -> FrictionLaw:
    """Make a law of its table; the law checks its parameters."""
    values = dict(table)
    name = values.pop("law", None)
    if name is None:
        raise ValueError(f"lacks law. {_listed(LAWS_IN_FILES)}")
    if not isinstance(name, str):
        raise ValueError(
            f"law = {name!r} must be text in quotation marks. {_listed(LAWS_IN_FILES)}"
        )
    if name == TabulatedFriction.name:
        _refuse_unknown(values, TABLE)
        _refuse_missing(values, TABLE)
        return TabulatedFriction(**values)
    if name not in LAWS:
        raise ValueError(f"law = {name!r} is no friction law. {did_you_mean(name, LAWS_IN_FILES)}")
    law = LAWS[name]
    _refuse_unknown(values, law.fields())
    return law.from_values(values)


def _refuse_unknown(table: Mapping[str, Any], known: Collection[str]) -> None:
    for name in table:
        if name not in known:
            hint = did_you_mean(name, known)
            if name in TWO_BLOCK_KEYS:
                hint = "In TOML a key belongs to the table above it: write it before any [table]."
            raise ValueError(f"unknown key {name!r}. {hint}")


def _refuse_missing(table: Mapping[str, Any], needed: tuple[str, ...]) -> None:
    if missing := [name for name in needed if name not in table]:
        raise ValueError(f"lacks {', '.join(missing)}")


def _listed(known: Collection[str]) -> str:
    return f"Known: {', '.join(known)}."


@contextmanager
def within(place: str) -> Iterator[None]:
    """Put the place before the message of a ValueError."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{place}{error}") from error
