"""Write the paper's figures, the table of its numbers and the report on its claims."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from stickslip.files import PICTURE_FORMATS, write_text
from stickslip.plot.style import check_formats, new_figure, save, style
from stickslip.studies import figures
from stickslip.studies.claim import Value, as_json, as_markdown
from stickslip.studies.report import Report
from stickslip.studies.sources import GALVANETTO, source_named


@dataclass(frozen=True)
class Reproduction:
    """What was written."""

    files: tuple[Path, ...]  # figures, then values.json, values.md, report.json and report.md
    values: tuple[Value, ...]
    report: Report


def reproduce(
    numbers: Iterable[int] | None = None,
    out: str | Path = "out",
    formats: Iterable[str] = PICTURE_FORMATS,
    *,
    source: str = GALVANETTO,
    track: Callable[[Sequence[int]], Iterable[int]] = iter,
) -> Reproduction:
    """Compute and draw figures of a study, and check the numbers and claims beside them.

    Parameters
    ----------
    numbers : iterable of int, optional
        Figures as numbered in the paper; all that there are if none is given.
    out : str or path
        Folder to write to; made if missing. Files of the same names are replaced.
    formats : iterable of {"svg", "pdf", "png"}
        What to write each figure as.
    source : str
        Name of the study, one of `stickslip.studies.sources`; Galvanetto's paper by default.
    track : callable, optional
        Passes the figure numbers on one by one: a place for a progress bar.

    Returns
    -------
    Reproduction
        Paths, values and report.

    Raises
    ------
    ValueError
        A study, figure or format that does not exist; nothing has been written then.
    OSError
        The folder cannot be made or written. No partial file is left.
    """
    study = source_named(source)
    wanted = figures.select(numbers, study.package)
    formats = check_formats(formats)
    folder = writable(Path(out))
    files: list[Path] = []
    captions: dict[int, str] = {}
    pictures: dict[int, str] = {}
    for number in track(wanted):
        captions[number], written = _figure(study.package, number, folder, formats)
        pictures[number] = min(written, key=_for_pages).name
        files += written
    report = replace(check(wanted, source=source), captions=captions, pictures=pictures)
    texts = {
        "values.json": as_json(report.values, captions, report.source),
        "values.md": as_markdown(report.values, captions, report.source),
        "report.json": report.as_json(),
        "report.md": report.as_markdown(),
    }
    for name, text in texts.items():
        write_text(folder / name, text)
    return Reproduction((*files, *(folder / name for name in texts)), report.values, report)


def check(numbers: Iterable[int] | None = None, *, source: str = GALVANETTO) -> Report:
    """Check the numbers and claims of a study, without drawing its figures.

    Parameters
    ----------
    numbers : iterable of int, optional
        Figures beside which they stand, all by default. In Galvanetto's paper 4 to 10 belong to
        the system with Coulomb friction, 11 to 17 to law (9).
    source : str
        As in `reproduce`.

    Returns
    -------
    Report
        Without captions and pictures.

    Raises
    ------
    ValueError
        A study or figure does not exist.

    Examples
    --------
    >>> from stickslip import studies
    >>> [claim.verdict for claim in studies.check([9]).claims]
    ['holds', 'holds']
    """
    study = source_named(source)
    wanted = figures.select(numbers, study.package)
    claims = study.claims(wanted)
    return Report(study.source, study.title, claims, study.values(wanted, claims))


def _for_pages(path: Path) -> int:
    """Rank a picture's formats: a page embeds a vector image if there is one."""
    return (".svg", ".png").index(path.suffix) if path.suffix in (".svg", ".png") else 2


def _figure(
    package: str, number: int, folder: Path, formats: tuple[str, ...]
) -> tuple[str, tuple[Path, ...]]:
    paper = figures.of_study(package)[number]
    with style():
        figure = new_figure(paper.columns, height=paper.height)
        caption = paper.draw(figure)
        return caption, save(figure, folder / f"fig{number:02d}", formats)


def writable(folder: Path) -> Path:
    """Fail before the first computation, not after it."""
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"cannot write to the output folder {folder}")
    return folder
