"""Commands about a grid of parameters: ``stickslip sweep`` and ``plot``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from stickslip.cli.options import OUTPUT, Flag, OutputOptions, Whole, pairs
from stickslip.cli.output import PICTURE_SUFFIXES, draw_pictures, new_files, note, of_file, told_as
from stickslip.cli.process import ComputationError, RefusalError, UsageError, advise
from stickslip.files import checked_suffix

if TYPE_CHECKING:
    import xarray

    from stickslip.sweeps.plan import Plan

SWEEP_EXAMPLES = """\
stickslip sweep plan.toml
stickslip sweep plan.toml --status
stickslip sweep plan.toml --resume --threads 8
stickslip sweep plan.toml --store s3://bucket/map \\
    --scheduler tcp://10.0.0.1:8786
"""


def sweep(
    plan: Path,
    *,
    store: Annotated[str | None, Parameter(group=OUTPUT)] = None,
    resume: Flag = False,
    status: Flag = False,
    threads: Whole | None = None,
    scheduler: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    device: Literal["cpu", "cuda"] = "cpu",
    output: OutputOptions = OutputOptions(),
) -> None:
    """Compute what a plan describes into its store, and print the store's name.

    It may be interrupted or killed at any moment: with --resume it goes on where it stopped. Files
    that were damaged meanwhile are found and computed again. A store of another plan is refused.

    Parameters
    ----------
    plan
        TOML file with the model, the axes and what to record.
    store
        Folder, .zip file or URL to use in place of the plan's.
    resume
        Go on with a store that exists.
    status
        Only say how much of the store is done.
    threads
        Processor cores used; all by default.
    scheduler
        Compute on the workers of this dask scheduler.
    device
        Where orbits are followed: processor cores, or an NVIDIA GPU.
    """
    from stickslip.sweeps.place import place_of
    from stickslip.sweeps.plan import read_plan

    with of_file():
        read = read_plan(plan)
    where = read.store if store is None else store
    with of_file() if store is None else nullcontext(), _endings(store):
        place_of(where, read.arguments["storage_options"])
        if status or not resume:
            known = _known(read, where)
    if not status:
        if not resume and known is not None:
            done = f"{known['done']} of {known['chunks']} chunks done"
            raise RefusalError(f"{where} exists, {done}; --resume goes on with it")
        advise(f"what was finished is kept in {where}; --resume goes on with it")
        with _endings(store), _client(scheduler) as client:
            known = _facts(read.run(store=where, threads=threads, client=client, device=device))
    facts: dict[str, Any] = {"store": where, "done": 0, "chunks": None, **(known or {})}
    if refused := facts.get("refused"):
        note(refused, quiet=output.quiet)
    text = where
    if status and known is None:
        text += ": not begun"
    elif status:
        text += ": {done} of {chunks} chunks done; not verified: {unverified}".format(**facts)
    row = {name: [fact] for name, fact in facts.items()}
    output.tell("sweep", {"plan": str(plan)}, row, f"{text}\n")


def _known(plan: Plan, where: str) -> dict[str, Any] | None:
    """Tell how much of a store is done; None if there is no store."""
    from stickslip.errors import StoreAbsent
    from stickslip.sweeps.sweep import open_sweep

    try:
        return _facts(open_sweep(where, storage_options=plan.arguments["storage_options"]))
    except StoreAbsent:
        return None


def _facts(found: xarray.Dataset) -> dict[str, Any]:
    told = ("done", "chunks", "unverified", "refused")
    return {name: found.attrs[name] for name in told if name in found.attrs}


@contextmanager
def _endings(option: str | None) -> Iterator[None]:
    """Give each way of ending badly its exit code; a plan names its store by a key, no option."""
    from stickslip.errors import StoreBusy, StoreRefused, TilesFailed, WorkersLost

    words = str if option is None else told_as
    try:
        yield
    except (StoreRefused, StoreBusy) as error:
        raise RefusalError(words(error)) from error
    except (TilesFailed, WorkersLost) as error:
        raise ComputationError(words(error)) from error


def _client(scheduler: str | None) -> Any:
    """Connect to a scheduler, if one is named."""
    if scheduler is None:
        return nullcontext()
    from stickslip.sweeps.engines import connect

    try:
        return connect(scheduler)
    except (OSError, ValueError) as error:
        raise UsageError(f"--scheduler {scheduler}: {error}") from error


PLOT_EXAMPLES = """\
stickslip plot coulomb.zarr --out map.png
stickslip plot coulomb.zarr --variable lyapunov_exponent \\
    --curve fold.json --out map.pdf
stickslip plot s3://bucket/map --at beta=1.3 --out map.svg
"""


def plot(
    store: str,
    *,
    out: Annotated[Path, Parameter(group=OUTPUT)],
    variable: str | None = None,
    at: Annotated[tuple[str, ...], Parameter(negative=(), metavar="NAME=VALUE")] = (),
    curve: Annotated[tuple[Path, ...], Parameter(negative=(), metavar="FILE")] = (),
    force: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    output: OutputOptions = OutputOptions(),
) -> None:
    """Draw a variable of a sweep over one or two of its axes, finished or not.

    Kinds and periods have a colour each, other numbers a scale that is even to the eye. Curves of
    bifurcations, saved by `follow(...).save(FILE)`, are drawn over the map.

    Parameters
    ----------
    store
        Folder, .zip file or URL of a sweep.
    out
        Write the picture; the name ends in .svg, .pdf or .png.
    variable
        What to draw; by default the first variable of the store.
    at
        The value of an axis that is not drawn, the nearest of those computed; for each. Of other
        axes, such as the points of an orbit (iterate), the place, counted from 0.
    curve
        File with a bifurcation curve in the two parameters that are drawn; for each.
    force
        Replace the picture if it exists.
    """
    from stickslip.plot import sweep_map
    from stickslip.results.files import load
    from stickslip.sweeps.sweep import open_sweep

    checked_suffix(out, PICTURE_SUFFIXES, "--out")
    curves = tuple(map(load, curve))
    opened = open_sweep(store)
    if refused := opened.attrs.get("refused"):
        note(refused, quiet=output.quiet)
    dataset = _cut(opened, at, quiet=output.quiet)
    with new_files([out], force=force) as (temporary,):
        draw_pictures(lambda ax: sweep_map.sweep(dataset, variable, ax, curves=curves), [temporary])
    output.tell("plot", {"store": store}, {"file": [str(out)]}, f"{out}\n")


def _cut(dataset: xarray.Dataset, at: tuple[str, ...], *, quiet: bool) -> xarray.Dataset:
    """Choose values of axes, those that were computed nearest, and places of points of an orbit."""
    from stickslip.checks import finite_number, whole_number  # loads NumPy

    for name, number in pairs("--at", at, "V=0.03", float).items():
        if name not in dataset.dims:
            axes = ", ".join(map(str, dataset.dims))
            raise UsageError(f"--at {name}={number}: the axes are {axes}")
        if name in dataset.coords:
            value = finite_number(f"--at {name}", number)
            dataset = dataset.sel({name: value}, method="nearest")
            if (taken := float(dataset[name])) != value:
                note(f"--at {name}={value}: the nearest computed is {taken}", quiet=quiet)
        else:
            last = dataset.sizes[name] - 1
            place = whole_number(f"--at {name}", number, 0, at_most=last, what="counted from 0")
            dataset = dataset.isel({name: place})
    return dataset
