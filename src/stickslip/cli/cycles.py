"""``stickslip cycles``: the limit cycles that a search from many states finds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.cli.failure import DONE, UsageError
from stickslip.cli.options import Whole
from stickslip.cli.progress import note
from stickslip.cli.table import TableOptions

if TYPE_CHECKING:
    from stickslip.results.table import Table
    from stickslip.study.limit_cycles import CycleList

EXAMPLES = """\
stickslip cycles --preset law9
stickslip cycles --preset coulomb --V 0.5 --starts 100 --seed 1 --json
stickslip cycles --model mine.toml --out cycles.csv
"""


def command(
    *,
    table: TableOptions = TableOptions(),
    starts: Whole = 50,
    max_period: Whole = 1,
    seed: Whole = 0,
) -> int:
    """List limit cycles in continuous time, with global stick phases or without.

    One row for each cycle, those that most starts led to first. Columns: cycle, period, size of
    the largest multiplier, stable, events in one period, global_sticks, hits (0: known from
    the event map alone). What else the starts led to, and the estimated share of starts to
    cycles that were not found, is said on stderr.

    Parameters
    ----------
    starts
        States that motions start from.
    max_period
        Orbits of the event map up to this period are looked up as well.
    seed
        Of the random states.
    """
    import stickslip as ss

    settings = table.engine.settings()
    if settings.pop("engine") != "auto":
        raise UsageError("--engine: cycles are followed by one engine; leave the option out")
    model = table.model()
    answer: list[CycleList] = []

    def compute() -> Table:
        found = ss.limit_cycles(model, n_starts=starts, max_period=max_period, rng=seed, **settings)
        answer.append(found)
        return found.table()

    asked = {"starts": starts, "max_period": max_period, "seed": seed}
    table.deliver("cycles", model, asked, compute, lambda ax: answer[0].plot(ax))
    (found,) = answer
    told = f"{found.n_sliding} starts slide for ever, {found.n_undecided} undecided; "
    told += f"estimated share of starts to cycles not found: {found.unseen:.2g}"
    note(told, quiet=table.quiet)
    return DONE
