"""Lists of bifurcations, and basins, of systems that nobody tuned for, against brute force.

    python -m tests.acceptance.lists coulomb --n 50 [--first 0] [--seconds 300]
    python -m tests.acceptance.lists law9 | stribeck | gap | tent | parabola | basins

`coulomb`, `law9`, `stribeck` and `parabola` look for attractors between the listed values that the
list has not; `gap` and `tent` compare with borders known otherwise; `basins` asks that shares add
up. A line per system, processor seconds first. Exit code 1 if anything is silent, wrong or an
exception, or a fault of the program that a list has noted.
"""

from __future__ import annotations

import argparse
import sys
import time
import traceback
from collections.abc import Callable

import numpy as np
from tests.analysis.bifurcations.scan.test_survey import MU, random_family
from tests.analysis.bifurcations.test_accounting_by_force import (
    PERIOD,
    random_blocks,
    random_stribeck,
    unaccounted_in_blocks,
    unaccounted_in_parabolas,
)
from tests.analysis.bifurcations.test_completeness import (
    assert_gap_map_complete,
    assert_skew_tent_complete,
)

import stickslip as ss

SAME_SHARE = 1e-9  # of shares that add up to 1
OPEN = 1e-3  # undecided share that is told
VALUES = 40  # of the parameter, at which attractors are found by brute force
SLOPES = (0.2, 0.8)  # of maps with a gap, and the corners of tents

Verdict = tuple[float, list[str], list[str]]  # seconds, what is wrong, and what is left open


def _listed(judge: Callable[..., list[object]], system: object, name: str, ends: object) -> Verdict:
    start = time.process_time()
    found = ss.bifurcations(system, name, ends, max_period=PERIOD)
    seconds = time.process_time() - start
    silent = [f"silent: {item}" for item in judge(found, system, VALUES)]
    told = [f"{u.reason} [{u.lo!r}, {u.hi!r}]" for u in found.unresolved]
    faults = [text for text in told if "a fault of the program" in text]
    return seconds, silent + faults, told


def _parabolas(seed: int) -> Verdict:
    f = random_family(np.random.default_rng(seed))
    return _listed(unaccounted_in_parabolas, f, "mu", MU)


def _basins(seed: int) -> Verdict:
    model, _, _ = random_blocks(seed)
    start = time.process_time()
    found = ss.basins(model)
    seconds = time.process_time() - start
    shares = [found.share(k) for k in range(len(found.attractors))]
    total = sum(shares) + found.left + found.undecided
    wrong = [] if abs(total - 1) < SAME_SHARE else [f"shares add up to {total}"]
    return seconds, wrong, [f"undecided {found.undecided:.3g}"] if found.undecided > OPEN else []


def _exact(check: Callable[..., None], seed: int, n: int) -> Verdict:
    start = time.process_time()
    check(*np.random.default_rng(seed).uniform(*SLOPES, n))
    return time.process_time() - start, [], []


KINDS: dict[str, Callable[[int], Verdict]] = {
    "coulomb": lambda k: _listed(unaccounted_in_blocks, *random_blocks(2 * k)),
    "law9": lambda k: _listed(unaccounted_in_blocks, *random_blocks(2 * k + 1)),
    "stribeck": lambda k: _listed(unaccounted_in_blocks, *random_stribeck(k)),
    "parabola": _parabolas,
    "gap": lambda k: _exact(assert_gap_map_complete, k, 2),
    "tent": lambda k: _exact(assert_skew_tent_complete, k, 1),
    "basins": _basins,
}


def main() -> int:
    """Judge one system after another."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--n", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=np.inf, help="begin none later")
    asked = parser.parse_args()
    end, bad, told, spent = time.time() + asked.seconds, 0, 0, []
    for k in range(asked.first, asked.first + asked.n):
        if time.time() > end:
            break
        try:
            seconds, wrong, open_ = KINDS[asked.kind](k)
        except Exception:  # an exception is a finding like others
            seconds, wrong, open_ = np.nan, [traceback.format_exc()], []
        spent.append(seconds)
        bad, told = bad + bool(wrong), told + bool(open_)
        print(f"{k:4d} {seconds:7.1f} s", *wrong, *open_, sep="\n      ", flush=True)
    middle, most = np.nanmedian(spent), np.nanmax(spent)
    print(f"{len(spent)} {asked.kind}: {bad} wrong, {told} with something open;", end=" ")
    print(f"processor time {middle:.1f} s at the median, {most:.1f} s at most")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
