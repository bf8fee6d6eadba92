"""Commands about one model: maps, orbits, basins, safety, motions and cycles."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from stickslip.cli.options import (
    ENGINE,
    Flag,
    Numbers,
    Starts,
    TableOptions,
    Whole,
    check_equally_spaced,
)
from stickslip.cli.output import note, notes, tracked
from stickslip.cli.process import COMPUTATION_FAILED, DONE, UsageError
from stickslip.files import real_columns

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

    from stickslip.analysis.attractors.basins import Basins
    from stickslip.analysis.orbits.orbit import OrbitList
    from stickslip.analysis.orbits.orbits_nd import OrbitListND
    from stickslip.cli.options import ModelLine
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.numerics.arrays import Floats
    from stickslip.results.table import Table


MAP_EXAMPLES = """\
stickslip map --preset coulomb -d -0.2 -d 0.1 --itinerary
stickslip map --alpha 1.2 --beta 1.3 --V 0.0366 \\
    --friction coulomb:mu=0.22 -d -0.2 -d 0.1 --json
stickslip map --preset law9 --alpha 1.209 --grid 2000 \\
    --window 0.379 0.39 --out map.csv
"""

PIECE = 20_000  # points between two words of progress


def map_(
    *,
    table: TableOptions = TableOptions(),
    d: Starts = (),
    grid: Whole | None = None,
    window: Annotated[tuple[float, float] | None, Parameter(negative=())] = None,
    itinerary: Flag = False,
    max_time: Annotated[float | None, Parameter(group=ENGINE)] = None,
    threads: Annotated[Whole | None, Parameter(group=ENGINE)] = None,
) -> int:
    """Tell at which distance d = X_2 - X_1 both blocks next stick together.

    Prints a table on a terminal, CSV into a pipe. A motion that never returns to global
    stick has value nan and a status that says why; the exit code is 1 if no point at all
    has an answer.

    Parameters
    ----------
    d
        A point to map; may be given several times.
    grid
        Map so many equally spaced points instead, both ends included.
    window
        The two ends of the grid, of which the part inside the domain counts; the whole domain if
        not given.
    itinerary
        Add the modes of the blocks (. stick, - backward, + forward) from event to event.
    max_time
        Give up on a motion after this time, in units of sqrt(m / k).
    threads
        Threads for large arrays; all cores if not given.
    """
    asked = {} if max_time is None else {"max_time": max_time}
    f = table.event_map(threads=threads, **asked)
    points = _points_to_map(f, d, grid, window)

    result = table.deliver(
        "map",
        f.model,
        asked,
        lambda: _evaluated(f, points, itinerary=itinerary),
        table=dict,
        plot=lambda _, ax: _plot_map(f, points, window, ax, marked=bool(d)),
    )
    return _map_ending(result, quiet=table.quiet)


def _points_to_map(
    f: ModelLine, d: tuple[float, ...], grid: int | None, window: tuple[float, float] | None
) -> Floats:
    import numpy as np

    from stickslip.analysis.maps.derived import windowed

    if bool(d) == (grid is not None):
        raise UsageError("give either points, -d 0.1 -d 0.2, or a grid, --grid 2000")
    if grid is None:
        if window is not None:
            raise UsageError("--window belongs to --grid")
        return np.array(d)
    check_equally_spaced("--grid", grid)
    first, last = windowed(f, window).domain
    return np.linspace(first, last, grid)


def _evaluated(f: ModelLine, points: Floats, *, itinerary: bool) -> dict[str, Any]:
    import numpy as np

    pieces = np.array_split(points, max(1, -(-points.size // PIECE)))
    results = [f.evaluate(piece) for piece in tracked(pieces, "mapping")]
    tables = [result.table() for result in results]
    table: dict[str, Any] = {
        name: np.concatenate([part[name] for part in tables]) for name in tables[0]
    }
    if itinerary:
        table["itinerary"] = [f.itinerary(point) for point in points]
    return table


def _plot_map(
    f: ModelLine,
    points: Floats,
    window: tuple[float, float] | None,
    ax: Axes,
    *,
    marked: bool,
) -> Axes:
    """Draw the map over the window; points that were asked for one by one are marked."""
    from stickslip.plot.maps import event_map

    event_map(f, ax, window=window)
    if marked:
        ax.plot(points, f(points), "o", ms=4)
    return ax


def _map_ending(table: Mapping[str, Any], *, quiet: bool) -> int:
    """Tell how many points have no value and why; fail if none has an answer."""
    import numpy as np

    from stickslip import status

    codes, counts = np.unique(table["status"], return_counts=True)
    for code, count in zip(codes, counts, strict=True):
        if code != status.OK:
            note(f"{count} of {counts.sum()}: {status.MESSAGES[code]}", quiet=quiet)
    answers = {status.OK, status.NEVER_SLIPPING, status.NEVER_CYCLE}
    return DONE if answers & set(codes.tolist()) else COMPUTATION_FAILED


ORBITS_EXAMPLES = """\
stickslip orbits --preset coulomb --max-period 4
stickslip orbits --preset coulomb --period 4 --infinitely-unstable --json
stickslip orbits --preset law9 --alpha 1.211 --max-period 6 --out orbits.csv
"""


def orbits(
    *,
    table: TableOptions = TableOptions(),
    max_period: Whole | None = None,
    period: Whole | None = None,
    infinitely_unstable: Flag = False,
    resolution: float | None = None,
) -> int:
    """List the periodic orbits of the event map, stable and unstable, each once.

    One row for each point of each orbit, the orbits numbered by period and place. Columns:
    orbit, period, kind, multiplier (inf if the orbit crosses a jump), point and d with its
    error, itinerary from this point to the next. What could not be decided is said on
    stderr; the exit code is 1 if the list is not complete up to the period asked for, or empty
    with places undecided.

    A map of several numbers, as of three blocks, has multipliers_1, ... and d_1, ... instead, and
    how many starts led to the orbit (hits); stderr estimates how many orbits were not found.

    Parameters
    ----------
    max_period
        List minimal periods 1 to this; 1 if not given.
    period
        List this minimal period alone.
    infinitely_unstable
        Add the orbits that cross a jump of the map.
    resolution
        On a line: pieces of the map narrower than this may be missed; 1e-9 if not given.
    """
    import stickslip as ss

    if period is not None and max_period is not None:
        raise UsageError("give either --max-period or --period")
    highest = 1 if max_period is None else max_period
    f = table.map()
    on_line = f.dimension == 1
    if on_line and resolution is None:
        resolution = 1e-9
    settings: dict[str, Any] = {
        "infinitely_unstable": infinitely_unstable,
        "resolution": resolution,
    }

    def plot(found: OrbitList | OrbitListND, ax: Axes) -> Axes:
        from stickslip.plot.maps import event_map

        return found.plot(event_map(f, ax) if on_line else ax)

    found = table.deliver(
        "orbits",
        f.model,
        ({"max_period": highest} if period is None else {"period": period}) | settings,
        lambda: ss.periodic_orbits(f, highest, period=period, **settings),
        table=lambda found: _columns_of_numbers(found.table()),
        plot=plot,
    )
    return _orbit_ending(found, quiet=table.quiet)


def _columns_of_numbers(table: Mapping[str, Any]) -> dict[str, Any]:
    """Give each component of a column of tuples its own, `d_1`, and imaginary parts theirs."""
    columns: dict[str, Any] = {}
    for name, values in table.items():
        if not (len(values) and isinstance(values[0], tuple)):
            columns[name] = values
            continue
        for k, part in enumerate(zip(*values, strict=True), start=1):
            columns[f"{name}_{k}"] = part
    return real_columns(columns)


def _orbit_ending(found: OrbitList | OrbitListND, *, quiet: bool) -> int:
    """Tell what stayed open; fail if orbits of a period asked for may be missing."""
    from stickslip.analysis.orbits.orbits_nd import OrbitListND

    if isinstance(found, OrbitListND):
        notes([str(item) for item in found.unseen], "periods searched", quiet=quiet)
        return DONE
    near = [near for near in found.near_folds if not near.resolved]
    reasons = [
        f"none, two or a whole interval of orbits of period {item.period} at d = {item.x:.12g}: "
        f"the map comes within {item.distance:.2g} of the diagonal"
        for item in near
    ]
    reasons += [str(item) for item in found.unresolved]
    notes(reasons, "undecided places", quiet=quiet)
    nothing = not len(found) and found.unresolved
    return COMPUTATION_FAILED if nothing or found.complete < found.max_period else DONE


BASINS_EXAMPLES = """\
stickslip basins --preset coulomb
stickslip basins --preset coulomb --V 0.037 --json
stickslip basins --preset law9 --alpha 1.208 --out basins.csv
"""


def basins(
    *,
    table: TableOptions = TableOptions(),
    resolution: float | None = None,
    samples: Whole | None = None,
) -> int:
    """Divide the domain of the event map into basins of attraction.

    One row for each interval, from left to right. Columns: its ends; its share of the
    domain; number, kind, period, smallest point and Lyapunov exponent of the attractor that
    its points end on; why it ends where it does. An interval whose motions reach a gap of
    the map "leaves"; for the intervals "not proved" samples tell shares; what is undecided even
    so is explained on stderr, and the exit code is 1 if that is the whole domain.

    Of a map of several numbers, as of three blocks: one row for each attractor, and for the
    starts that leave or stay undecided, with its share of the starts and the standard error.

    Parameters
    ----------
    resolution
        On a line: share of the domain below which interwoven basins are left to samples; 1e-5
        if not given.
    samples
        Of a map of several numbers: starts, spread over the domain; 1024 if not given.
    """
    import stickslip as ss

    f = table.map()
    on_line = f.dimension == 1
    if on_line and samples is not None:
        raise UsageError("--samples belongs to maps of several numbers; on a line: --resolution")
    if not on_line and resolution is not None:
        raise UsageError("--resolution belongs to maps of one number; of several: --samples")
    resolution = 1e-5 if resolution is None else resolution
    samples = 1024 if samples is None else samples
    asked: dict[str, Any] = {"resolution": resolution} if on_line else {"samples": samples}
    settings = asked if on_line else {"n_samples": samples}
    found = table.deliver("basins", f.model, asked, lambda: ss.basins(f, **settings))
    if on_line:
        return _basin_ending(found, quiet=table.quiet)
    note(repr(found).splitlines()[0], quiet=table.quiet)
    return COMPUTATION_FAILED if found.undecided == 1.0 else DONE


def _basin_ending(found: Basins, *, quiet: bool) -> int:
    """Tell what is undecided or was left out; fail if nothing could be decided."""
    if found.counts.any():
        note(repr(found).splitlines()[0], quiet=quiet)
    if found.undecided > 0.0:
        note(f"{found.undecided:.3g} of the domain undecided: {found.reason}", quiet=quiet)
    if found.thin:
        note(
            f"{found.thin} intervals below 1e-10 of the domain are not listed: "
            "basins accumulate at an edge",
            quiet=quiet,
        )
    return COMPUTATION_FAILED if found.undecided == 1.0 else DONE


SAFETY_EXAMPLES = """\
stickslip safety --preset coulomb
stickslip safety --preset coulomb --kicks 0.01 --within 10000 --json
stickslip safety --preset coulomb --parameter V \\
    --values 0.0366 --values 0.0368
"""


def safety(
    *,
    table: TableOptions = TableOptions(),
    attractor: Whole = 0,
    kicks: float = 0.0,
    within: Whole = 1000,
    parameter: str | None = None,
    values: Annotated[tuple[float, ...], Parameter(negative=(), show_default=False)] = (),
) -> int:
    """Tell how safe an attractor of the event map is: what carries a motion into another basin.

    Columns: its basin's share of the domain; the smallest displacement and the smallest change
    of a block's velocity that lead elsewhere, and into which basin (-1: not proved, -2: out of
    the domain); steps until half and 95 % of the starts have settled; mean steps until random
    kicks make a motion escape, and the share that does. Errors are standard errors. Where the
    attractor is lost along a parameter is said on stderr.

    Parameters
    ----------
    attractor
        Number of the attractor, from 0, that most starts reach first.
    kicks
        Standard deviation of normal kicks after each step; none at 0.
    within
        Steps after which a kicked run is given up.
    parameter
        A number of the model that varies.
    values
        Its values, along which the attractor is followed.
    """
    import stickslip as ss

    if (parameter is None) != (not values):
        raise UsageError("--parameter and --values belong together: give both, or neither")
    f = table.event_map()
    asked: dict[str, Any] = {"attractor": attractor, "kicks": kicks, "within": within}
    if parameter is not None:
        asked |= {"parameter": parameter, "values": list(values)}
    found = table.deliver("safety", f.model, asked, partial(ss.safety, f, **asked))
    if lost := getattr(found, "lost", ""):
        note(f"ends early: {lost}", quiet=table.quiet)
    return DONE


SIMULATE_EXAMPLES = """\
stickslip simulate --preset law9 -d 0.3812 --t-end 200 --out run.csv
stickslip simulate --preset coulomb -d 0.1 --t-end 50 --events
stickslip simulate --preset coulomb --x 0.5 --x 0.6 --v 0 --v 0.0366 \\
    --t-end 100 --json
"""


def simulate(
    *,
    table: TableOptions = TableOptions(),
    d: Starts = (),
    x: Numbers = (),
    v: Annotated[Numbers, Parameter(name="--v")] = (),
    t_end: float,
    samples: Whole | None = None,
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
        blocks, one number for each neighbouring pair.
    x
        Start from these displacements instead; one for each block.
    v
        Velocities that belong to --x; one for each block.
    t_end
        Time to stop at, in units of sqrt(m / k).
    samples
        Number of equally spaced times, both ends included; 2001 if not given.
    events
        List the changes of mode (time, block, kind) instead of samples.
    energy
        Add kinetic and elastic energy, work of the belt and dissipation since the start.
    """
    import numpy as np

    import stickslip as ss
    from stickslip import status

    if events and (energy or samples is not None):
        raise UsageError("--events lists changes of mode; --samples and --energy belong to samples")
    samples = 2001 if samples is None else samples
    check_equally_spaced("--samples", samples)
    if bool(d) == bool(x or v):
        raise UsageError("give a start: either -d 0.1, or --x and --v, a number for each block")
    model = table.model()
    start: dict[str, Any] = {"x": x, "v": v}
    if d:
        start = {"d": d[0] if len(d) == 1 and model.n_blocks == 2 else d}

    def sampled(motion: Trajectory) -> Table:
        if events:
            return motion.table()
        return motion.table(np.linspace(motion.t[0], motion.t[-1], samples), energy=energy)

    motion = table.deliver(
        "simulate",
        model,
        start | {"t_end": t_end},
        lambda: ss.simulate(model, **start, t_end=t_end, **table.engine.settings()),
        table=sampled,
    )
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
    period, multiplier of largest size (real part, and multiplier_imag), stable, events in one
    period, global_sticks, hits (starts that led to it; 0: known from the event map alone). What
    else the starts led to, and the estimated share of starts to cycles that were not found, is
    said on stderr.

    Parameters
    ----------
    n_starts
        States that motions start from.
    max_period
        Orbits of the event map up to this period are looked up as well.
    seed
        The random starts are drawn from this number: the same number, the same starts.
    """
    import stickslip as ss

    if seed < 0:
        raise UsageError(f"--seed {seed}: a whole number, 0 or more, is needed")
    settings = table.engine.settings()
    if settings.pop("engine") != "auto":
        raise UsageError("--engine: cycles are followed by one engine; leave the option out")
    model = table.model()
    asked: dict[str, Any] = {"n_starts": n_starts, "max_period": max_period}
    found = table.deliver(
        "cycles",
        model,
        asked | {"seed": seed},
        lambda: ss.limit_cycles(model, **asked, rng=seed, **settings),
    )
    told = f"{found.n_sliding} starts slide for ever, {found.n_undecided} undecided; "
    told += f"estimated share of starts to cycles not found: {found.unseen:.2g}"
    note(told, quiet=table.quiet)
    return DONE
