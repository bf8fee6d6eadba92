"""Types and a linter for the page of the explorer: `src/stickslip/app/static`.

    python -m tests.house.page.checker    install both beside the environment, then check

They are programs for node, pinned in `package-lock.json` with their hashes. Where there is no node,
or they cannot be installed, the check is told as skipped.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
STATIC = Path(__file__).parents[3] / "src" / "stickslip" / "app" / "static"
PROGRAMS = Path(sys.prefix) / "page"
LOCK = "package-lock.json"


def install() -> None:
    """Install what the lock names, once per lock."""
    npm = shutil.which("npm")
    if npm is None or is_installed():
        return
    shutil.rmtree(PROGRAMS, ignore_errors=True)
    PROGRAMS.mkdir(parents=True)
    for name in ("package.json", LOCK):
        shutil.copy(HERE / name, PROGRAMS)
    command = [npm, "ci", "--prefix", str(PROGRAMS), "--no-audit", "--no-fund", "--ignore-scripts"]
    if subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode:
        (PROGRAMS / LOCK).unlink()


def is_installed() -> bool:
    """Whether the programs are those of the lock."""
    lock = PROGRAMS / LOCK
    return lock.is_file() and lock.read_bytes() == (HERE / LOCK).read_bytes()


def reason_to_skip() -> str | None:
    """Why the page cannot be checked here, if so."""
    if shutil.which("node") is None:
        return "there is no node"
    if not is_installed():
        return "TypeScript and oxlint are not installed: make page"
    return None


def faults(static: Path = STATIC) -> str:
    """Return what the checkers find in a folder like `static/`; empty if nothing."""
    programs = PROGRAMS / "node_modules"
    types = programs / "typescript" / "bin" / "tsc"
    config = json.loads((HERE / "tsconfig.json").read_text(encoding="utf-8"))
    config["include"] = [f"{static}/**/*.js"]
    lint = programs / "oxlint" / "bin" / "oxlint"
    with tempfile.TemporaryDirectory() as folder:
        project = Path(folder, "tsconfig.json")
        project.write_text(json.dumps(config), encoding="utf-8")
        commands = [
            [str(types), "--project", str(project), "--pretty", "false"],
            [str(lint), "--config", str(HERE / ".oxlintrc.json"), "--format", "unix", str(static)],
        ]
        told = [subprocess.run(["node", *one], capture_output=True, text=True) for one in commands]
    return "".join(one.stdout + one.stderr for one in told if one.returncode)


def main() -> int:
    """Install, check, tell; 1 where a fault is found."""
    install()
    if reason := reason_to_skip():
        print(f"the page's types and linter: skipped, {reason}")
        return 0
    found = faults()
    print(found or "the page's types and linter: no faults")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
