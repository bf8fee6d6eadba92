"""A proof's result: what was proven, to how many digits, or why it was not."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, ClassVar, Final

import numpy as np

from stickslip.files import checked_path, checked_suffix, write_text
from stickslip.proofs.verify.words import SCHEMA, Refused, read
from stickslip.results.files import register_document
from stickslip.results.result import SUFFIXES, Result

HEAD: Final = ("schema", "claim", "system", "digits", "statement")


@dataclass(frozen=True, eq=False, repr=False)
class Certificate(Result):
    """What was proven about an event map.

    Attributes
    ----------
    proven : bool
    statement : str
        The theorem in words, each of which ``stickslip verify`` proves again, or the reason why
        nothing was proven.
    enclosures : dict of str to str
        Decimals with their radius, ``"0.2773... +/- 5e-31"``.
    digits : int
        Significant digits of the enclosures.
    document : dict
        What `save` writes and ``stickslip verify`` checks; empty if nothing was proven.
    """

    proven: bool
    statement: str
    enclosures: dict[str, str]
    digits: int
    document: dict[str, Any] = field(repr=False)
    _plot: ClassVar = "columns.draw_enclosures"
    _has_picture: ClassVar = False

    def __bool__(self) -> bool:
        """Whether it is proven."""
        return self.proven

    def __repr__(self) -> str:
        """Verdict, statement, an enclosure a line, and what no second program proves."""
        lines = [f"Certificate: {'proven' if self.proven else 'not proven'}", self.statement]
        lines += [f"  {name} = {text}" for name, text in self.enclosures.items()]
        if "mechanism" in self.document:
            lines.append(f"  mechanism (by this program alone): {self.document['mechanism']}")
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        """Lay out the enclosures: as texts, because doubles hold fewer digits, and as doubles."""
        pairs = [text.split(" +/- ") for text in self.enclosures.values()]
        return {
            "name": np.array(list(self.enclosures), dtype=np.str_),
            "enclosure": np.array(list(self.enclosures.values()), dtype=np.str_),
            "middle": np.array([float(middle) for middle, _ in pairs]),
            "radius": np.array([float(radius) for _, radius in pairs]),
        }

    @property
    def undecided(self) -> tuple[tuple[float, float], ...]:
        """Intervals that a list of orbits leaves undecided: where there are none it is complete."""
        return tuple((float(a), float(b)) for a, b in self.document.get("undecided", ()))

    def save(self, path: str | PathLike[str]) -> None:
        """Write the certificate as JSON, which ``stickslip verify`` checks again.

        Parameters
        ----------
        path : str or path
            Ends in ``.json`` or has no suffix: the certificate, which `stickslip.load` reads too;
            ``.csv`` and ``.nc`` as of any result. A file of that name is replaced.

        Raises
        ------
        ValueError
            Nothing was proven, or the name has another suffix.
        OSError
            The file cannot be written.
        """
        # Not the format of other results: a program that shares nothing with this one reads it.
        if checked_suffix(checked_path(path), SUFFIXES) in (".csv", ".nc"):
            super().save(path)
        else:
            write_text(path, self.text())

    def text(self) -> str:
        """Return what `save` writes.

        Raises
        ------
        ValueError
            Nothing was proven.
        """
        if not self.proven:
            raise ValueError(f"nothing was proven, so there is no certificate: {self.statement}")
        return json.dumps(self.document, indent=1) + "\n"


def certificate(
    claim: str, system: dict[str, str], digits: int, entries: dict[str, Any]
) -> Certificate:
    """Make the certificate of a proven claim; `Refused` if a certificate cannot hold its data."""
    document = {"schema": SCHEMA, "claim": claim, "system": system, "digits": digits, **entries}
    document["statement"] = read(document).statement()
    return certificate_of(document)


def certificate_of(document: dict[str, Any]) -> Certificate:
    """Make a certificate from what `Certificate.save` has written.

    Raises
    ------
    Refused
        The document says something that no certificate does, or not what its numbers say.
    """
    statement = read(document).statement()
    if document.get("statement") != statement:
        raise Refused("the statement is not what the numbers say")
    entries = {name: value for name, value in document.items() if name not in HEAD}
    found = _enclosures(entries)
    return Certificate(True, statement, found, document["digits"], document)


register_document(SCHEMA, certificate_of)


def refusal(reason: object, digits: int) -> Certificate:
    """Say that nothing was proven, and why."""
    return Certificate(False, f"Nothing is proven: {reason}.", {}, digits, {})


def _enclosures(entries: dict[str, Any]) -> dict[str, str]:
    """Gather all decimals with a radius; of a branch, both ends."""
    found = {}
    for end in (0, -1) if "nodes" in entries else ():
        value, place = entries["nodes"][end]
        found[f"d at {entries['parameter']} = {value}"] = f"{place} +/- {entries['radii'][end]}"
    for name, value in entries.items():
        several = (
            {f"{name}[{k}]": each for k, each in enumerate(value)}
            if isinstance(value, list)
            else {name: value}
        )
        for key, each in several.items():
            if isinstance(each, dict):
                found.update({f"{key}.{k}": v for k, v in _enclosures(each).items()})
            elif isinstance(each, str) and " +/- " in each:
                found[key] = each
    return found
