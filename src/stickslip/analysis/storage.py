"""Results in files: JSON with a version, every float exact, written whole or not at all.

A result is written field by field; `TYPES` lists the classes that a file may hold. Fields are
checked when they are read, by the annotations of their classes, and the whole by a checksum.
Files of 0.1.0 have no checksum: of them the fields alone are checked. Maps are
written by a description that whoever makes them supplies (`register_map`): this layer does not
know what they stand for. A map that has none, such as a Python function, is left out, and
`load` is given it again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import json
import math
import reprlib
from collections.abc import Callable, Mapping
from functools import cache
from types import UnionType
from typing import (
    TYPE_CHECKING,
    Any,
    Final,
    Literal,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from numpy.typing import NDArray

from stickslip import __version__
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.protocol import Floats, Labels, Map1D, MapFamily
from stickslip.analysis.maps.protocol_nd import FamilyND, MapND
from stickslip.files import (
    checked_path,
    checked_suffix,
    columns_of,
    read_text,
    write_table,
    write_text,
)

if TYPE_CHECKING:
    import os
    from pathlib import Path

FORMAT: Final = "stickslip result"
VERSION: Final = 1  # raised when older programs would misread a file
KIND: Final = "is"  # key that tells what an object stands for
SUM: Final = "sha256"  # key of the checksum
MOST_BYTES: Final = 2**30  # of a file
MOST_TEXT: Final = 2**27  # characters of an array of texts, all as long as the longest
NOT_FINITE: Final = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}

# What a file may hold: class and the module of this package that it is in.
TYPES: Final[dict[str, str]] = {
    "Attractor": "analysis.attractors.attractor",
    "AttractorList": "analysis.attractors.attractor",
    "AttractorTable": "analysis.diagrams.diagram",
    "Bifurcation": "analysis.bifurcations.bifurcation",
    "BifurcationList": "analysis.bifurcations.bifurcation",
    "BifurcationProblem": "analysis.bifurcations.curves.curves",
    "Breakpoint": "analysis.branches.breakpoints",
    "BreakpointLine": "analysis.branches.along.breakpoint_lines",
    "BreakpointList": "analysis.branches.branches",
    "BreakpointProblem": "analysis.bifurcations.curves.breakpoint_curves",
    "Cascade": "analysis.bifurcations.bifurcation",
    "Collision": "analysis.bifurcations.conditions.conditions",
    "Connection": "analysis.bifurcations.conditions.conditions",
    "CriticalReading": "analysis.branches.along.tracked",
    "Crossing": "analysis.bifurcations.conditions.conditions",
    "Curve": "analysis.continuation.curve",
    "CurveEnd": "analysis.continuation.curve",
    "CurveEvent": "analysis.continuation.curve",
    "Cycle": "mechanics.cycle.cycle",
    "CycleList": "mechanics.cycle.limit_cycles",
    "CycleProblem": "mechanics.cycle.continuation",
    "Diagram": "analysis.diagrams.diagram",
    "EquilibriumProblem": "mechanics.cycle.along",
    "Event": "mechanics.flow.trajectory",
    "Flip": "analysis.bifurcations.conditions.conditions",
    "Fold": "analysis.bifurcations.conditions.conditions",
    "Gap": "mechanics.cycle.return_region",
    "JumpCrossing": "analysis.orbits.orbit",
    "LocalAttractor": "analysis.bifurcations.outcome",
    "LyapunovExponent": "analysis.attractors.lyapunov",
    "NearFold": "analysis.orbits.orbit",
    "NeutralFamily": "mechanics.cycle.neutral",
    "OrbitCurve": "analysis.diagrams.diagram",
    "OrbitCurveEnd": "analysis.diagrams.assemble",
    "OrbitList": "analysis.orbits.orbit",
    "OrbitListND": "analysis.orbits.orbits_nd",
    "OrbitProblem": "analysis.continuation.orbit_curve",
    "OrbitProblemND": "analysis.continuation.orbit_curve_nd",
    "Outcome": "analysis.bifurcations.outcome",
    "PeriodicOrbit": "analysis.orbits.orbit",
    "PeriodicOrbitND": "analysis.orbits.orbits_nd",
    "Reading": "analysis.bifurcations.conditions.conditions",
    "ReturnRegion": "mechanics.cycle.return_region",
    "TrackedDiscontinuity": "analysis.branches.along.tracked",
    "TrappingBall": "mechanics.cycle.trapping",
    "TurningPoint": "analysis.branches.along.tracked",
    "Unresolved": "analysis.branches.discontinuities",
    "UnresolvedChange": "analysis.bifurcations.bifurcation",
    "Unseen": "analysis.orbits.orbits_nd",
}

# Names that classes had in files of 0.1.0.
RENAMED: Final[dict[str, str]] = {
    "Border": "TrackedDiscontinuity",
    "BorderReading": "CriticalReading",
    "BreakpointLine": "BreakpointLine",
    "OrbitCurveEnd": "OrbitCurveEnd",
}


@dataclasses.dataclass(frozen=True)
class _Kind:
    """How values of a class are described, and made again."""

    cls: type | tuple[type, ...]
    describe: Callable[[Any], Mapping[str, Any]]
    rebuild: Callable[[dict[str, Any]], Any]


_kinds: dict[str, _Kind] = {}  # of maps
_parts: dict[str, _Kind] = {}  # of other things that results hold


def register_map(
    kind: str,
    cls: type,
    describe: Callable[[Any], Mapping[str, Any]],
    rebuild: Callable[[dict[str, Any]], Any],
) -> None:
    """Tell how maps of a class are written into files and made again.

    Parameters
    ----------
    kind : str
        The word for them in files.
    cls : type
    describe : callable
        ``describe(f)``: numbers, texts, lists and dicts by name; ValueError if there is
        something in the map that a file cannot hold.
    rebuild : callable
        ``rebuild(description)``: an equal map.
    """
    _kinds[kind] = _Kind(cls, describe, rebuild)


def register_part(
    kind: str,
    cls: type | tuple[type, ...],
    describe: Callable[[Any], Mapping[str, Any]],
    rebuild: Callable[[dict[str, Any]], Any],
) -> None:
    """Tell how things that results hold are written into files, as `register_map` does for maps.

    What cannot be described cannot be saved.
    """
    _parts[kind] = _Kind(cls, describe, rebuild)


def save(result: Any, path: str | os.PathLike[str]) -> None:
    """Write a result to a file.

    Parameters
    ----------
    result : branch, curve, list of bifurcations, diagram, orbit ...
        Or a tuple, list or dict of such.
    path : str or path
        Ends in ``.json``, or has no suffix: every digit, for `load`; or, of a result that has a
        ``table()``, in ``.csv``: the table. A file of that name is replaced; it is whole at any
        time.

    Raises
    ------
    ValueError
        It holds something that cannot be saved, or the name has another suffix.
    OSError
        The file cannot be written.
    """
    path = checked_path(path)
    has_table = not isinstance(result, type) and callable(getattr(result, "table", None))
    suffixes = ("", ".json", ".csv") if has_table else ("", ".json")
    if checked_suffix(path, suffixes) == ".csv":
        write_table(path, columns_of(result))
        return
    document = {
        "format": FORMAT,
        "version": VERSION,
        "program": __version__,
        "result": _maps_once(_written(result), {}),
    }
    write_text(path, _text({**document, SUM: _checksum(document)}) + "\n")


def _text(document: dict[str, Any]) -> str:
    return json.dumps(document, ensure_ascii=False, allow_nan=False)


def _checksum(document: dict[str, Any]) -> str:
    """Checksum of all but itself, of what is said and not of how it is laid out."""
    rest = {key: value for key, value in document.items() if key != SUM}
    return hashlib.sha256(_text(rest).encode(errors="surrogatepass")).hexdigest()


def load(path: str | os.PathLike[str], system: MapFamily | None = None) -> Any:
    """Read a result from a file that `save` has written.

    Parameters
    ----------
    path : str or path
    system : MapFamily, optional
        The map, for a result of one that no file can hold: a `PiecewiseMap`, or a model
        with a friction law of the user's own. Parameter values are taken from the file.

    Returns
    -------
    object
        Equal to what was saved, except that a map that the file does not hold and that is
        not given is None: then nothing can be solved anew.

    Raises
    ------
    ValueError
        The file is none of this program's, or of a newer version of it, or damaged; or
        ``system`` has other parameters than the map in the file.
    OSError
        The file cannot be read.
    """
    path = checked_path(path)
    document = _document(path)
    try:
        result = _Reader(system).value(document["result"], "result")
        if SUM in document and document[SUM] != _checksum(document):
            raise _DamagedError(f"its content does not fit its {SUM}, so it was changed.")
        return result
    except _DamagedError as reason:
        raise ValueError(f"{path} is damaged: {reason}") from reason
    except RecursionError:
        raise ValueError(f"{path} is damaged: it is nested too deeply.") from None


class _DamagedError(Exception):
    """The content of a file makes no sense."""


def _document(path: Path) -> dict[str, Any]:
    """Read a file and check that it is one of this program's, of a version known here."""
    text = read_text(path, limit=MOST_BYTES)
    try:
        document = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as reason:
        raise ValueError(f"{path} is not a {FORMAT}: {reason}") from reason
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ValueError(f"{path} is not a {FORMAT}, but some other JSON file.")
    version = document.get("version")
    if type(version) is not int or version < 1 or "result" not in document:
        raise ValueError(f"{path} is damaged: it says no version, or has no result.")
    if version > VERSION:
        raise ValueError(
            f"{path} was written by stickslip {document.get('program')!s:.40} in version "
            f"{version!s:.40} of the format; this is stickslip {__version__}, which reads up to "
            f"version {VERSION}. Update stickslip."
        )
    return document


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is no number of JSON")


# ------------------------------------------------------------------ writing


def _written(value: Any) -> Any:
    """Turn a value into what JSON knows; exactly what `_Reader` needs to undo it."""
    match value:
        case np.generic():
            return _written(value.item())
        case None | bool() | int() | str():
            return value
        case float():
            return value if math.isfinite(value) else {KIND: "float", "of": repr(value)}
        case tuple() if not _is_listed(value):
            return {KIND: "tuple", "of": [_written(item) for item in value]}
        case list():
            return [_written(item) for item in value]
        case dict():
            return _written_dict(value)
        case np.ndarray():
            return _written_array(value)
    if isinstance(value, WindowMap):
        return {KIND: "window", "of": _written(value.f), "window": list(value.window)}
    if _is_listed(value):
        return {
            KIND: type(value).__name__,
            **{name: _written(getattr(value, name)) for name in _field_names(value)},
        }
    if isinstance(value, Map1D | MapND):
        return _written_map(value)
    for name, kind in _parts.items():
        if isinstance(value, kind.cls):
            return {KIND: "part", "kind": name, "description": _written(dict(kind.describe(value)))}
    raise ValueError(f"{value!r} cannot be saved: a {type(value).__name__} is no result.")


def _is_listed(value: Any) -> bool:
    """Whether `TYPES` names the class of a value."""
    return TYPES.get(type(value).__name__) == type(value).__module__.partition(".")[2]


def _field_names(value: Any) -> tuple[str, ...]:
    """Names of what a dataclass or a named tuple is made of."""
    if isinstance(value, tuple):
        return tuple(getattr(value, "_fields", ()))
    return tuple(item.name for item in dataclasses.fields(value) if item.init)


def _written_dict(value: dict[Any, Any]) -> dict[str, Any]:
    if KIND not in value and all(isinstance(key, str) for key in value):
        return {key: _written(item) for key, item in value.items()}
    pairs = [[_written(key), _written(item)] for key, item in value.items()]
    return {KIND: "dict", "of": pairs}


def _written_array(value: np.ndarray[Any, Any]) -> dict[str, Any]:
    kind = value.dtype.kind
    if kind == "c":  # real and imaginary parts beside each other
        pairs = np.stack([value.real, value.imag], axis=-1)
        return {**_written_array(pairs), "dtype": "complex128"}
    if kind not in "fiubU":
        raise ValueError(f"an array of {value.dtype} cannot be saved.")
    items = value.ravel().tolist()
    if kind == "f":
        items = [x if math.isfinite(x) else repr(x) for x in items]
    dtype = "str" if kind == "U" else value.dtype.name
    return {KIND: "array", "dtype": dtype, "shape": list(value.shape), "of": items}


def _written_map(f: Map1D | MapND) -> dict[str, Any]:
    """Describe a map, as far as a file can hold it."""
    written: dict[str, Any] = {KIND: "map", "text": repr(f)}
    if isinstance(f, MapFamily | FamilyND):
        written["parameters"] = _written(dict(f.parameters))
    for name, kind in _kinds.items():
        if isinstance(f, kind.cls):
            try:
                return {**written, "kind": name, "description": _written(dict(kind.describe(f)))}
            except ValueError as reason:
                return {**written, "kind": None, "why": str(reason)}
    return {**written, "kind": None, "why": "Python functions cannot be saved."}


def _maps_once(written: Any, known: dict[str, int]) -> Any:
    """Let a map that comes again refer to where it came first, by number."""
    if isinstance(written, list):
        return [_maps_once(item, known) for item in written]
    if not isinstance(written, dict):
        return written
    if written.get(KIND) != "map":
        return {key: _maps_once(item, known) for key, item in written.items()}
    text = json.dumps(written, sort_keys=True)
    if text in known:
        return {KIND: "map", "number": known[text]}
    known[text] = len(known)
    return written


# ------------------------------------------------------------------ reading


LONGEST: Final = 300  # characters of what is told about damage
BROKEN: Final = (LookupError, TypeError, AttributeError, ValueError, ArithmeticError, MemoryError)


class _Reader:
    """Undoes `_written` and `_maps_once`."""

    def __init__(self, system: MapFamily | None) -> None:
        self.system = system
        self.maps: list[Any] = []

    def value(self, written: Any, place: str) -> Any:
        if isinstance(written, list):
            return self._items(written, place)
        if not isinstance(written, dict):
            return written
        if KIND not in written:
            return {key: self.value(item, f"{place}.{key}") for key, item in written.items()}
        try:
            return self._object(written[KIND], written, place)
        except BROKEN as reason:
            if isinstance(reason, _SystemError):
                raise
            told = f"{place} ({reprlib.repr(written[KIND])}): {type(reason).__name__}, {reason}"
            raise _DamagedError(told[:LONGEST]) from reason

    def _items(self, written: list[Any], place: str) -> list[Any]:
        return [self.value(item, f"{place}[{number}]") for number, item in enumerate(written)]

    def _object(self, kind: str, written: dict[str, Any], place: str) -> Any:
        match kind:
            case "float":
                return NOT_FINITE[written["of"]]
            case "tuple":
                return tuple(self._items(written["of"], place))
            case "dict":
                return dict(self._items(pair, place) for pair in written["of"])
            case "array":
                return self._array(written)
            case "window":
                inner = self.value(written["of"], place)
                low, high = written["window"]
                return None if inner is None else WindowMap(inner, (low, high))
            case "map":
                return self._map(written, place)
            case "part":
                return _parts[written["kind"]].rebuild(self.value(written["description"], place))
        kind = RENAMED.get(kind, kind)
        hints = _hints(kind)
        fields = {
            name: self.value(item, f"{place}.{name}")
            for name, item in written.items()
            if name != KIND
        }
        for name, value in fields.items():
            if name in hints and not _fits(value, hints[name]):
                given = f"{reprlib.repr(value)} ({type(value).__name__})"
                raise _DamagedError(f"{place}.{name} = {given} is no {_named(hints[name])}.")
        return _class(kind)(**fields)

    def _array(self, written: dict[str, Any]) -> NDArray[Any]:
        dtype, items = written["dtype"], [NOT_FINITE.get(x, x) for x in written["of"]]
        if dtype == "complex128":
            pairs = np.array(items, dtype=np.float64).reshape(written["shape"])
            return np.asarray(pairs[..., 0] + 1j * pairs[..., 1])
        if dtype == "str":
            if len(items) * max(map(len, items), default=0) > MOST_TEXT:
                raise ValueError("the texts are too long")
        elif not isinstance(dtype, str) or np.dtype(dtype).kind not in "fiub":
            raise ValueError(f"{dtype!r} is no type of numbers")
        return np.array(items, dtype=dtype).reshape(written["shape"])

    def _map(self, written: dict[str, Any], place: str) -> Any:
        if "number" in written:
            return self.maps[written["number"]]
        self.maps.append(self._new_map(written, place))
        return self.maps[-1]

    def _new_map(self, written: dict[str, Any], place: str) -> Any:
        if self.system is not None:
            return self._given(self.value(written.get("parameters", {}), place))
        kind = written["kind"]
        if kind is None:
            return None
        if kind not in _kinds:
            raise _SystemError(
                f"the result is one of {written['text']}, and how to make that is not known "
                f"here (kind {kind!r}; known: {', '.join(_kinds) or 'none'}). Give system=."
            )
        return _kinds[kind].rebuild(self.value(written["description"], place))

    def _given(self, parameters: dict[str, float]) -> Any:
        """Use the caller's map at the parameter values of the file."""
        system: Any = getattr(self.system, "whole", self.system)  # the file knows the window
        own = getattr(system, "parameters", {})
        if set(own) != set(parameters):
            raise _SystemError(
                f"system has the parameters {', '.join(own) or 'none'}; the result is one of a "
                f"system with {', '.join(parameters) or 'none'}."
            )
        return system.replace(**parameters) if parameters else system


class _SystemError(ValueError):
    """The map given is not that of the file, or one is missing."""


# ------------------------------------------------------------------ types of fields


def _class(kind: str) -> type:
    """Class that a file names; KeyError if it may hold none of that name."""
    cls: type = getattr(importlib.import_module(f"stickslip.{TYPES[kind]}"), kind)
    return cls


@cache
def _hints(kind: str) -> dict[str, Any]:
    """Return what the fields of a class may hold, by its annotations."""
    # Modules import much of what these name for the type checker only.
    models = importlib.import_module("stickslip.mechanics.model.values")
    conditions = importlib.import_module("stickslip.analysis.bifurcations.conditions.conditions")
    borders = importlib.import_module("stickslip.analysis.branches.along.tracked")
    breakpoints = importlib.import_module("stickslip.analysis.branches.breakpoints")
    known: dict[str, Any] = {name: _class(name) for name in TYPES}
    known |= {"np": np, "NDArray": NDArray, "Floats": Floats, "Labels": Labels}
    known |= {"MapFamily": MapFamily, "FamilyND": FamilyND, "Kind": breakpoints.Kind}
    known |= {
        "Model": models.Model,
        "Condition": conditions.Condition,
        "Critical": borders.Critical,
    }
    return get_type_hints(_class(kind), localns=known)


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is what an annotation says; a whole number is a float."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin in (Union, UnionType):
        return any(_fits(value, each) for each in inner)
    if origin is Literal:
        return value in inner
    if origin is np.ndarray:
        kind = np.dtype(get_args(inner[1])[0]).kind
        return isinstance(value, np.ndarray) and value.dtype.kind == kind
    if origin is dict:
        return isinstance(value, dict) and all(
            _fits(each, kind)
            for item in value.items()
            for each, kind in zip(item, inner, strict=True)
        )
    if origin is tuple:
        if not isinstance(value, tuple):
            return False
        inner = inner[:1] * len(value) if inner[1:] == (...,) else inner
        return len(value) == len(inner) and all(map(_fits, value, inner))
    if hint in (int, float):
        return isinstance(value, hint | int) and not isinstance(value, bool)
    return isinstance(value, hint)


def _named(hint: Any) -> str:
    return hint.__name__ if isinstance(hint, type) else str(hint).replace("typing.", "")
