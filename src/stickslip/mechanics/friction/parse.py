"""Friction laws as text, on the command line and in model files."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.checks import shown
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.vocabulary import did_you_mean


def law_from_text(text: str, laws: Mapping[str, type[FrictionLaw]]) -> FrictionLaw:
    """Read ``name:parameter=value,parameter=value``; the opposite of ``str(law)``."""
    name, _, rest = text.strip().partition(":")
    name = name.strip().lower().replace("_", "-")
    if name not in laws:
        raise ValueError(f"there is no friction law {shown(name)}. {did_you_mean(name, laws)}")
    law = laws[name]
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
