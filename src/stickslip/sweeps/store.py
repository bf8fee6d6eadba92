"""A sweep on disk: zarr arrays, one chunk a tile, and a mark for each tile that is done.

All files but those of tiles are a function of the description, checked and made again. A mark,
written last, is a checksum of the tile; on resuming each marked tile is compared with its mark.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip import __version__
from stickslip.errors import StoreFull, StoreRefused
from stickslip.sweeps.identity import digest, target, target_difference
from stickslip.sweeps.job import missing
from stickslip.sweeps.place import room_for
from stickslip.vocabulary import TERMS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.sweeps.job import Axis, Computed, Job, Output, Tile
    from stickslip.sweeps.place import Place

ATTRIBUTE: Final = "stickslip"  # of two files: what the sweep is and who computed it
SEAL: Final = "checksum"  # in it: of all else in that file
METADATA: Final = "zarr.json"
MARKS: Final = "checksum"
INDEX: Final = f"{MARKS}/{METADATA}"
NOTES: Final = (
    f"{MARKS}/refused"  # of tiles: <place>/<grid points that were refused>, why the first
)
COPIES: Final = (INDEX, METADATA)  # which say what the sweep is; the first and the last written
ANOTHER: Final = "Give the name of a store of a sweep, or of a new one."
READ_AHEAD: Final = 1024
READERS: Final = 8  # threads that check marked tiles: they wait for disk or network


@dataclass(frozen=True, eq=False)
class Store:
    """An open store."""

    place: Place
    # variables and marks by name, opened once: that costs as much as a chunk
    arrays: dict[str, Any]
    outputs: tuple[Output, ...]
    chunks: tuple[int, ...]  # points of a tile along each axis
    key: str  # of the description, which every mark covers

    def write(self, tile: Tile, computed: Computed) -> None:
        """Write the values of a tile, then its mark: where no space is left there is no mark."""
        try:
            self._write(tile, computed)
        except StoreFull:
            raise
        except Exception:
            # A chunk at the end of an axis is read first: what lies there may be damaged.
            self._forget(tile, self.place.names(_notes_of(tile)))
            self._write(tile, computed)

    def _write(self, tile: Tile, computed: Computed) -> None:
        for output in self.outputs:
            with room_for(self._file(tile, output)):
                self.arrays[output.name][tile.region] = computed.arrays[output.name]
        notes = {}
        if computed.refused:
            name = f"{_notes_of(tile)}/{len(computed.refused)}"
            notes[name] = computed.refused[0].encode()
            self.place.write(name, notes[name])
        with room_for(self._file(tile)):
            self.arrays[MARKS][tile.index] = self._mark(tile, computed.arrays, notes)

    def done(self, tiles: Iterable[Tile]) -> NDArray[np.bool_]:
        """Tell which tiles are marked and whole; remove the remains of all others."""
        marks = read_marks(self.arrays[MARKS])
        done = finished(self.place, marks, [output.name for output in self.outputs])
        marked = (tile for tile in tiles if marks[tile.index])
        notes: dict[str, list[str]] = {}
        for name in sorted(self.place.names(NOTES)):  # all at once: each time is a request
            key = "/".join(name.split("/")[: NOTES.count("/") + 1 + marks.ndim])
            notes.setdefault(key, []).append(name)

        def found(tile: Tile) -> np.uint64:
            return self._found(tile, notes.get(_notes_of(tile), []))

        with ThreadPoolExecutor(READERS) as pool:
            # Some at a time: there may be millions.
            while some := list(itertools.islice(marked, READ_AHEAD)):
                for tile, mark in zip(some, pool.map(found, some), strict=True):
                    done[tile.index] &= mark == marks[tile.index]
                    if not done[tile.index]:
                        self._forget(tile, notes.get(_notes_of(tile), []))
        return done

    def _found(self, tile: Tile, names: Iterable[str]) -> np.uint64:
        try:
            arrays = {each.name: self.arrays[each.name][tile.region] for each in self.outputs}
        except Exception:  # a codec's complaint of whatever kind: torn
            return np.uint64(0)
        return self._mark(tile, arrays, {name: self.place.read(name) or b"" for name in names})

    def _mark(self, tile: Tile, arrays: Mapping[str, Any], notes: Mapping[str, bytes]) -> np.uint64:
        """Return a checksum of a tile's values, notes and place and of the description, never 0."""
        content = hashlib.blake2b(repr((self.key, self.chunks, tile.index)).encode(), digest_size=8)
        for output in self.outputs:
            array = np.ascontiguousarray(arrays[output.name])
            content.update(output.name.encode())
            content.update(array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes())
        for name, note in notes.items():
            content.update(name.encode() + note)
        return np.uint64(int.from_bytes(content.digest(), "little") | 1)

    def _forget(self, tile: Tile, notes: Iterable[str]) -> None:
        for path in (self._file(tile), *(self._file(tile, output) for output in self.outputs)):
            self.place.remove(path)
        for name in notes:
            self.place.remove(self.place.of(name))

    def _file(self, tile: Tile, output: Output | None = None) -> str:
        """Path of a chunk of a variable, or of the mark."""
        name, sizes = (MARKS, ()) if output is None else (output.name, output.sizes)
        key = "/".join(map(str, (*tile.index, *(0 for _ in sizes))))
        return self.place.of(f"{name}/c/{key}")


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


def finished(place: Place, marks: NDArray[np.uint64], names: Iterable[str]) -> NDArray[np.bool_]:
    """Tell which tiles are marked and have a file of each variable, unread."""
    done = marks != 0
    for name in names:
        present = np.zeros(marks.shape, dtype=bool)
        for path in place.names(f"{name}/c"):
            key = path.removeprefix(f"{name}/c/").split("/")[: marks.ndim]
            if all(map(str.isdigit, key)):
                with suppress(IndexError):  # of a tile that the grid does not have
                    present[tuple(map(int, key))] = True
        done &= present
    return done


def _notes_of(tile: Tile) -> str:
    return "/".join((NOTES, *map(str, tile.index)))


def refusals(place: Place) -> tuple[int, str]:
    """Tell how many grid points were refused and, in the order of the grid, why the first."""
    notes = []
    for name in place.names(NOTES):
        key = name.removeprefix(f"{NOTES}/").split("/")
        if all(map(str.isdigit, key)):
            notes.append(([*map(int, key)], name))
    first = place.read(min(notes)[1]) if notes else None
    return sum(key[-1] for key, _ in notes), (first or b"").decode(errors="replace")


def create_or_open(
    place: Place, job: Job, axes: Mapping[str, Axis], chunks: tuple[int, ...], *, given: bool
) -> Store:
    """Open the store of a sweep, or make it; whoever calls holds the right to write."""
    # An old store keeps its chunks; where the user has `given` other ones, the store is refused.
    import zarr

    identity, here = job.identity(axes), target(job.device)
    facts, damaged = examined(place)
    if facts is None:
        facts = {
            "description": identity,
            "digest": digest(identity),
            "chunks": list(chunks),
            "target": here,
            "version": __version__,
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
        }
    else:
        _compare(place, facts, identity, chunks if given else None, here)
        chunks = tuple(facts["chunks"])
    if damaged:
        for name, content in _layout(job, axes, chunks, facts).items():
            if place.read(name) != content:
                place.write(name, content)
    # A tile in which no value exists is a result too, and has its files.
    with zarr.config.set({"array.write_empty_chunks": True}):
        arrays = dict(zarr.open_group(place.zarr_store(), mode="r+").arrays())
    return Store(place, arrays, job.outputs, chunks, facts["digest"])


def examined(place: Place) -> tuple[dict[str, Any] | None, list[str]]:
    """Return what a store says of itself, and which files of its layout are damaged or missing."""
    documents = {name: place.read(name) for name in COPIES}
    pairs = itertools.product(COPIES, documents.values())  # they may have changed places
    facts = next(filter(None, itertools.starmap(_unsealed, pairs)), None)
    if facts is not None:
        damaged = [name for name in COPIES if _unsealed(name, documents[name]) != facts]
        for name, checksum in facts["files"].items():
            content = place.read(name)
            if content is None or digest(content) != checksum:
                damaged.append(name)
        return facts, damaged
    name = next((name for name in reversed(COPIES) if documents[name] is not None), None)
    if name is not None and f'"{ATTRIBUTE}"'.encode() in (documents[name] or b""):
        raise StoreRefused(
            f"{place.of(name)} does not fit its own checksum: it is damaged, or of an earlier "
            f"version. Restore it from a copy. {ANOTHER}"
        )
    if name is not None:
        raise StoreRefused(f"{place.of(name)} is not of a sweep. {ANOTHER}")
    if not place.empty():
        raise StoreRefused(f"{place.url} is not empty and no sweep. {ANOTHER}")
    return None, list(COPIES)


def _unsealed(name: str, content: bytes | None) -> dict[str, Any] | None:
    """Return what a file of that name says of the sweep, None if it does not fit its checksum."""
    try:
        document = json.loads(content or b"")
        facts: dict[str, Any] = document["attributes"][ATTRIBUTE]
        return facts if facts.pop(SEAL) == digest([name, document]) else None
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None


def _sealed(name: str, document: dict[str, Any], facts: dict[str, Any]) -> bytes:
    """Write what the sweep is into a file of metadata, with a checksum of the whole."""
    document["attributes"][ATTRIBUTE] = told = dict(facts)
    told[SEAL] = digest([name, document])
    return json.dumps(document, indent=2).encode()


def _layout(
    job: Job, axes: Mapping[str, Axis], chunks: tuple[int, ...], facts: Mapping[str, Any]
) -> dict[str, bytes]:
    """Make all files that depend on the description alone, in the order to write them."""
    # The last one makes it a zarr group, and has the metadata of all arrays for those who read.
    import zarr
    from zarr.codecs import Crc32cCodec, ZstdCodec

    made: dict[str, Any] = {}
    memory = zarr.storage.MemoryStore(made)
    zarr.create_group(memory)

    def array(
        name: str, shape: Any, chunks: Any, dtype: Any, dims: Any, fill: Any, about: Any
    ) -> Any:
        return zarr.create_array(
            memory,
            name=name,
            shape=shape,
            chunks=chunks,
            dtype=dtype,
            compressors=(ZstdCodec(level=3), Crc32cCodec()),
            fill_value=fill,
            dimension_names=dims,
            attributes=about,
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
    files = {name: content.to_bytes() for name, content in made.items()}
    root = json.loads(files.pop(METADATA))
    arrays = {
        name.removesuffix(f"/{METADATA}"): json.loads(content)
        for name, content in files.items()
        if name.endswith(METADATA)
    }
    root["consolidated_metadata"] = {
        "kind": "inline",
        "must_understand": False,
        "metadata": arrays,
    }
    index = json.loads(files.pop(INDEX))
    facts = {**facts, "files": {name: digest(content) for name, content in files.items()}}
    last = {METADATA: _sealed(METADATA, root, facts)}
    return {INDEX: _sealed(INDEX, index, facts), **files, **last}


def _about(name: str) -> dict[str, Any]:
    if name not in TERMS:
        return {"long_name": name}
    term = TERMS[name]
    return {"long_name": term.meaning, **({"units": term.scale} if term.scale else {})}


def _flags(output: Output) -> dict[str, Any]:
    if not output.flags:
        return {}
    return {"flag_values": list(output.flags), "flag_meanings": " ".join(output.flags.values())}


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
    if unlike := target_difference(stored, here):
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
