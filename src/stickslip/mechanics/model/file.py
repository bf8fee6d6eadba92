"""Models as TOML files: written by hand, or by `write_model`, which keeps every digit."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.checks import shown
from stickslip.files import checked_path, checked_suffix, read_text, write_text
from stickslip.mechanics.friction.values import (
    friction_of,
    law_values,
    listed,
    refuse_missing,
    refuse_unknown,
    within,
)
from stickslip.mechanics.model.arguments import Model, checked_model
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.blocks import Blocks, Chain, Oscillator
from stickslip.mechanics.model.structure import Harmonic
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Units
from stickslip.results.files import register_part
from stickslip.vocabulary import did_you_mean, suggests

if TYPE_CHECKING:
    from os import PathLike


NUMBERS: Final = ("alpha", "beta", "V")
PHYSICAL: Final = ("m", "k", "k12", "fs1", "fs2", "v_dr")
UNITS: Final = ("m", "k", "fs1")
FORCING: Final = ("amplitude", "frequency")
TWO_BLOCK_KEYS: Final = ("kind", *NUMBERS, "damping", "friction", "units", "physical")


@dataclass(frozen=True)
class FamilyKind:
    """Keys of a kind of the family: needed ones, and optional ones with their defaults."""

    cls: type[Blocks | Chain | Oscillator]
    needed: tuple[str, ...]
    optional: Mapping[str, Any]
    per_block: str | None  # a needed one: a list with an entry for each block


FAMILY: Final = {
    "blocks": FamilyKind(Blocks, ("mass", "stiffness", "static", "V"), {"damping": None}, "mass"),
    "chain": FamilyKind(
        Chain,
        ("static", "alpha", "V"),
        {"support": 1.0, "mass": 1.0, "damping": 0.0, "ends": "free"},
        "static",
    ),
    "oscillator": FamilyKind(Oscillator, ("V",), {"damping": 0.0}, None),
}


# --- from models ------------------------------------------------------------------------------


def model_values(model: Model) -> dict[str, Any]:
    """Return a model as plain values, keyed as in a file; `model_of_values` makes it again."""
    checked_model(model)
    values = _two_block_values(model) if isinstance(model, TwoBlock) else _family_values(model)
    laws = [law_values(law) for law in model.laws]
    values["friction"] = laws if isinstance(model.friction, tuple) else laws[0]
    return values


def _two_block_values(model: TwoBlock) -> dict[str, Any]:
    values: dict[str, Any] = {"kind": "two_block"}
    values |= {name: getattr(model, name) for name in NUMBERS}
    if model.damping > 0.0:
        values["damping"] = model.damping
    if model.units is not None:
        values["units"] = {name: getattr(model.units, name) for name in UNITS}
    return values


def _family_values(model: BeltModel) -> dict[str, Any]:
    name, kind = next((name, kind) for name, kind in FAMILY.items() if isinstance(model, kind.cls))
    values: dict[str, Any] = {"kind": name}
    values |= {key: _plain(getattr(model, key)) for key in kind.needed}
    for key, default in kind.optional.items():
        value = getattr(model, key)
        if np.any(value != (0.0 if default is None else default)):
            values[key] = _plain(value)
    if model.forcing is not None:
        names = (*FORCING, "phase")
        values["forcing"] = {name: _plain(getattr(model.forcing, name)) for name in names}
    return values


def _plain(value: Any) -> Any:
    """Return arrays and tuples as lists."""
    return np.asarray(value).tolist()


# --- to models --------------------------------------------------------------------------------


def model_of_values(table: dict[str, Any]) -> Model:
    """Make the model of a file's content; ValueError names the key that is wrong."""
    if "kind" not in table:
        close = get_close_matches("kind", table, n=1)
        instead = f" in place of {shown(close[0])}" if close else ""
        raise ValueError(f'lacks kind: write kind = "two_block"{instead}. {listed(KINDS)}')
    kind = table["kind"]
    if not isinstance(kind, str):
        raise ValueError(f"kind = {shown(kind)} must be text in quotation marks. {listed(KINDS)}")
    if kind not in KINDS:
        raise ValueError(f"kind = {shown(kind)} is no kind of model. {did_you_mean(kind, KINDS)}")
    return KINDS[kind](table)


def _two_block(table: dict[str, Any]) -> TwoBlock:
    refuse_unknown(table, TWO_BLOCK_KEYS, is_whole=True)
    # First: numbers that slipped under this table are missing above it.
    friction = friction_of(table["friction"], 2) if "friction" in table else None
    physical = "physical" in table
    refuse_missing(table, ("friction",) if physical else (*NUMBERS, "friction"))
    given: dict[str, Any] = {"friction": friction}
    if not physical:
        given |= {name: table[name] for name in (*NUMBERS, "damping") if name in table}
        return TwoBlock(**given, units=_units(table))
    if twice := [name for name in (*NUMBERS, "damping", "units") if name in table]:
        raise ValueError(
            f"{', '.join(twice)} beside [physical], from which the dimensionless numbers and the "
            "units follow. Give either [physical] or the dimensionless numbers."
        )
    quantities = _numbers(table["physical"], "[physical]", PHYSICAL, optional=("c",))
    with within("[physical] "):
        return TwoBlock.from_physical(**quantities, **given)


def _family(table: dict[str, Any]) -> BeltModel:
    kind = FAMILY[table["kind"]]
    numbers = (*kind.needed, *kind.optional)
    refuse_unknown(table, ("kind", *numbers, "friction", "forcing"), is_whole=True)
    given: dict[str, Any] = {}
    if "friction" in table:  # first, as above
        listing = table.get(kind.per_block) if kind.per_block else [None]
        n_blocks = len(listing) if isinstance(listing, list) else None
        given["friction"] = friction_of(table["friction"], n_blocks)
    refuse_missing(table, (*kind.needed, "friction"))
    given |= {name: table[name] for name in numbers if name in table}
    if "forcing" in table:
        forcing = _numbers(table["forcing"], "[forcing]", FORCING, optional=("phase",))
        with within("[forcing] "):
            given["forcing"] = Harmonic(**forcing)
    return kind.cls(**given)


KINDS: Final[dict[str, Callable[[dict[str, Any]], Model]]] = {
    "two_block": _two_block,
    **dict.fromkeys(FAMILY, _family),
}
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
        refuse_unknown(table, (*names, *optional))
        refuse_missing(table, names)
    return table


register_part("model", (TwoBlock, BeltModel), model_values, model_of_values)


MOST_NESTED: Final = 20
TOO_DEEP: Final = "its keys, arrays or tables are nested too deeply"
LONG_KEY: Final = re.compile(
    rf"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{MOST_NESTED + 1}}}"""
)
"""Looked for beforehand: reading a key takes a time that grows with the square of its dots."""


@suggests
def read_model(path: str | PathLike[str]) -> Model:
    """Read a model from a TOML file.

    Parameters
    ----------
    path : str or path
        The file: a ``kind`` such as ``"two_block"`` or ``"chain"``, the numbers of that kind
        of model, and ``[friction]`` with a ``law`` and its parameters. The page "Model files"
        of the documentation shows every form.

    Returns
    -------
    TwoBlock, Blocks, Chain or Oscillator
        The model.

    Raises
    ------
    ValueError
        The file is not TOML; a key is unknown or missing; a value is of the wrong type or
        out of its range. The message names file and key, and what is allowed.
    OSError
        The file cannot be read.
    """
    table = read_toml(path)
    with within(f"{path}: "):
        return model_of_values(table)


@suggests
def write_model(model: Model, path: str | PathLike[str]) -> None:
    """Write a model to a TOML file, which `read_model` turns into an equal model.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain or Oscillator
        With built-in friction laws or formulas; numbers are written with every digit.
    path : str or path
        A file of that name is replaced; it is whole at any time.

    Raises
    ------
    ValueError
        A friction law is a Python function, which a file cannot hold.
    OSError
        The file cannot be written.
    """
    checked_suffix(checked_path(path), ("", ".toml"))
    write_text(path, model_text(model))


def model_text(model: Model) -> str:
    """Return what `write_model` writes, a TOML document."""
    lines = []
    for key, value in model_values(model).items():  # numbers come before tables
        if isinstance(value, dict):
            lines += ["", f"[{key}]", *_lines(value)]
        elif isinstance(value, list) and isinstance(value[0], dict):
            lines += [line for table in value for line in ("", f"[[{key}]]", *_lines(table))]
        else:
            lines += _lines({key: value})
    return "\n".join(lines) + "\n"


def _lines(values: Mapping[str, Any]) -> list[str]:
    """Write values: texts of JSON are TOML, and so is Python's exact form of a finite number."""
    return [
        f"{name} = {json.dumps(value) if isinstance(value, str) else repr(value)}"
        for name, value in values.items()
    ]


def read_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """Read a TOML file; ValueError names file and line of what is wrong."""
    text = read_text(path)
    with within(f"{path}: "):
        if found := LONG_KEY.search(text):
            line = text.count("\n", 0, found.start()) + 1
            raise ValueError(f"{TOO_DEEP}: more than {MOST_NESTED} dots in a key, line {line}")
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise ValueError(f"not TOML: {error}") from None
        except ValueError:
            raise ValueError("not TOML: a whole number of more than 4300 digits") from None
        except RecursionError:
            raise ValueError(TOO_DEEP) from None
        _refuse_deep(table)
        return table


def _refuse_deep(table: dict[str, Any]) -> None:
    """Raise ValueError for what nothing that walks through it could finish."""
    level: list[Any] = [table]
    for _ in range(MOST_NESTED):
        items = [item for each in level for item in (each.values() if type(each) is dict else each)]
        level = [item for item in items if isinstance(item, dict | list)]
    if level:
        raise ValueError(f"{TOO_DEEP}: more than {MOST_NESTED} levels")
