"""Tests that take long: `tests/long.txt`, which `make test` leaves out and `make test-all` runs.

Made anew from what `pytest --durations=0 --durations-min=0.05 -vv` prints:

    python -m tests.house.long < durations.txt
"""

import re
import sys
from collections.abc import Iterable
from pathlib import Path

LIST = Path(__file__).parents[1] / "long.txt"
LONG = 0.5  # seconds of one call, on one of two cores at work
# What a stranger meets first, end to end, is run before every change is taken in.
FRONT_DOOR = ("tests/house/test_readme.py", "tests/app/browser/test_guidance.py")
HEAD = "# Tests of which a call takes half a second and more: python -m tests.house.long\n"


def named() -> frozenset[str]:
    """Return the tests of the list, all their parameters together."""
    return frozenset(LIST.read_text().splitlines()[1:])


def bare(nodeid: str) -> str:
    """Return the name of a test without its parameters."""
    return nodeid.split("[")[0]


def long_tests(report: Iterable[str]) -> set[str]:
    """Read the tests off a report of durations."""
    found = (re.match(r"\s*([\d.]+)s call\s+(\S.*)$", line) for line in report)
    names = {bare(line[2].strip()) for line in found if line and float(line[1]) >= LONG}
    return {name for name in names if not name.startswith(FRONT_DOOR)}


if __name__ == "__main__":
    LIST.write_text(HEAD + "".join(f"{name}\n" for name in sorted(long_tests(sys.stdin))))
