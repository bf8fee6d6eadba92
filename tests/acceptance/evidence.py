"""Large samples: how many answers are wrong, and the worst of them.

    python -m tests.acceptance.evidence coulomb --n 100000 [--engine exact adaptive]
    python -m tests.acceptance.evidence law9 --n 300
    python -m tests.acceptance.evidence grazing --kind law9 --n 20
    python -m tests.acceptance.evidence steppers --n 10000

`coulomb` and `law9` take random systems, one start each; `grazing` the breakpoints of the paper's
system and of random ones; `steppers` compares law (9) between the Taylor and the collocation
stepper, and settles disagreements and a random share in the oracle. Counts go to
`docs/evidence.csv`, a piece at a time. Exit code 1 if any is wrong.
"""

from __future__ import annotations

import argparse
import secrets
import sys
from pathlib import Path

import numpy as np
from tests.reference.settle import EXCUSED, GAVE_UP, WRONG, settle

import stickslip as ss
from stickslip.status import NAMES

from .judge import NOT_SETTLED, Effort, Tally, judge
from .pieces import add_options, carried_out
from .results import record
from .systems import ENGINES, around, breakpoints, paper_case, random_cases, random_points

CHUNK = 250  # systems per task
AGREE = "agree"
LAWS = {"coulomb": "Coulomb", "law9": "law (9)"}


def random_sample(task: tuple[str, int, int, tuple[str, ...], Effort]) -> Tally:
    """``n`` random systems, one start each."""
    kind, n, seed, engines, effort = task
    rng = np.random.default_rng(seed)
    tally = Tally()
    for system in random_cases(kind, n, rng):
        d = random_points(system, 1, rng)
        for engine in engines:
            judge(tally, system, d, engine, rng, effort)
    return tally


def grazing_sample(task: tuple[str, int, int, int, tuple[str, ...], Effort]) -> Tally:
    """Around all breakpoints of the paper's system (``n`` = 0), or ``most`` of a random one."""
    kind, n, most, seed, engines, effort = task
    rng = np.random.default_rng([seed, n])
    system = paper_case(kind) if n == 0 else next(random_cases(kind, 1, rng))
    found = breakpoints(system)
    if n and len(found) > most:
        found = rng.choice(found, most, replace=False).tolist()
    tally = Tally()
    for d in found:
        for engine in engines:
            judge(tally, system, around(d, system), engine, rng, effort)
    return tally


def stepper_sample(task: tuple[str, int, int, tuple[str, ...], Effort]) -> Tally:
    """Law (9) by its series and as a callable: disagreements and 3 % of the rest are settled."""
    _, n, seed, _, effort = task
    rng = np.random.default_rng(seed)
    tally = Tally()
    for system in random_cases("law9", n, rng):
        (d,) = random_points(system, 1, rng).tolist()
        series, callable_ = ss.event_map(system.model()), ss.event_map(opaque(system))
        a, b = series.evaluate(d), callable_.evaluate(d)
        tally.statuses[NAMES[int(a.status)]] += 1
        agree = a.status == b.status and not abs(a.value - b.value) > system.tolerance
        if agree and rng.uniform() > 0.03:
            tally.verdicts[AGREE] += 1
            continue
        for name, result in (("series", a), ("callable", b)):
            verdict = settle(
                system.oracle(),
                d,
                float(result.value),
                NAMES[int(result.status)],
                system.tolerance,
                max_events=effort.max_events,
            )
            tally.add(system, name, verdict)
    return tally


def opaque(system) -> ss.TwoBlock:
    """Law (9) as a function that cannot be traced, so that the other stepper runs."""
    law = ss.friction_law(_law9, parameters=dict.fromkeys(("gamma", "delta", "eta"), 0.0))
    friction = law.replace(**dict(system.law))
    return ss.TwoBlock(alpha=system.alpha, beta=system.beta, V=system.V, friction=friction)


def _law9(s, gamma, delta, eta):
    # A comparison of the argument is what tracing cannot follow.
    weakening = (1 - delta) / (1 + gamma * s) if s >= 0 else 1 - delta
    return weakening + delta + eta * s * s


def sample_name(what: str, kind: str, engines: tuple[str, ...]) -> str:
    """A sample in the table of results."""
    if what == "steppers":
        return "law (9), Taylor series against collocation"
    engine = f" ({' and '.join(engines)} engine)"
    if what == "grazing":
        return f"{LAWS[kind]}, next to breakpoints{engine}"
    return f"{LAWS[kind]}, one start of each random system{engine}"


def keep(name: str, tally: Tally, seconds: float, table: Path) -> None:
    """Add a piece to the table of results."""
    answers = tally.verdicts.total()
    left = sum(tally.verdicts[word] for word in (NOT_SETTLED, GAVE_UP, AGREE))
    record(
        name,
        answers=answers,
        settled=answers - left,
        wrong=tally.verdicts[WRONG],
        excused=tally.verdicts[EXCUSED],
        undecided=tally.verdicts[GAVE_UP],
        seconds=seconds,
        table=table,
    )


def main(arguments: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("coulomb", "law9", "grazing", "steppers"))
    parser.add_argument("--kind", choices=("coulomb", "law9"), default="coulomb")
    parser.add_argument("--n", type=int, default=1000, help="random systems")
    parser.add_argument("--seed", type=int, default=secrets.randbits(31), help="default: any")
    parser.add_argument("--engine", nargs="+", help="default: every engine of the law")
    parser.add_argument("--share", type=float, default=1.0, help="of endless motions settled")
    parser.add_argument("--max-events", type=int, default=10_000, help="of the reference")
    parser.add_argument("--breakpoints", type=int, default=12, help="of a random system, at most")
    add_options(parser)
    options = parser.parse_args(arguments)

    kind = options.what if options.what in ("coulomb", "law9") else options.kind
    engines = tuple(options.engine or ENGINES[kind])
    effort = Effort(options.share, options.max_events)
    if options.what == "grazing":
        work = grazing_sample
        tasks = [
            (kind, n, options.breakpoints, options.seed, engines, effort)
            for n in range(options.n + 1)
        ]
    else:
        work = stepper_sample if options.what == "steppers" else random_sample
        sizes = [min(CHUNK, options.n - first) for first in range(0, options.n, CHUNK)]
        tasks = [
            (kind, size, options.seed * 1_000_003 + i, engines, effort)
            for i, size in enumerate(sizes)
        ]
    name = sample_name(options.what, kind, engines)
    print(f"{name}, seed {options.seed}", flush=True)
    total, elapsed = Tally(), 0.0
    for tally, took in carried_out(work, tasks, options.jobs, options.seconds):
        total.merge(tally)
        elapsed += took
        keep(name, tally, took, options.table)
        print(f"{elapsed:.0f} s: {total}", flush=True)
    return 1 if total.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
