"""Who computes the tiles: threads of this process, or the workers of a dask scheduler.

Both hand back what is ready, in any order, and hold only a few tiles at a time.
"""

from __future__ import annotations

import importlib
import itertools
import uuid
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from functools import partial
from typing import Any, Final, TypeAlias

from stickslip.errors import WorkersLost
from stickslip.extras import require_extra
from stickslip.sweeps.job import Computed, Job, Tile

# Tiles handed out for each core: enough that no core waits while results are written.
AHEAD: Final = 3
# And at least so many through a scheduler, where the way there and back takes its time.
LEAST_AHEAD: Final = 32
CONNECT_SECONDS: Final = 10

Outcome: TypeAlias = "tuple[Tile, Computed | Exception]"
Compute: TypeAlias = "Callable[[Job, Tile], Computed]"


def in_threads(
    compute: Compute, job: Job, tiles: Iterable[Tile], threads: int
) -> Generator[Outcome, None, None]:
    """Compute tiles in threads; kernels release the interpreter's lock."""
    queue = iter(tiles)
    pool = ThreadPoolExecutor(threads, thread_name_prefix="stickslip-sweep")
    running: dict[Future[Computed], Tile] = {}
    try:
        while True:
            for tile in itertools.islice(queue, AHEAD * threads - len(running)):
                running[pool.submit(compute, job, tile)] = tile
            if not running:
                return
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                yield running.pop(future), _outcome(future.exception(), future.result)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def in_dask(
    compute: Compute, job: Job, tiles: Iterable[Tile], client: Any
) -> Generator[Outcome, None, None]:
    """Compute tiles on the workers of a ``dask.distributed`` client."""
    # The scheduler gives the tiles of a worker that died to others. This process alone writes:
    # workers need no access to the store.
    distributed: Any = importlib.import_module("distributed")

    name = f"stickslip-{uuid.uuid4().hex[:8]}"
    queue = iter(tiles)
    running: dict[str, Tile] = {}

    def submit(count: int) -> list[Any]:
        some = {
            f"{name}-{'-'.join(map(str, tile.index))}": tile
            for tile in itertools.islice(queue, count)
        }
        running.update(some)
        tiles = list(some.values())
        return client.map(partial(compute, job), tiles, key=list(some), pure=False)

    futures = None
    try:
        cores = sum(client.ncores().values())
        if not cores:
            raise ValueError("client: its scheduler has no workers.")
        futures = distributed.as_completed(submit(max(AHEAD * cores, LEAST_AHEAD)))
        for batch in futures.batches():
            ready = [future for future in batch if future.status == "finished"]
            results = dict(zip(ready, client.gather(ready), strict=True))
            for future in batch:
                # Else an error, or a worker that died: wait for the one that does it again.
                result = results.get(future) or _outcome(future.exception(), future.result)
                yield running.pop(future.key), result
                future.release()
            futures.update(submit(len(batch)))
    except Exception as error:
        if client.status == "running" and not isinstance(error, CancelledError | OSError):
            raise
        told = f"{type(error).__name__}: {error}".splitlines()[0]
        raise WorkersLost(
            f"the dask scheduler or its client is lost ({told}). What was finished is kept: run "
            "the same sweep again, with a scheduler that runs (on the command line with --resume), "
            "to go on."
        ) from error
    finally:
        if futures is not None:
            with suppress(Exception):  # it is lost
                client.cancel(list(futures.futures), force=True)


def connect(address: str) -> Any:
    """Connect to a dask scheduler; OSError or ValueError if there is none."""
    require_extra("cluster", "schedulers", "distributed")
    distributed: Any = importlib.import_module("distributed")
    return distributed.Client(address, timeout=CONNECT_SECONDS)


def _outcome(error: BaseException | None, result: Callable[[], Any]) -> Any:
    if error is None:
        return result()
    if isinstance(error, Exception):
        return error
    raise error
