"""Prove what a figure shows: certificates, a table of what they state, and a picture.

A study that can offers a module ``proven`` with ``proofs()``, ``unproven(proofs)`` and
``draw(proofs, figure)``.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.files import PICTURE_FORMATS, write_text
from stickslip.plot.style import new_figure, save, style
from stickslip.studies.reproduction import writable
from stickslip.studies.sources import source_named, sources

if TYPE_CHECKING:
    from stickslip.proofs.certificate import Certificate

HEIGHT = 3.2  # inches, of the picture


@dataclass(frozen=True)
class Proof:
    """One statement for all values of a parameter in an interval, proven or not."""

    name: str
    what: str
    low: Fraction
    high: Fraction
    certificate: Certificate

    def text(self) -> str:
        """Say it in a line, and in another why it is not proven."""
        verdict = "proven" if self.certificate else "not proven"
        ends = f"{float(self.low):.12g} to {float(self.high):.12g}"
        told = f"{self.name:14s}{verdict:12s}{ends:34s}{self.what}"
        return told if self.certificate else f"{told}\n  {self.certificate.statement}"


@dataclass(frozen=True)
class Proven:
    """What was written, and what it says."""

    files: tuple[Path, ...]
    proofs: tuple[Proof, ...]
    unproven: tuple[str, ...]

    def text(self) -> str:
        """Tabulate what is proven, then what is not."""
        rest = (f"not proven: {each}" for each in self.unproven)
        return "\n".join([*(each.text() for each in self.proofs), "", *rest]) + "\n"


def prove(
    source: str, out: Path, *, track: Callable[[Iterator[Proof]], Iterable[Proof]] = iter
) -> Proven:
    """Prove the figure of a study, and write certificates, the table and the picture."""
    study = source_named(source)
    if importlib.util.find_spec(f"{study.package}.proven") is None:
        able = [
            s.name for s in sources() if importlib.util.find_spec(f"{s.package}.proven") is not None
        ]
        raise ValueError(f"nothing of {source} is proven by a command; of {', '.join(able)} it is")
    figure = importlib.import_module(f"{study.package}.proven")
    folder = writable(out)
    files, proofs = [], []
    for proof in track(figure.proofs()):
        proofs.append(proof)
        if proof.certificate:
            files.append(folder / f"{proof.name}.json")
            proof.certificate.save(files[-1])
    with style():
        drawn = new_figure("two", height=HEIGHT)
        figure.draw(proofs, drawn)
        files += save(drawn, folder / "proven", PICTURE_FORMATS)
    files.append(folder / "proven.txt")
    done = Proven(tuple(files), tuple(proofs), tuple(figure.unproven(proofs)))
    write_text(files[-1], done.text())
    return done
