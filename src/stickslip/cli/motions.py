"""Commands about motions in time: ``stickslip simulate`` and ``cycles``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from stickslip.cli.options import Flag, TableOptions, Whole, check_equally_spaced
from stickslip.cli.output import note
from stickslip.cli.process import COMPUTATION_FAILED, DONE, UsageError

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.limit_cycles import CycleList
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.results.table import Table

SIMULATE_EXAMPLES = """\
stickslip simulate --preset law9 -d 0.3812 --t-end 200 --out run.csv
stickslip simulate --preset coulomb -d 0.1 --t-end 50 --events
stickslip simulate --preset coulomb --x 0.5 --x 0.6 --v 0 --v 0.0366 \\
    --t-end 100 --json
"""


def simulate(
    *,
    table: TableOptions = TableOptions(),
    d: Annotated[
        tuple[float, ...], Parameter(name=["--d", "-d"], negative=(), show_default=False)
    ] = (),
    x: Annotated[tuple[float, ...], Parameter(negative=(), show_default=False)] = (),
    v: Annotated[tuple[float, ...], Parameter(name="--v", negative=(), show_default=False)] = (),
    t_end: float,
    samples: Whole = 2001,
    events: Flag = False,
    energy: Flag = False,
) -> int:
    """Follow the blocks in time, from a global stick phase or from any state.

    Columns: time t; displacement x, velocity v, mode (0 stick, -1 backward, 1 forward slip)
    and friction force of each block. Each time is evaluated exactly, not interpolated. The
    exit code is 1 if the motion could not be followed to its end.

    Parameters
    ----------
    d
        Start at the end of the global stick phase with this X_2 - X_1; of more than two
        blocks, once for each neighbouring pair.
    x
        Start from these displacements instead; once for each block.
    v
        Velocities that belong to --x; once for each block.
    t_end
        Time to stop at, in units of sqrt(m / k).
    samples
        Number of equally spaced times, both ends included.
    events
        List the changes of mode (time, block, kind) instead of samples.
    energy
        Add kinetic and elastic energy, work of the belt and dissipation since the start.
    """
    import numpy as np

    import stickslip as ss
    from stickslip import status

    check_equally_spaced("--samples", samples)
    if bool(d) == bool(x or v):
        raise UsageError("give a start: either -d 0.1, or --x and --v once for each block")
    model = table.model()
    start: dict[str, Any] = {"x": x, "v": v}
    if d:
        start = {"d": d[0] if len(d) == 1 and model.n_blocks == 2 else d}
    answer: list[Trajectory] = []

    def compute() -> Table:
        motion = ss.simulate(model, **start, t_end=t_end, **table.engine.settings())
        answer.append(motion)
        if events:
            return motion.table()
        return motion.table(np.linspace(motion.t[0], motion.t[-1], samples), energy=energy)

    asked = start | {"t_end": t_end}
    table.deliver("simulate", model, asked, compute, lambda ax: answer[0].plot(ax))
    (motion,) = answer
    if motion.status == status.OK:
        return DONE
    note(f"ended before t_end: {motion.message}", quiet=table.quiet)
    return COMPUTATION_FAILED


CYCLES_EXAMPLES = """\
stickslip cycles --preset law9
stickslip cycles --preset coulomb --V 0.5 --n-starts 100 --seed 1 --json
stickslip cycles --model mine.toml --out cycles.csv
"""


def cycles(
    *,
    table: TableOptions = TableOptions(),
    n_starts: Whole = 50,
    max_period: Whole = 1,
    seed: Whole = 0,
) -> int:
    """List limit cycles in continuous time, with global stick phases or without.

    One row for each cycle, sorted by the number of starts that led to it. Columns: cycle,
    period, size of the largest multiplier, stable, events in one period, global_sticks, hits
    (0: known from the event map alone). What else the starts led to, and the estimated share
    of starts to cycles that were not found, is said on stderr.

    Parameters
    ----------
    n_starts
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
        found = ss.limit_cycles(
            model, n_starts=n_starts, max_period=max_period, rng=seed, **settings
        )
        answer.append(found)
        return found.table()

    asked = {"n_starts": n_starts, "max_period": max_period, "seed": seed}
    table.deliver("cycles", model, asked, compute, lambda ax: answer[0].plot(ax))
    (found,) = answer
    told = f"{found.n_sliding} starts slide for ever, {found.n_undecided} undecided; "
    told += f"estimated share of starts to cycles not found: {found.unseen:.2g}"
    note(told, quiet=table.quiet)
    return DONE
