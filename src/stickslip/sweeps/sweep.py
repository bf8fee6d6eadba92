"""`sweep`: run a description into a store, go on where it stopped, open what is there."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from datetime import timedelta
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.checks import check_callback, finite_number, instance, one_of, whole_number
from stickslip.errors import StoreAbsent, StoreRefused, TilesFailed
from stickslip.mechanics.eventmap.event_map import DEVICES
from stickslip.numerics.gpu import require_gpu
from stickslip.numerics.targets import available_threads
from stickslip.numerics.waiting import waits
from stickslip.sweeps import engines
from stickslip.sweeps.identity import target
from stickslip.sweeps.job import LARGEST_SEED, START, Job, as_axes, compute, default_chunks, tiles
from stickslip.sweeps.observables import as_observables, check_needs
from stickslip.sweeps.place import place_of, room_for, writing
from stickslip.sweeps.store import (
    MARKS,
    check_target,
    create_or_open,
    examined,
    finished,
    read_marks,
    refusals,
)
from stickslip.sweeps.systems import as_system
from stickslip.vocabulary import did_you_mean, suggests

if TYPE_CHECKING:
    from os import PathLike

    import xarray

    from stickslip.sweeps.engines import Outcome
    from stickslip.sweeps.job import Axis, AxisLike, Observable, Tile
    from stickslip.sweeps.store import Store
    from stickslip.sweeps.system import System

MOST_CHUNKS = 10**8  # 9 bytes of memory each
MOST_BYTES = 2**31 - 1  # of a variable in a chunk: what its codec takes
UNVERIFIED = "contents of the chunks, which going on with the sweep reads"


@dataclass(frozen=True)
class Progress:
    """How far a sweep is.

    Attributes
    ----------
    done, total : int
        Grid points computed, those of earlier runs included, and all.
    resumed : int
        Grid points that earlier runs had computed.
    seconds : float
        From the beginning of this run until a chunk was finished.
    waited : float
        Seconds since then.
    """

    done: int
    total: int
    resumed: int
    seconds: float
    waited: float = 0.0

    def __float__(self) -> float:
        return self.done / self.total

    def __str__(self) -> str:
        """Points done, their rate and the time left."""
        told = f"{self.done} of {self.total} grid points"
        if not self.rate > 0:
            return told
        return f"{told}, {self.rate:.3g}/s, {timedelta(seconds=round(self.remaining))} left"

    @property
    def rate(self) -> float:
        """Grid points per second of this run."""
        seconds = self.seconds + self.waited
        return (self.done - self.resumed) / seconds if seconds > 0 else 0.0

    @property
    def remaining(self) -> float:
        """Seconds until the end at the rate so far; a chunk in work may take as long again."""
        left = self.total - self.done
        return max(left / self.rate, self.waited if left else 0.0) if self.rate > 0 else math.inf


@waits
@suggests
def sweep(
    system: Any,
    axes: Mapping[str, AxisLike],
    observables: Iterable[Observable | str],
    *,
    store: str | PathLike[str],
    d: float | None = None,
    rng: int = 0,
    chunks: Mapping[str, int] | None = None,
    client: Any = None,
    device: str = "cpu",
    threads: int | None = None,
    storage_options: dict[str, Any] | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> xarray.Dataset:
    """Record what a system does over a grid of parameters, in a store that survives anything.

    Called again with the same description it goes on where it stopped, for whatever reason it
    did; a store that is complete is opened.

    Parameters
    ----------
    system : TwoBlock, Blocks, Chain, Oscillator, Structure, an event map or PiecewiseMap
        Values of the parameters that do not vary; an event map with its settings, or a return map
        of a line.
    axes : mapping
        Name of each varied parameter, or ``"d"`` for the starting point, to its values:
        ``(lo, hi, n)`` with whole n, `stickslip.axis`, or explicit ones.
    observables : iterable
        Of `stickslip.observables`, or their names for the default settings.
    store : str or path
        Local folder, file name ending in ``.zip``, or URL that fsspec knows, such as
        ``s3://bucket/name``.
    d : float, optional
        Starting point of every orbit; without it, and without an axis ``"d"``, one at random in
        the domain for each grid point. Observables of several orbits draw their own.
    rng : int
        What starting points are drawn from, by the place of a point in the grid.
    chunks : mapping of str to int, optional
        Points of a chunk along some axes; by default about 4096 in all. A chunk is one task and
        one file for each variable.
    client : distributed.Client, optional
        Workers to compute on, in place of threads of this process.
    device : {"cpu", "cuda"}
        "cuda": each orbit of two undamped blocks, with its verdict and exponent, is a thread of an
        NVIDIA GPU (extra ``gpu``).
    threads : int, optional
        Processor cores used; all by default.
    storage_options : dict, optional
        For the file system of the store.
    progress : callable, optional
        Called with a `Progress` at the start and after each chunk.

    Returns
    -------
    xarray.Dataset
        As `open_sweep`: one variable for each that the observables record, with the axes as its
        dimensions. Nothing is read until it is asked for. Grid points whose parameters the system
        does not allow together are stored as those without a value; the attribute ``refused``
        tells how many there are, and why.

    Raises
    ------
    ValueError
        An axis, an observable or a setting is not allowed, before anything runs; no GPU was found.
    StoreRefused
        A ValueError: the store holds another sweep, or one computed on another kind of machine,
        on another device or by other kernels.
    StoreBusy
        Another process writes to the store.
    StoreFull
        An OSError: no space is left.
    TilesFailed
        Chunks could not be computed, all others are stored.
    WorkersLost
        The scheduler or the client is gone; what was finished is stored.
    ImportError
        The extra is not installed: ``pip install "stickslip[sweep]"``.

    Notes
    -----
    Values do not depend on chunks, threads, workers or interruptions: a point is computed from
    its parameters and its place in the grid alone.

    Examples
    --------
    >>> import stickslip as ss
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     found = ss.sweep(
    ...         ss.examples.coulomb(),
    ...         {"V": [0.0366, 0.15]},
    ...         ["attractor"],
    ...         store=folder + "/map",
    ...         d=0.279,
    ...     )
    ...     found.period.values
    array([4, 1], dtype=int32)
    """
    if client is not None and threads is not None:
        raise ValueError("threads and client: a client's workers have their own threads.")
    check_callback("progress", progress, "a Progress")
    device = one_of("device", device, DEVICES)
    # A GPU takes one tile after the other, each with as many orbits as it has threads.
    cores = 1 if device == "cuda" else available_threads()
    cores = cores if threads is None else whole_number("threads", threads, 1)
    grid = as_axes(axes)
    job = _job(as_system(system), grid, as_observables(observables), rng, d, device)
    sizes = _chunks(grid, job, chunks)
    place = place_of(store, storage_options)
    examined(place)  # what is no sweep is refused before a lock is put beside it
    with room_for(place.url), writing(place) as check:
        place.unpack()
        place.clear_remains()
        opened = create_or_open(place, job, grid, sizes, given=chunks is not None)
        todo, shown = _todo(opened, grid, progress)
        run = (
            engines.in_threads(compute, job, todo, cores)
            if client is None
            else engines.in_dask(compute, job, todo, client)
        )
        with closing(run):
            _write(opened, run, target(device), check, shown)
        place.pack()
    return open_sweep(store, storage_options=storage_options)


@suggests
def open_sweep(
    store: str | PathLike[str], *, storage_options: dict[str, Any] | None = None
) -> xarray.Dataset:
    """Open the store of a sweep for reading, finished or not.

    Parameters
    ----------
    store : str or path
        As for `sweep`.
    storage_options : dict, optional
        For the file system of the store.

    Returns
    -------
    xarray.Dataset
        Values that were not computed yet are NaN, or the least number of their type. The
        attributes tell the description, how many chunks there are and how many are ``done``:
        marked, with a file of each variable. What was not verified is told in ``unverified``;
        how many grid points the system refused, and why, in ``refused``.

    Raises
    ------
    StoreRefused
        A ValueError: there is no sweep, or a file of its metadata or coordinates is damaged; the
        message names the file.
    ImportError
        The extra is not installed: ``pip install "stickslip[sweep]"``.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import stickslip as ss
    >>> store = pathlib.Path(tempfile.mkdtemp()) / "line.zarr"
    >>> _ = ss.sweep(ss.examples.coulomb(), {"V": [0.0366, 0.05]}, ["attractor"], store=store)
    >>> ss.open_sweep(store).period.values
    array([1, 0], dtype=int32)
    """
    place = place_of(store, storage_options)
    import xarray
    import zarr

    facts, damaged = examined(place)
    if facts is None:
        raise StoreAbsent(f"store = {place.url!r}: there is no sweep.")
    if damaged:
        raise StoreRefused(
            f"{place.of(damaged[0])} is damaged or missing, or the sweep has only begun. Run the "
            "same sweep again (on the command line with --resume): what depends on the "
            "description alone is made again."
        )
    source = place.zarr_store(read_only=True)
    marks = read_marks(zarr.open_group(source, mode="r")[MARKS])
    dataset = xarray.open_zarr(source, chunks=None, consolidated=True).drop_vars(MARKS)
    dataset.attrs = {
        **{key: facts[key] for key in ("version", "created", "digest")},
        "description": facts["description"],
        "target": facts["target"],
        "chunks": int(marks.size),
        "done": int(np.count_nonzero(finished(place, marks, map(str, dataset.data_vars)))),
        "unverified": UNVERIFIED,
    }
    count, why = refusals(place)
    if count:
        points = math.prod(each["n"] for each in facts["description"]["axes"].values())
        dataset.attrs["refused"] = (
            f"without values: {count} of {points} grid points, parameters of which the system "
            f"does not allow together. The first: {why}"
        )
    return dataset


def _job(
    system: System,
    axes: Mapping[str, Axis],
    observables: tuple[Observable, ...],
    seed: int,
    d: float | None,
    device: str,
) -> Job:
    """Check a description as a whole."""
    _check_device(device, system, observables)
    seed = whole_number("rng", seed, 0, at_most=LARGEST_SEED - 1)
    if d is not None:
        if START in axes:
            raise ValueError("d is an axis and a number: give one of them.")
        d = finite_number(START, d)
    if (d is not None or START in axes) and START in system.lacks:
        raise ValueError(f"d: {system.lacks[START]}.")
    if START in axes and START in system.identity()["parameters"]:
        raise ValueError(
            "axis 'd': the system has a parameter of that name, which is the starting point's. "
            "Give the parameter another name."
        )
    check_needs(system, observables)
    for each in observables:
        for name in (name for output in each.outputs() for name in (output.name, *output.dims)):
            if name in axes or name == MARKS:
                raise ValueError(f"observable {each.name!r}: the name {name!r} is taken.")
    for name in axes:
        if name == MARKS:
            raise ValueError(f"axis {name!r}: stores use that name for themselves.")
        if name != START:
            _check_values(system, name, axes)
    shape = tuple(map(len, axes.values()))
    return Job(system.on(device), tuple(axes), shape, observables, seed, d, device)


def _check_device(device: str, system: System, observables: tuple[Observable, ...]) -> None:
    """Refuse a device that is missing, or of no use for a sweep."""
    if device == "cpu":
        return
    system.on(device)
    for each in observables:
        if "orbits" not in each.needs:
            raise ValueError(
                f"observable {each.name!r} is computed on the CPU, not on device = {device!r}."
            )
    require_gpu()


def _check_values(system: System, name: str, axes: Mapping[str, Axis]) -> None:
    """Refuse names and values that the system does not know."""
    others = [
        [(other, float(end)) for end in axis.values[[0, -1]]]
        for other, axis in axes.items()
        if other not in (name, START)
    ]
    for value in axes[name].values.tolist():
        try:
            system.check({name: value})
        except ValueError as error:
            if name not in system.names:
                known = did_you_mean(name, system.names)
                raise ValueError(
                    f"axis {name!r} is no parameter that takes a number. {known}"
                ) from error
            # The other parameters' own values may be what it does not go with: a corner may do.
            corners = ({name: value, **dict(each)} for each in itertools.product(*others))
            if not any(_allowed(system, corner) for corner in corners):
                raise ValueError(f"axis {name!r}: {error}") from error


def _allowed(system: System, values: Mapping[str, float]) -> bool:
    try:
        system.check(values)
    except ValueError:
        return False
    return True


def _chunks(axes: Mapping[str, Axis], job: Job, given: Mapping[str, int] | None) -> tuple[int, ...]:
    chosen = dict(zip(job.names, default_chunks(job.shape, job.device), strict=True))
    asked = {} if given is None else instance("chunks", given, Mapping, "sizes by axis")
    for name, size in asked.items():
        if name not in axes:
            raise ValueError(f"chunks: {name!r} is no axis; the axes are {', '.join(axes)}.")
        chosen[name] = min(whole_number(f"chunks[{name!r}]", size, 1), len(axes[name]))
    sizes = tuple(chosen[name] for name in job.names)
    _check_sizes(job, sizes)
    return sizes


def _check_sizes(job: Job, chunks: tuple[int, ...]) -> None:
    """Refuse more chunks than can be told apart, and chunks larger than can be written."""
    count = math.prod(-(-n // size) for n, size in zip(job.shape, chunks, strict=True))
    points = math.prod(chunks)
    if count > MOST_CHUNKS:
        raise ValueError(
            f"axes: {math.prod(job.shape)} grid points in chunks of {points} are {count} chunks, "
            f"at most {MOST_CHUNKS} are allowed. Take larger chunks, or fewer values."
        )
    held = {
        output.name: math.prod(output.sizes) * np.dtype(output.dtype).itemsize
        for output in job.outputs
    }
    held |= {
        f"the orbits from {run.n_starts} starts": 8 * run.n_starts * tail
        for run, tail in job.tails.items()
    }
    for name, size in held.items():
        if points * size > MOST_BYTES:
            raise ValueError(
                f"observables: {name} would take {points * size} bytes in a chunk of {points} "
                f"points, at most {MOST_BYTES} are allowed. Take smaller chunks or settings."
            )


def _todo(
    store: Store, axes: Mapping[str, Axis], progress: Callable[[Progress], object] | None
) -> tuple[Iterator[Tile], Callable[[int], None]]:
    """Return the tiles that are not done, and a function that shows more points as done."""
    done = store.done(tiles(axes, store.chunks))
    total = math.prod(map(len, axes.values()))
    resumed = sum(tile.size for tile in tiles(axes, store.chunks) if done[tile.index])
    state = {"done": resumed}
    began = perf_counter()

    def show(points: int) -> None:
        state["done"] += points
        if progress is not None:
            progress(Progress(state["done"], total, resumed, perf_counter() - began))

    show(0)
    return (tile for tile in tiles(axes, store.chunks) if not done[tile.index]), show


def _write(
    store: Store,
    outcomes: Iterable[Outcome],
    here: dict[str, str],
    check: Callable[[], None],
    show: Callable[[int], None],
) -> None:
    """Write tiles as they are computed."""
    failed: list[tuple[Tile, Exception]] = []
    for tile, computed in outcomes:
        check()
        if isinstance(computed, Exception):
            failed.append((tile, computed))
            continue
        check_target("A part of this sweep", computed.target, here)
        store.write(tile, computed)
        show(tile.size)
    if failed:
        tile, error = failed[0]
        where = ", ".join(f"{a} to {a + n}" for a, n in zip(tile.start, tile.shape, strict=True))
        raise TilesFailed(
            f"{len(failed)} chunks of {store.place.url} could not be computed, the others are "
            f"stored. The first, grid points [{where}]: {type(error).__name__}: {error}"
        ) from error
