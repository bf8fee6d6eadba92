"""Models as TOML files: written by hand, or by `write_model`, which keeps every digit."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.files import write_text
from stickslip.study.law_values import within
from stickslip.study.model_values import Model, model_of_values, model_values

if TYPE_CHECKING:
    from os import PathLike

__all__ = ["model_text", "read_model", "toml_table", "write_model"]


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
    path = Path(path)
    with within(f"{path}: "):
        return model_of_values(toml_table(path.read_bytes()))


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
    write_text(Path(path), model_text(model))


def model_text(model: Model) -> str:
    """Return what `write_model` writes.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain or Oscillator
        With built-in friction laws.

    Returns
    -------
    str
        A TOML document.

    Raises
    ------
    ValueError
        A friction law is a Python function, which a file cannot hold.
    """
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


def toml_table(content: bytes) -> dict[str, Any]:
    """Read TOML.

    Raises
    ------
    ValueError
        It is none; the message names the line.
    """
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(
            f"not UTF-8 text: byte {content[error.start]:#x} in line {line}. "
            "Save the file as UTF-8."
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"not TOML: {error}") from None
    except ValueError:
        raise ValueError("a whole number in it has more than 4300 digits") from None
    except RecursionError:
        raise ValueError("its arrays or tables are nested too deeply") from None
