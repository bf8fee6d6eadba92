"""Hold the product's values at many points against the oracle, and keep count."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from tests.reference.motion import EVENT_LIMIT, TIME_LIMIT
from tests.reference.settle import GAVE_UP, RIGHT, WRONG, Verdict, settle

import stickslip as ss
from stickslip.status import NAMES, OK

from .systems import Case

NOT_SETTLED = "not settled"


@dataclass
class Tally:
    """Counts of verdicts, and everything that is wrong."""

    verdicts: Counter[str] = field(default_factory=Counter)
    statuses: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)  # as text, which crosses processes
    worst: list[tuple[float, str]] = field(default_factory=list)

    def add(self, system: Case, engine: str, verdict: Verdict) -> None:
        """One more point."""
        self.verdicts[verdict.verdict] += 1
        if verdict.verdict == WRONG:
            self.wrong.append(f"  {system} engine={engine}\n    {verdict}")
        elif verdict.verdict == RIGHT and np.isfinite(verdict.error):
            self.worst.append((verdict.error / verdict.kappa, f"{system} {engine} {verdict}"))
            if len(self.worst) > 400:
                self.worst = sorted(self.worst, reverse=True)[:20]

    def merge(self, other: Tally) -> None:
        """Both counts together."""
        self.verdicts += other.verdicts
        self.statuses += other.statuses
        self.wrong += other.wrong
        self.worst = sorted(self.worst + other.worst, reverse=True)[:20]

    def __str__(self) -> str:
        """Counts, then the wrong ones, then the largest errors that were right."""
        lines = [f"verdicts {dict(self.verdicts)}", f"statuses {dict(self.statuses)}"]
        lines += self.wrong[:30]
        lines += ["largest right errors:"] if self.worst else []
        lines += [f"  {e:.2e} {text}" for e, text in sorted(self.worst, reverse=True)[:5]]
        return "\n".join(lines)


@dataclass(frozen=True)
class Effort:
    """How much of the oracle's time a motion without return may take.

    ``share`` of the motions that the product calls endless are settled; where the product gave
    up nothing can be wrong and nothing is settled. ``max_events`` limits the reference.
    """

    share: float = 1.0
    max_events: int = 10_000
    max_time: float = 20_000
    product_too: bool = False


def judge(
    tally: Tally,
    system: Case,
    d: Iterable[float],
    engine: str,
    rng: np.random.Generator,
    effort: Effort | None = None,
) -> None:
    """Evaluate the product at all ``d``, settle each in the oracle, add to the tally."""
    effort = effort or Effort()
    points = np.asarray(d, dtype=float)
    if points.size == 0:
        return
    limits = {"max_events": effort.max_events, "max_time": effort.max_time}
    result = ss.event_map(
        system.model(), engine=engine, **(limits if effort.product_too else {})
    ).evaluate(points)
    oracle = system.oracle()
    columns = (points, result.value, result.status, result.duration)
    for start, value, code, duration in zip(*(c.tolist() for c in columns), strict=True):
        status = NAMES[code]
        tally.statuses[status] += 1
        assert (code == OK) == np.isfinite(value), f"{system} d={start!r}: {value} with {status}"
        if status in (EVENT_LIMIT, TIME_LIMIT):
            tally.verdicts[GAVE_UP] += 1
        elif code != OK and rng.uniform() > effort.share:
            tally.verdicts[NOT_SETTLED] += 1
        else:
            verdict = settle(
                oracle,
                start,
                value,
                status,
                system.tolerance,
                duration,
                **limits,
            )
            tally.add(system, engine, verdict)
