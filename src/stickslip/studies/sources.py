"""Find studies by the names of their packages; each is a source with figures and claims.

A package of `stickslip.studies` is a study. It offers ``SOURCE`` and ``TITLE``, ``FIGURES`` in
``figures`` (see `stickslip.studies.figures`) and in ``claims`` ``CLAIMS``: by the number of a
figure a function that makes those beside it. Its table of numbers is that of its claims, unless it
offers ``values(figures, claims)``.
"""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass, replace
from typing import Any, Final

from stickslip.studies.claim import Claim, Value
from stickslip.vocabulary import did_you_mean

GALVANETTO: Final = "galvanetto2001"
FOLDER: Final = "stickslip.studies"


@dataclass(frozen=True)
class Source:
    """A study."""

    name: str  # as `source_named` takes it
    source: str  # author and year
    title: str  # what was published, or what is studied

    @property
    def package(self) -> str:
        """Package that holds its modules."""
        return f"{FOLDER}.{self.name}"

    def claims(self, figures: tuple[int, ...]) -> tuple[Claim, ...]:
        """Check the claims that belong to some figures."""
        made = _module(f"{self.package}.claims").CLAIMS
        return tuple(
            replace(claim, figure=number)
            for number in figures
            if number in made
            for claim in made[number]()
        )

    def values(self, figures: tuple[int, ...], claims: tuple[Claim, ...]) -> tuple[Value, ...]:
        """Numbers that belong to some figures, given the claims."""
        own = getattr(_module(self.package), "values", None)
        if own is not None:
            found: tuple[Value, ...] = own(figures, claims)
            return found
        return tuple(value for claim in claims for value in claim.values)


def sources() -> tuple[Source, ...]:
    """All studies, by name."""
    folder = _module(FOLDER)
    names = sorted(module.name for module in pkgutil.iter_modules(folder.__path__) if module.ispkg)
    packages = {name: _module(f"{FOLDER}.{name}") for name in names}
    return tuple(Source(name, module.SOURCE, module.TITLE) for name, module in packages.items())


def source_named(name: str) -> Source:
    """Return the study of a name."""
    known = {source.name: source for source in sources()}
    if name not in known:
        raise ValueError(f"there is no study {name!r}. {did_you_mean(name, list(known))}")
    return known[name]


def _module(name: str) -> Any:
    return importlib.import_module(name)
