"""Type the lines of docs/start.md into an empty environment; write down what came.

    python docs/transcript.py        # a network and some minutes; writes docs/transcript.txt

Every line of the page's blocks is typed as it stands, in their order; the files that the page shows
are written under the names it gives them. The pictures stay in the folder that is named at the end.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.DOTALL)
MODEL, SCRIPT = "mine.toml", "mine.py"


def commands(page: str, folder: Path) -> list[str]:
    """Lines to type; the model and the Python of the page become files in the folder."""
    typed: list[str] = []
    for language, text in BLOCK.findall(page.partition("## Transcript")[0]):
        if language == "toml":
            (folder / MODEL).write_text(text)
            typed.append(f"cat {MODEL}")
        elif language == "python":
            (folder / SCRIPT).write_text(text)
            typed.append(f"python {SCRIPT}")
        else:
            typed += text.splitlines()
    return [line.replace("pip install .", f"pip install --quiet {ROOT}") for line in typed]


def main() -> int:
    """Return the first exit code that is not 0."""
    folder = Path(tempfile.mkdtemp(prefix="stickslip-start-"))
    kept = ("PATH", "PIP_", "SSL_")  # where programs and packages come from
    environment = {k: v for k, v in os.environ.items() if k.startswith(kept)}
    environment |= {"HOME": str(folder), "COLUMNS": "100", "NO_COLOR": "1", "MPLBACKEND": "Agg"}
    typed = commands((ROOT / "docs" / "start.md").read_text(), folder)
    script = "set -e\n" + "\n".join(f"echo '$ {line}'\n{line}" for line in typed)
    ran = subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    said = ran.stdout.replace(f"--quiet {ROOT}", ".").replace(str(folder), "~")
    said = re.sub(r"^WARNING: Location .*\n|^\[notice\].*\n", "", said, flags=re.MULTILINE)
    (ROOT / "docs" / "transcript.txt").write_text(said)
    sys.stdout.write(said)
    sys.stdout.write(f"\nin {folder}: {sorted(p.name for p in folder.iterdir())}\n")
    return ran.returncode


if __name__ == "__main__":
    sys.exit(main())
