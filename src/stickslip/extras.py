"""Packages that only some uses need: what is missing is told by the name of its extra."""

from __future__ import annotations

from importlib.util import find_spec


class MissingExtraError(ModuleNotFoundError):
    """A package that one of the project's extras brings is not installed."""


def require_extra(extra: str, purpose: str, *modules: str) -> None:
    """Check that what an extra brings can be imported.

    Parameters
    ----------
    extra : str
        As in ``pip install "stickslip[extra]"``.
    purpose : str
        What needs it, in the plural.
    *modules : str
        Names to import.

    Raises
    ------
    MissingExtraError
        A ModuleNotFoundError that says what to install.
    """
    for name in modules:
        if find_spec(name) is None:
            raise MissingExtraError(
                f'{purpose} need the package {name}: pip install "stickslip[{extra}]"', name=name
            )
