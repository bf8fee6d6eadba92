"""Interrupts at random moments of ten commands: each must end in code 130 within a second.

    python -m tests.acceptance.interrupts --n 500      # ten minutes of one idle core

Kernels are compiled before. The moment is drawn from the time that a command takes as a whole,
most often from its beginning, where packages and kernels are loaded. What is not whole is a
failure: a file of another content than that of a run that was left alone, a file that is only
temporary, a store that does not resume to the same bytes. Interrupts that come before the
program's first line are the Python interpreter's; they are counted apart.
"""

from __future__ import annotations

import argparse
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

LONGEST = 1.0  # seconds between the signal and the end
LATEST = 6.0  # seconds after the start: then only more of the same is computed
CALM = "stickslip: interrupted"
PLAN = """\
store = "map.zarr"
observables = [{name = "attractor", transient = 400, n = 640}]
[model]
kind = "two_block"
alpha = 1.2
beta = 1.3
V = 0.0366
friction = {law = "coulomb", mu = 0.22}
[axes]
V = {from = 0.03, to = 0.05, n = 60}
alpha = {from = 1.1, to = 1.3, n = 60}
[chunks]
V = 6
alpha = 6
"""
COMMANDS = {
    "map": "map --preset law9 --grid 500 --out map.csv",
    "orbits": "orbits --preset coulomb --max-period 4 --out orbits.csv",
    "basins": "basins --preset coulomb --out basins.csv",
    "bifurcations": "bifurcations --preset coulomb --parameter V --range 0.0366 0.0372"
    " --out report",
    "diagram": "diagram --preset coulomb --parameter V --range 0.0366 0.0372 --values 40"
    " --out fig.svg --csv points.csv",
    "simulate": "simulate --preset law9 -d 0.3812 --t-end 200 --out run.csv",
    "cycles": "cycles --preset coulomb --V 0.5 --n-starts 10 --seed 1 --out cycles.csv",
    "certify": "certify --preset coulomb --orbit 0.27739 --period 4 --out S4.json",
    "sweep": "sweep plan.toml --resume --threads 1",
    "explore": "explore --no-browser --port 0",
}
STORE = "sweep"


@dataclass
class Run:
    """How a command ended: its code, what it said, and how long after the signal."""

    code: int
    said: str
    after: float


def run(command: str, folder: Path, moment: float | None = None) -> Run:
    """Run a command, with an interrupt some seconds after its start."""
    process = subprocess.Popen(
        [sys.executable, "-m", "stickslip.cli", *command.split()],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        if moment is not None:
            process.wait(moment)
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)
    sent = time.monotonic()
    _, said = process.communicate(timeout=600)
    return Run(process.returncode, said, time.monotonic() - sent)


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a folder; dates in pictures and stores differ from run to run."""
    dates = re.compile(rb"\d{4}-\d\d-\d\dT[\d:.]+(\+00:00|Z)?")
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {
        path.relative_to(folder).as_posix(): dates.sub(b"", path.read_bytes())
        for path in files
        if not path.name.endswith(".lock")
    }


def main() -> int:
    """Interrupt commands, and count how they end."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, default=500)
    parser.add_argument("--seed", type=int)
    asked = parser.parse_args()
    rng = random.Random(asked.seed)
    with tempfile.TemporaryDirectory() as place:
        return _all(asked.n, rng, Path(place))


def _all(n: int, rng: random.Random, place: Path) -> int:
    counts: Counter[str] = Counter()
    slowest, failures, n_done = 0.0, [], 0
    whole, seconds = {}, {}
    for name, command in COMMANDS.items():
        if name != "explore":
            whole[name], seconds[name] = _left_alone(command, place / f"whole-{name}")
    print("seconds:", {name: round(s, 2) for name, s in seconds.items()}, flush=True)
    store = _prepared(place / "store")
    while n_done < n:
        name = list(COMMANDS)[n_done % len(COMMANDS)]
        folder = store if name == STORE else _prepared(place / f"run-{counts.total()}")
        moment = min(seconds.get(name, LATEST), LATEST) * rng.random() ** 2  # most at the start
        done = run(COMMANDS[name], folder, moment)
        sort, fault = _judged(name, done, folder, whole.get(name, {}))
        counts[sort] += 1
        if sort == "130":
            n_done += 1
            slowest = max(slowest, done.after)
        if fault:
            failures.append(f"{name} after {moment:.3f} s: {fault}: {done.said[-600:]!r}")
            print(failures[-1], flush=True)
            n_done += 1
        if name == STORE and sort == "ended before":
            store = _prepared(place / f"store-{counts.total()}")
    run(COMMANDS[STORE], store)
    if contents(store) != whole[STORE]:
        failures.append("the store that was interrupted differs")
    print(dict(counts), f"slowest {slowest:.2f} s,", f"{len(failures)} failures")
    return 1 if failures else 0


def _prepared(folder: Path) -> Path:
    folder.mkdir()
    (folder / "plan.toml").write_text(PLAN)
    return folder


def _left_alone(command: str, folder: Path) -> tuple[dict[str, bytes], float]:
    """Files of a whole run, and the seconds that it takes; kernels are compiled after that."""
    _prepared(folder)
    began = time.monotonic()
    assert run(command, folder).code == 0, command
    return contents(folder), time.monotonic() - began


def _judged(name: str, done: Run, folder: Path, whole: dict[str, bytes]) -> tuple[str, str]:
    """Of which sort an ending is, and what is wrong with it."""
    found = contents(folder)
    found.pop("plan.toml")
    if name != STORE and any(whole.get(path) != content for path, content in found.items()):
        return "fault", f"half-written {sorted(found)}"
    if [path for path in found if ".partial" in path]:
        return "fault", f"remains {sorted(found)}"
    if done.code == 0:
        return "ended before", "" if not done.said else "it went on"
    *_, last = ["", *done.said.splitlines()]
    if done.code != 130 or not last.startswith(CALM) or "Traceback" in done.said:
        # Killed before Python handles signals; or Python's own traceback, in none of our lines.
        by_signal = done.code == -signal.SIGINT and not done.said
        by_python = "KeyboardInterrupt" in done.said and "process.py" not in done.said
        if by_signal or (by_python and done.code in (1, -signal.SIGINT)):
            return "before the program's first line", "" if not found else "files"
        return "fault", f"code {done.code}"
    if done.after > LONGEST:
        return "fault", f"{done.after:.2f} s"
    return "130", ""


if __name__ == "__main__":
    sys.exit(main())
