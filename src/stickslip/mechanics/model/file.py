"""Models as TOML files: written by hand, or by `write_model`, which keeps every digit."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from stickslip.files import checked_path, checked_suffix, read_text, write_text
from stickslip.mechanics.friction.values import within
from stickslip.mechanics.model.values import Model, model_of_values, model_values
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from os import PathLike

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
        With built-in friction laws; numbers are written with every digit.
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
    """Write values; Python's shortest exact form of a finite number is TOML too."""
    return [
        f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {value!r}"
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
