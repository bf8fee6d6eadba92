"""A sweep on disk: zarr arrays, one chunk a tile, and a mark for each tile that is done.

The mark of a tile is a checksum of all its values, written after them. On resuming every marked
tile is read back: a chunk that is missing, torn (its own CRC-32C does not fit) or of other
content (the mark does not fit) makes its tile one to compute again.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip import __version__
from stickslip.sweeps import target as targets
from stickslip.sweeps.errors import StoreFull, StoreRefused
from stickslip.sweeps.identity import digest
from stickslip.sweeps.place import is_full
from stickslip.vocabulary import TERMS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.sweeps.axis import Axis
    from stickslip.sweeps.job import Computed, Job, Tile
    from stickslip.sweeps.observable import Output
    from stickslip.sweeps.place import Place

__all__ = ["MARKS", "ROOT", "Store", "create_or_open", "described", "read_marks", "refuse_foreign"]

ATTRIBUTE: Final = "stickslip"  # of the root group: what the sweep is and who computed it
BEING_MADE: Final = {"being made": True}  # instead, until all arrays are laid out
ROOT: Final = "zarr.json"
MARKS: Final = "checksum"
READ_AHEAD: Final = 1024
READERS: Final = 8  # threads that check marked tiles: they wait for disk or network


@dataclass(frozen=True, eq=False)
class Store:
    """An open store.

    Attributes
    ----------
    place : Place
    arrays : dict of str to zarr.Array
        Each variable and the marks by name, opened once: that costs as much as a chunk.
    outputs : tuple of Output
    chunks : tuple of int
        Points of a tile along each axis.
    """

    place: Place
    arrays: dict[str, Any]
    outputs: tuple[Output, ...]
    chunks: tuple[int, ...]

    def write(self, tile: Tile, computed: Computed) -> None:
        """Write the values of a tile, then its mark.

        Raises
        ------
        StoreFull
            No space is left; the tile is not marked.
        """
        try:
            self._write(tile, computed)
        except Exception as error:
            if is_full(error):
                raise StoreFull(
                    f"no space is left for {self.place.url}. What was finished is kept: make "
                    "room, then run the same sweep again to go on."
                ) from error
            # A chunk at the end of an axis is read first: what lies there may be damaged.
            self._forget(tile)
            self._write(tile, computed)

    def _write(self, tile: Tile, computed: Computed) -> None:
        for output in self.outputs:
            self.arrays[output.name][tile.region] = computed.arrays[output.name]
        self.arrays[MARKS][tile.index] = _checksum(computed.arrays, self.outputs)

    def done(self, tiles: Iterable[Tile]) -> NDArray[np.bool_]:
        """Tell which tiles are marked and whole; what is left of others is removed."""
        marks = read_marks(self.arrays[MARKS])
        done = np.zeros(marks.shape, dtype=bool)
        marked = (tile for tile in tiles if marks[tile.index])
        with ThreadPoolExecutor(READERS) as pool:
            # Some at a time: there may be millions.
            while some := list(itertools.islice(marked, READ_AHEAD)):
                for tile, found in zip(some, pool.map(self._checksum_of, some), strict=True):
                    done[tile.index] = found == marks[tile.index]
                    if not done[tile.index]:
                        self._forget(tile)
        return done

    def _checksum_of(self, tile: Tile) -> np.uint64:
        try:
            arrays = {each.name: self.arrays[each.name][tile.region] for each in self.outputs}
        except Exception:  # a codec's complaint of whatever kind: torn
            return np.uint64(0)
        return _checksum(arrays, self.outputs)

    def _forget(self, tile: Tile) -> None:
        self.place.remove(self.place.of(f"{MARKS}/c/{'/'.join(map(str, tile.index))}"))
        for output in self.outputs:
            key = "/".join(map(str, (*tile.index, *(0 for _ in output.sizes))))
            self.place.remove(self.place.of(f"{output.name}/c/{key}"))


def read_marks(array: Any) -> NDArray[np.uint64]:
    """Read all marks, 0 where there is none or it is damaged."""
    marks = np.zeros(array.shape, dtype=np.uint64)
    try:
        marks[...] = array[...]
    except Exception:  # whatever the codecs say of a torn one: look at each by itself
        for index in np.ndindex(array.shape):
            with suppress(Exception):
                marks[index] = array[index]
    return marks


def _checksum(arrays: Mapping[str, Any], outputs: tuple[Output, ...]) -> np.uint64:
    """Return a checksum of a tile's values, never 0."""
    content = hashlib.blake2b(digest_size=8)
    for output in outputs:
        array = np.ascontiguousarray(arrays[output.name])
        content.update(array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes())
    return np.uint64(int.from_bytes(content.digest(), "little") | 1)


def create_or_open(
    place: Place, job: Job, axes: Mapping[str, Axis], chunks: tuple[int, ...], *, given: bool
) -> Store:
    """Open the store of a sweep, or make it; whoever calls holds the right to write.

    Parameters
    ----------
    chunks : tuple of int
        For a new store; an old one keeps its own.
    given : bool
        Whether the user asked for these chunks, so that others are refused.

    Raises
    ------
    StoreRefused
        There is something else than this sweep, computed by code for this kind of machine.
    """
    import zarr

    if place.exists(ROOT):
        group = zarr.open_group(place.zarr_store(), mode="r+")
        stored = described(place, group)
        if stored != BEING_MADE:
            here = targets.target(job.device)
            _compare(place, stored, job.identity(axes), chunks if given else None, here)
            return Store(place, dict(group.arrays()), job.outputs, tuple(stored["chunks"]))
    group = _created(place, job, axes, chunks)
    return Store(place, dict(group.arrays()), job.outputs, chunks)


def refuse_foreign(place: Place) -> None:
    """Refuse, before anything is written, a place that holds something else than a sweep."""
    import zarr

    if place.packed or place.exists(ROOT):
        described(place, zarr.open_group(place.zarr_store(read_only=True), mode="r"))
    elif not place.empty():
        raise StoreRefused(f"{place.url} is not empty and no sweep. Give the name of a new store.")


def _created(place: Place, job: Job, axes: Mapping[str, Axis], chunks: tuple[int, ...]) -> Any:
    """Lay out the arrays; the description of the group comes last, and makes it a sweep."""
    import zarr
    from zarr.codecs import Crc32cCodec, ZstdCodec

    target = place.zarr_store()
    group = zarr.create_group(target, attributes={ATTRIBUTE: BEING_MADE}, overwrite=True)

    def array(
        name: str, shape: Any, chunks: Any, dtype: Any, dims: Any, fill: Any, about: Any
    ) -> Any:
        return zarr.create_array(
            target,
            name=name,
            shape=shape,
            chunks=chunks,
            dtype=dtype,
            compressors=(ZstdCodec(level=3), Crc32cCodec()),
            fill_value=fill,
            dimension_names=dims,
            attributes=about,
            config={"write_empty_chunks": True},  # an all-NaN chunk is a result too
            overwrite=True,
        )

    counts = tuple(-(-n // size) for n, size in zip(job.shape, chunks, strict=True))
    dims = tuple(f"{name}_chunk" for name in job.names)
    about: dict[str, Any] = {"long_name": "checksum of the values of a tile, 0 if not computed"}
    array(MARKS, counts, (1,) * len(counts), "uint64", dims, 0, about)
    for name in job.names:
        values = axes[name].values
        about = _about(name)
        array(name, values.shape, values.shape, "float64", (name,), np.nan, about)[...] = values
    for output in job.outputs:
        array(
            output.name,
            (*job.shape, *output.sizes),
            (*chunks, *output.sizes),
            output.dtype,
            (*job.names, *output.dims),
            missing(output.dtype),
            {"long_name": output.long_name, **_flags(output)},
        )
    identity = job.identity(axes)
    facts = {
        "description": identity,
        "digest": digest(identity),
        "chunks": list(chunks),
        "target": targets.target(job.device),
        "version": __version__,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    return group.update_attributes({ATTRIBUTE: facts})


def missing(dtype: str) -> Any:
    """Return what stands for a value that was not computed yet."""
    kind = np.dtype(dtype).kind
    if kind == "f":
        return math.nan
    return False if kind == "b" else int(np.iinfo(dtype).min) if kind == "i" else 0


def _about(name: str) -> dict[str, Any]:
    if name not in TERMS:
        return {"long_name": name}
    term = TERMS[name]
    return {"long_name": term.meaning, **({"units": term.scale} if term.scale else {})}


def _flags(output: Output) -> dict[str, Any]:
    if not output.flags:
        return {}
    return {"flag_values": list(output.flags), "flag_meanings": " ".join(output.flags.values())}


def described(place: Place, group: Any) -> dict[str, Any]:
    """Return what a store says of itself.

    Raises
    ------
    StoreRefused
        It is not a sweep.
    """
    facts = group.attrs.get(ATTRIBUTE)
    if not isinstance(facts, dict):
        raise StoreRefused(f"{place.url} is a zarr store, but not one of a sweep.")
    return facts


def _compare(
    place: Place,
    stored: dict[str, Any],
    identity: dict[str, Any],
    chunks: tuple[int, ...] | None,
    here: dict[str, str],
) -> None:
    """Refuse a store of another sweep, of other kernels, or of another kind of machine."""
    if stored["digest"] != digest(identity):
        changes = "; ".join(_changes(stored["description"], identity))
        raise StoreRefused(
            f"{place.url} holds another sweep: {changes}. Nothing was changed; give another store."
        )
    if chunks is not None and tuple(stored["chunks"]) != chunks:
        raise StoreRefused(
            f"{place.url} has chunks {tuple(stored['chunks'])}, not {chunks}. Leave chunks out."
        )
    check_target(place.url, stored["target"], here)


def check_target(whose: str, stored: dict[str, Any], here: dict[str, str]) -> None:
    """Refuse to mix results of different kernels or kinds of machines."""
    if unlike := targets.difference(stored, here):
        raise StoreRefused(
            f"{whose} was computed otherwise ({unlike}): results would differ in their last "
            "digits. Go on there, or begin a new store."
        )


def _changes(stored: Any, asked: Any, path: str = "") -> list[str]:
    """List what differs between two descriptions, by key."""
    if isinstance(stored, dict) and isinstance(asked, dict):
        found = []
        for key in dict.fromkeys([*stored, *asked]):
            inner = f"{path}.{key}" if path else str(key)
            found += _changes(stored.get(key), asked.get(key), inner)
        return found
    if isinstance(stored, list) and isinstance(asked, list) and len(stored) == len(asked):
        pairs = enumerate(zip(stored, asked, strict=True))
        return [text for k, (a, b) in pairs for text in _changes(a, b, f"{path}[{k}]")]
    return [] if stored == asked else [f"{path} = {stored!r} there, {asked!r} here"]
