"""Packages that only some uses need: what is missing is told by the name of its extra."""

from __future__ import annotations

from importlib.util import find_spec

from stickslip.errors import MissingExtraError


def require_extra(extra: str, purpose: str, *modules: str) -> None:
    """Check that the modules of an extra can be imported, or say what to install."""
    # `purpose` is what needs them, in the plural.
    for name in modules:
        if find_spec(name) is None:
            raise MissingExtraError(
                f'{purpose} need the package {name}: pip install "stickslip[{extra}]"', name=name
            )
