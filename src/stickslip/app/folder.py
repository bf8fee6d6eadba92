"""The folder of the page: its scripts, and what is shipped with them."""

from __future__ import annotations

import posixpath
import re
import shutil
from functools import cache
from pathlib import Path
from typing import Any, Final

import msgspec

STATIC: Final = Path(__file__).with_name("static")
SHIPPED: Final = STATIC / "shipped"
PRESETS: Final = "presets.json"
LIMITS: Final = "limits.json"
IMPORT: Final = re.compile(r'(?<=from ")(\.[^"]+)(?=";)')
MAIN: Final = "static/main.js"
HEAD: Final = "  </head>"


@cache
def presets() -> list[dict[str, Any]]:
    """Return names, titles and states of the page."""
    known: list[dict[str, Any]] = msgspec.json.decode((SHIPPED / PRESETS).read_bytes())
    return known


def allowed() -> dict[str, Any]:
    """Return models, laws, bounds and formats; films as MP4 where this machine can write them."""
    known: dict[str, Any] = msgspec.json.decode((SHIPPED / LIMITS).read_bytes())
    if not shutil.which("ffmpeg"):
        known["exports"]["mechanism"].remove("mp4")
    return known


def preset_names() -> list[str]:
    """Return the names of the views that a page can be opened with."""
    return [preset["name"] for preset in presets()]


def scripts() -> list[str]:
    """Paths of the page's script and of all that it needs."""
    found = [MAIN]
    for name in found:  # which grows meanwhile
        here = posixpath.dirname(name)
        text = (STATIC.parent / name).read_text(encoding="utf-8")
        needed = [posixpath.normpath(f"{here}/{path}") for path in IMPORT.findall(text)]
        found += [path for path in needed if path not in found]
    return found


@cache
def page() -> str:
    """Text of the page; it names all scripts, which else would be found one behind the other."""
    text = (STATIC / "index.html").read_text(encoding="utf-8")
    links = (f'    <link rel="modulepreload" href="{name}" />\n' for name in scripts())
    return text.replace(HEAD, "".join(links) + HEAD)
