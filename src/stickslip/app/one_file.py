"""The exported page as one file, which opens from a disk or a mail: it loads nothing beside it.

Browsers refuse scripts, threads and data that a page opened as a file would load. So scripts stand
in its import map, data in an element that ``static/one-file.js`` reads for them.
"""

from __future__ import annotations

import base64
import posixpath
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import msgspec

from stickslip.app.folder import IMPORT

THREAD: Final = "static/live.js"
FIRST: Final = "static/one-file.js"
STYLE: Final = '<link rel="stylesheet" href="static/style.css" />'
LOADED: Final = re.compile(r' *<link rel="(?:icon|modulepreload)".*\n')
NO_SERVER: Final = re.compile(r" *<script>if .*</script>\n")
MAIN: Final = '<script type="module" src="static/main.js"></script>'


def one_file(folder: Path) -> str:
    """Return the text of a page that shows what an exported folder shows."""
    files = {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    scripts = {
        name: path.read_text(encoding="utf-8")
        for name, path in files.items()
        if name.endswith(".js")
    }
    imports = {
        name: _address(_relinked(name, text, lambda other: other)) for name, text in scripts.items()
    }
    data = {
        name: _encoded(path.read_bytes())
        for name, path in files.items()
        if name.endswith(".json") or name.startswith(("static/live/", "static/shipped/"))
    }
    data[THREAD] = _encoded(_whole(THREAD, scripts).encode())
    page = files["index.html"].read_text(encoding="utf-8")
    style = files["static/style.css"].read_text(encoding="utf-8")
    head = f"""\
<script id="files" type="application/json">{_json(data)}</script>
<script>{scripts[FIRST]}</script>
<script type="importmap">{_json({"imports": imports})}</script>
<script type="module">import "static/main.js";</script>"""
    page = LOADED.sub("", NO_SERVER.sub("", page))
    return page.replace(STYLE, f"<style>{style}</style>").replace(MAIN, head)


def _relinked(name: str, text: str, to: Callable[[str], str]) -> str:
    """Name what a script imports by what stands for its path."""
    here = posixpath.dirname(name)
    return IMPORT.sub(lambda found: to(posixpath.normpath(f"{here}/{found[1]}")), text)


def _whole(name: str, scripts: dict[str, str]) -> str:
    """Return a script with all that it imports inside: threads know no import map."""
    return _relinked(name, scripts[name], lambda other: _address(_whole(other, scripts)))


def _address(script: str) -> str:
    return f"data:text/javascript;base64,{_encoded(script.encode())}"


def _json(content: dict[str, Any]) -> str:
    return msgspec.json.encode(content).decode()


def _encoded(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")
