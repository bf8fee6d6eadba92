"""Which share of each layer the tests run: statements and branches.

    python -m tests.acceptance.covered --jobs 2        # the suite twice over: twenty minutes

The suite runs once compiled. Compiled kernels cannot be measured, so that their tests, marked
`kernel`, and those of the mechanics run as plain Python, too, where most motions are too slow: a
test is stopped after some seconds, and what it ran until then counts. Kernels have rows of their
own; code that is generated has none. The shares go to `docs/covered.csv`.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from coverage import Coverage

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "docs" / "covered.csv"
HEAD = ("layer", "version", "date", "statements", "run_percent", "branches", "taken_percent")
COUNTS = ("num_statements", "covered_lines", "num_branches", "covered_branches")
SUITE = ("-m", "not slow")
KERNELS = ("-m", "kernel")
MECHANICS = ("tests/mechanics", *SUITE, "-p", "tests.acceptance.clock")


def measure(data: Path, jobs: int, arguments: tuple[str, ...], **settings: str) -> None:
    """Run tests, and add the lines that they run to a file."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", str(jobs), "--tb=line"]
    cover = ["--cov=stickslip", "--cov-append", "--cov-report="]
    environment = os.environ | {"COVERAGE_FILE": str(data)} | settings
    subprocess.run([*command, *cover, *arguments], cwd=ROOT, env=environment, check=False)


def layer_of(path: str) -> str:
    """Name the row that a file belongs to."""
    folder, *rest = Path(path).parts[Path(path).parts.index("stickslip") + 1 :]
    layer = folder if rest else "(single files)"
    return f"{layer}, kernels" if path.endswith("_kernels.py") else layer


def counted(data: Path, folder: Path) -> dict[str, list[int]]:
    """Add up statements and branches by layer."""
    cover = Coverage(data_file=str(data), config_file=str(ROOT / "pyproject.toml"))
    cover.load()
    cover.json_report(outfile=str(folder / "report.json"))
    layers: dict[str, list[int]] = defaultdict(lambda: [0] * len(COUNTS))
    for path, told in json.loads((folder / "report.json").read_text())["files"].items():
        for name in (layer_of(path), "all"):
            sums = zip(layers[name], COUNTS, strict=True)
            layers[name] = [so_far + told["summary"][count] for so_far, count in sums]
    return layers


def write(layers: dict[str, list[int]]) -> None:
    """Write the table anew."""
    day = datetime.now(UTC).date().isoformat()
    with TABLE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEAD)
        for layer, (statements, ran, branches, taken) in sorted(layers.items()):
            about = (layer, version("stickslip"), day)
            writer.writerow(
                [*about, statements, share(ran, statements), branches, share(taken, branches)]
            )


def share(part: int, whole: int) -> str:
    """Write a percentage; nothing of nothing."""
    return f"{100 * part / whole:.1f}" if whole else ""


def main() -> None:
    """Run the suite and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, default=2)
    jobs = parser.parse_args().jobs
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "lines"
        measure(data, jobs, KERNELS, NUMBA_DISABLE_JIT="1")
        measure(data, jobs, MECHANICS, NUMBA_DISABLE_JIT="1")
        measure(data, jobs, SUITE)
        layers = counted(data, Path(folder))
    write(layers)


if __name__ == "__main__":
    main()
