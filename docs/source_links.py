"""The role ``{source}``: from an equation to the function that implements it.

``{source}`mechanics.eventmap.onset``` links to a highlighted page of that file, at that line;
``{source}`words <path>``` shows other words. Names are looked up in the source, so that compiled
functions, too, can be named; one that is not there is a warning, with which ``make docs`` fails.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from sources import PACKAGE, place_of
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util import logging
from sphinx.util.docutils import ReferenceRole

PAGES = "_source"


def page_of(file: Path) -> str:
    """Name of the page that shows a file."""
    return f"{PAGES}/{file.relative_to(PACKAGE).with_suffix('').as_posix()}"


class SourceRole(ReferenceRole):
    """A link to where something is defined."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        try:
            file, line = place_of(self.target)
        except LookupError as error:
            logging.getLogger(__name__).warning("source: %s", error, location=self.get_location())
            return [nodes.literal(text=self.title)], []
        self.env.note_dependency(str(file))
        _shown(self.env).setdefault(self.env.docname, set()).add(file)
        page = self.env.app.builder.get_relative_uri(self.env.docname, page_of(file))
        text = self.title if self.has_explicit_title else self.target.rpartition(".")[2]
        link = nodes.reference("", "", refuri=f"{page}#line-{line}", internal=True)
        link += nodes.literal(text=text)
        return [link], []


def _shown(env: BuildEnvironment) -> dict[str, set[Path]]:
    """Files that each page links to; kept between builds."""
    if not hasattr(env, "stickslip_sources"):
        env.stickslip_sources = {}
    return env.stickslip_sources


def _forget(app: Sphinx, env: BuildEnvironment, docname: str) -> None:
    _shown(env).pop(docname, None)


def _pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    for file in sorted(set().union(*_shown(app.env).values())):
        code = file.read_text(encoding="utf-8")
        body = app.builder.highlighter.highlight_block(code, "python", lineanchors="line")
        title = file.relative_to(PACKAGE.parent).as_posix()
        yield page_of(file), {"title": title, "body": f"<h1>{title}</h1>{body}"}, "page.html"


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the role and the pages it links to."""
    app.add_role("source", SourceRole())
    app.connect("env-purge-doc", _forget)
    app.connect("html-collect-pages", _pages)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
