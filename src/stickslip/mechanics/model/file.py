"""Models as TOML files: written by hand, or by `write_model`, which keeps every digit."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import fields
from difflib import get_close_matches
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from stickslip.checks import shown
from stickslip.files import checked_path, checked_suffix, read_text, write_text
from stickslip.mechanics.friction.law import FrictionLaw
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
from stickslip.mechanics.model.contact import Contact, Harmonic
from stickslip.mechanics.model.structure import StateSpace, Structure
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Units
from stickslip.results.files import register_part
from stickslip.vocabulary import did_you_mean, suggests

if TYPE_CHECKING:
    from os import PathLike

T = TypeVar("T")


PHYSICAL: Final = ("m", "k", "k12", "fs1", "fs2", "v_dr")
MODELS: Final[dict[str, type[BeltModel]]] = {
    "two_block": TwoBlock,
    "chain": Chain,
    "blocks": Blocks,
    "oscillator": Oscillator,
    "state_space": StateSpace,
    "structure": Structure,
}
"""Kinds of models; the keys of a file are the arguments of the class."""
PER_BLOCK: Final = {"chain": "static", "blocks": "mass"}
"""Keys with an entry for each block."""


def _keys(table: type) -> dict[str, Any]:
    """Keys of what makes a thing, with their defaults; those needed have none."""
    given = {"contacts": "contact"}
    known = signature(table).parameters.values()
    return {given.get(each.name, each.name): each.default for each in known}


def _needed(keys: Mapping[str, Any]) -> list[str]:
    return [name for name, default in keys.items() if default is Parameter.empty]


# --- from models ------------------------------------------------------------------------------


def model_values(model: Model) -> dict[str, Any]:
    """Return a model as plain values, keyed as in a file; `model_of_values` makes it again."""
    checked_model(model)
    kind, cls = next((kind, cls) for kind, cls in MODELS.items() if isinstance(model, cls))
    told = {"kind": kind}
    for key, default in _keys(cls).items():
        value = getattr(model, "contacts" if key == "contact" else key)
        usual = 0.0 if default is None else default
        if value is not None and (isinstance(value, tuple | FrictionLaw) or np.any(value != usual)):
            told[key] = _plain(value)
    # In TOML what is no table comes first.
    return dict(sorted(told.items(), key=lambda item: _is_table(item[1])))


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict))


def _plain(value: Any) -> Any:
    """Return what makes a model as numbers, texts, lists and tables."""
    match value:
        case FrictionLaw():
            return law_values(value)
        case Harmonic() | Units():
            return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
        case Contact():
            speed, wave = value.belt
            own: dict[str, Any] = {
                "at": value.at,
                "static": value.static,
                "V": speed,
                "load": value.load,
                "stiffness": value.stiffness,
            }
            own |= {"belt": wave, "friction": value.friction}
            return {name: _plain(part) for name, part in own.items() if part is not None}
        case tuple():
            return [_plain(part) for part in value]
        case _:
            return np.asarray(value).tolist()


# --- to models --------------------------------------------------------------------------------


def model_of_values(table: dict[str, Any]) -> Model:
    """Make the model of a file's content; ValueError names the key that is wrong."""
    if "kind" not in table:
        close = get_close_matches("kind", table, n=1)
        instead = f" in place of {shown(close[0])}" if close else ""
        raise ValueError(f'lacks kind: write kind = "two_block"{instead}. {listed(MODELS)}')
    kind = table["kind"]
    if not isinstance(kind, str):
        raise ValueError(f"kind = {shown(kind)} must be text in quotation marks. {listed(MODELS)}")
    if kind not in MODELS:
        raise ValueError(f"kind = {shown(kind)} is no kind of model. {did_you_mean(kind, MODELS)}")
    keys = _keys(MODELS[kind])
    physical = kind == "two_block" and "physical" in table
    known = ["kind", *sorted(keys, key=lambda name: name in ("friction", *PARTS))]
    known += ["physical"] * (kind == "two_block")
    refuse_unknown(table, known, is_whole=True)
    given = {name: table[name] for name in keys if name in table}
    # First: numbers that slipped under a table are missing above it.
    if "friction" in given:
        listing = table.get(PER_BLOCK.get(kind, ""), [None] * (2 if kind == "two_block" else 1))
        n_blocks = len(listing) if isinstance(listing, list) else None
        given["friction"] = friction_of(given["friction"], n_blocks)
    refuse_missing(table, ["friction"] if physical else _needed(keys))
    if physical:
        return _physical(table["physical"], given)
    if isinstance(given.get("forcing"), list) and not issubclass(MODELS[kind], Structure):
        raise ValueError(
            f"[[forcing]] is for structures: a model of the kind {kind} has one forcing. "
            "Write [forcing], once."
        )
    for name, make in PARTS.items():
        if name in given:
            given[name] = make(name, given[name])
    if "contact" in given:
        given["contacts"] = given.pop("contact")
    return MODELS[kind](**given)


def _physical(table: Any, given: Mapping[str, Any]) -> TwoBlock:
    if twice := [name for name in given if name != "friction"]:
        raise ValueError(
            f"{', '.join(twice)} beside [physical], from which the dimensionless numbers and the "
            "units follow. Give either [physical] or the dimensionless numbers."
        )
    quantities = _numbers(table, "[physical]", PHYSICAL, optional=("c",))
    with within("[physical] "):
        return TwoBlock.from_physical(**quantities, friction=given["friction"])


def _contacts(name: str, given: Any) -> list[Contact]:
    if not (isinstance(given, list) and given):
        raise ValueError(f"{name} = {shown(given)}: write [[{name}]], once for each.")
    return [_contact(f"[[{name}]] {k}", own) for k, own in enumerate(given)]


def _forcing(name: str, given: Any) -> Harmonic | list[Harmonic]:
    if isinstance(given, list):
        return [_part(Harmonic, f"[[{name}]] {k}", own) for k, own in enumerate(given)]
    return _part(Harmonic, f"[{name}]", given)


def _contact(place: str, table: Any) -> Contact:
    optional = ("static", "V", "load", "stiffness", "belt")
    given = dict(_numbers(table, place, ("at", "friction"), optional))
    with within(f"{place} "):
        at, wave = given["at"], given.pop("belt", None)
        if isinstance(at, list) and all(isinstance(entry, int) for entry in at):
            if len(at) != 2:
                raise ValueError(
                    f"at = {shown(at)}: two whole numbers name two bodies that rub on each other; "
                    "weights, one for each coordinate, are decimal numbers, [1.0, 0.0]."
                )
            given["at"] = tuple(at)
        if isinstance(given["friction"], list):
            raise ValueError("friction: a contact has one law. Write [contact.friction] once.")
        given["friction"] = friction_of(given["friction"], None)
        if wave is not None:
            given["V"] = (given.get("V", 0.0), _part(Harmonic, "belt", wave))
        return Contact(**given)


def _part(cls: type[T], place: str, table: Any) -> T:
    """Make what a table holds the arguments of."""
    keys = _keys(cls)
    needed = _needed(keys)
    rest = tuple(name for name in keys if name not in needed)
    numbers = _numbers(table, place, tuple(needed), rest)
    with within(f"{place} "):
        return cls(**numbers)


PARTS: Final[dict[str, Callable[[str, Any], Any]]] = {
    "contact": _contacts,
    "forcing": _forcing,
    "units": lambda name, given: _part(Units, f"[{name}]", given),
}
"""Tables of a model, and who makes what they hold."""


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


register_part("model", BeltModel, model_values, model_of_values)


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
    TwoBlock, Blocks, Chain, Oscillator or Structure
        The model.

    Raises
    ------
    ValueError
        The file is not TOML; a key is unknown or missing; a value is of the wrong type or
        out of its range. The message names file and key, and what is allowed.
    OSError
        The file cannot be read.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import stickslip as ss
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "block.toml"
    >>> _ = file.write_text('''
    ... kind = "oscillator"
    ... V = 0.1
    ... friction = {law = "coulomb", mu = 0.5}
    ... ''')
    >>> ss.read_model(file)
    Oscillator(V=0.1, friction=Coulomb(mu=0.5, viscous=0.0), damping=0.0, forcing=None)
    """
    table = read_toml(path)
    with within(f"{path}: "):
        return model_of_values(table)


@suggests
def write_model(model: Model, path: str | PathLike[str]) -> None:
    """Write a model to a TOML file, which `read_model` turns into an equal model.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
        With built-in friction laws or formulas; numbers are written with every digit.
    path : str or path
        A file of that name is replaced; it is whole at any time.

    Raises
    ------
    ValueError
        A friction law is a Python function, which a file cannot hold.
    OSError
        The file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import stickslip as ss
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "coulomb.toml"
    >>> ss.write_model(ss.examples.coulomb(), file)
    >>> ss.read_model(file) == ss.examples.coulomb()
    True
    """
    checked_suffix(checked_path(path), ("", ".toml"))
    write_text(path, model_text(model))


def model_text(model: Model) -> str:
    """Return what `write_model` writes, a TOML document."""
    return "\n".join(_lines(model_values(model))) + "\n"


def _lines(values: Mapping[str, Any], within: str = "") -> list[str]:
    """Write values: texts of JSON are TOML, and so is Python's exact form of a finite number."""
    lines = []
    for key, value in values.items():  # numbers come before tables
        name = f"{within}{key}"
        if isinstance(value, dict):
            lines += ["", f"[{name}]", *_lines(value, f"{name}.")]
        elif isinstance(value, list) and isinstance(value[0], dict):
            for table in value:
                lines += ["", f"[[{name}]]", *_lines(table, f"{name}.")]
        else:
            text = json.dumps(value) if isinstance(value, str) else repr(value)
            lines.append(f"{key} = {text}")
    return lines


def read_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """Read a TOML file; ValueError names file and line of what is wrong."""
    text = read_text(path)
    with within(f"{path}: "):
        return toml_of(text)


def toml_of(text: str) -> dict[str, Any]:
    """Read a TOML document; ValueError names the line of what is wrong."""
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
