"""Tell what only a person can fill in before a release, and what of it is missing.

    python -m tests.acceptance.release

Exit code 1 while anything is missing; the release workflow asks before it builds a tag.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
URLS = ("Homepage", "Documentation", "Issues", "Changelog")
NOBODY = "stickslip developers"
RELATIVE = re.compile(r"\]\((?!https://|#)([^)]+)\)")


def missing(root: Path = ROOT) -> list[str]:
    """Name everything that is missing, with the file that it belongs to."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    paper = json.loads((root / "codemeta.json").read_text(encoding="utf-8"))
    archive = json.loads((root / ".zenodo.json").read_text(encoding="utf-8"))
    citation = (root / "CITATION.cff").read_text(encoding="utf-8")
    links = RELATIVE.findall((root / "README.md").read_text(encoding="utf-8"))
    authors = [project["authors"], paper["author"], archive["creators"]]
    given = {
        f"pyproject.toml: [project.urls] {name}": name in project.get("urls", {}) for name in URLS
    } | {
        "codemeta.json: codeRepository": "codeRepository" in paper,
        "CITATION.cff: repository-code": bool(re.search("^repository-code:", citation, re.M)),
        f"README.md: absolute links ({len(links)} are relative)": not links,
        f"authors: still {NOBODY}": NOBODY not in f"{authors} {citation}",
    }
    return [name for name, there in given.items() if not there]


def main() -> int:
    """Print what is missing."""
    gaps = missing()
    print("\n".join(gaps) or "nothing is missing")
    return int(bool(gaps))


if __name__ == "__main__":
    sys.exit(main())
