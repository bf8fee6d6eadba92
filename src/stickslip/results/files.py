"""Results in files: JSON with a version, every float exact, written whole or not at all.

A result is written field by field, by the names of registered classes (`parts`). Fields are
checked when they are read, by the annotations of their classes, and the whole by a checksum.
Maps and models are written by descriptions that their own modules supply (`register_map`,
`register_part`). A map without one, such as a Python function, is left out, and `load` is given
it again.
"""

from __future__ import annotations

import ast
import dataclasses
import hashlib
import importlib
import inspect
import json
import math
import reprlib
from collections.abc import Callable, Mapping
from contextlib import suppress
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
from stickslip.checks import shown
from stickslip.files import checked_path, checked_suffix, read_text, write_text
from stickslip.results.parts import (
    class_named,
    field_names,
    import_public,
    is_registered,
    registered,
)

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator
    from pathlib import Path

FORMAT: Final = "stickslip result"
VERSION: Final = 2  # raised when older programs would misread a file
KIND: Final = "is"  # key that tells what an object stands for
SUM: Final = "sha256"  # key of the checksum
MOST_BYTES: Final = 2**30  # of a file
MOST_TEXT: Final = 2**27  # characters of an array of texts, all as long as the longest
READERS: Final = {".csv": "pandas.read_csv", ".nc": "xarray.load_dataset"}
AGAIN: Final = "Compute the result again and save it, or load the file with that stickslip."
NOT_FINITE: Final = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


@dataclasses.dataclass(frozen=True)
class _Kind:
    """How values of a class are described, and made again."""

    cls: type | tuple[type, ...]
    describe: Callable[[Any], Mapping[str, Any]]
    rebuild: Callable[[dict[str, Any]], Any]


_maps: dict[str, _Kind] = {}  # of maps
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
    _maps[kind] = _Kind(cls, describe, rebuild)


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


_documents: dict[str, Callable[[dict[str, Any]], Any]] = {}  # of other programs, by schema


def register_document(schema: str, rebuild: Callable[[dict[str, Any]], Any]) -> None:
    """Tell how a result is made again that is written in a format of its own."""
    _documents[schema] = rebuild


def save(result: Any, path: str | os.PathLike[str]) -> None:
    """Write a result to a file.

    Parameters
    ----------
    result : branch, curve, list of bifurcations, diagram, orbit ...
        Or a tuple, list or dict of such.
    path : str or path
        Ends in ``.json``, or has no suffix. A file of that name is replaced; it is whole at any
        time.

    Raises
    ------
    ValueError
        It holds something that cannot be saved, or the name has another suffix.
    OSError
        The file cannot be written.
    """
    path = checked_path(path)
    checked_suffix(path, ("", ".json"))
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


def load(path: str | os.PathLike[str], system: Any = None) -> Any:
    """Read a result from a file that the ``save`` of a result has written.

    Parameters
    ----------
    path : str or path
    system : model or map, optional
        What the result is one of, where no file can hold that: a `PiecewiseMap` or a friction law
        by a Python function. Parameter values are taken from the file.

    Returns
    -------
    object
        Equal to what was saved. A map that the file does not hold and that is not given
        is None: the numbers are there, but nothing can be solved anew.

    Raises
    ------
    ValueError
        The file is none of this program's, of another version of it, or damaged; or ``system``
        has other parameters than that of the file.
    OSError
        The file cannot be read.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import stickslip as ss
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "breakpoints.json"
    >>> ss.breakpoints(ss.examples.coulomb()).save(file)
    >>> len(ss.load(file))
    8
    """
    is_class = isinstance(system, type)
    if not is_class and callable(as_map := getattr(system, "as_map", None)):
        system = as_map()
    if is_class or (system is not None and not callable(getattr(system, "evaluate", None))):
        raise ValueError(
            f"system = {shown(system)} is neither a map nor a model that has one. Take "
            "ss.event_map(model), ss.PiecewiseMap(...) or a model such as ss.TwoBlock(...)."
        )
    path = checked_path(path)
    document = _document(path)
    try:
        if rebuild := _documents.get(document.get("schema", "")):
            return _rebuilt(rebuild, document)
        result = _Reader(system).value(document["result"], "result")
        if SUM in document and document[SUM] != _checksum(document):
            raise _DamagedError(f"its content does not fit its {SUM}, so it was changed.")
        return result
    except _DamagedError as reason:
        raise ValueError(f"{path} {_state(document)}: {reason}") from reason
    except RecursionError:
        raise ValueError(f"{path} is damaged: it is nested too deeply.") from None


def _state(document: dict[str, Any]) -> str:
    """Say what is wrong with a file that does not hold what this program writes."""
    with suppress(RecursionError):
        if document.get(SUM) == _checksum(document):
            program = f"{document.get('program')!s:.40}; this is {__version__}"
            return f"is whole, but of another state of stickslip ({program}). {AGAIN} There"
    return "is damaged"


def _rebuilt(rebuild: Callable[[dict[str, Any]], Any], document: dict[str, Any]) -> Any:
    try:
        return rebuild(document)
    except Exception as reason:
        raise _DamagedError(f"{reason}"[:LONGEST]) from reason


class _DamagedError(Exception):
    """The content of a file makes no sense."""


def _document(path: Path) -> dict[str, Any]:
    """Read a file and check that it is one of this program's, of a version known here."""
    if path.suffix in READERS:
        raise ValueError(
            f"{path} is a table or NetCDF, which {READERS[path.suffix]} reads; load reads the JSON "
            "files that save writes."
        )
    text = read_text(path, limit=MOST_BYTES)
    try:
        document = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as reason:
        raise ValueError(f"{path} is not a {FORMAT}: {reason}") from reason
    if isinstance(document, dict) and isinstance(schema := document.get("schema"), str):
        if schema not in _documents:
            import_public()
        if schema in _documents:
            return document
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ValueError(f"{path} is not a {FORMAT}, but some other JSON file.")
    version = document.get("version")
    if type(version) is not int or version < 1 or "result" not in document:
        raise ValueError(f"{path} is damaged: it says no version, or has no result.")
    if version != VERSION:
        raise ValueError(
            f"{path} was written by stickslip {document.get('program')!s:.40} in version "
            f"{version!s:.40} of the format; this is stickslip {__version__}, which reads "
            f"version {VERSION}. {'Update stickslip.' if version > VERSION else AGAIN}"
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
        case tuple() if not is_registered(value):
            return {KIND: "tuple", "of": [_written(item) for item in value]}
        case list():
            return [_written(item) for item in value]
        case dict():
            return _written_dict(value)
        case np.ndarray():
            return _written_array(value)
    if is_registered(value):
        return {
            KIND: type(value).__name__,
            **{name: _written(_field(value, name)) for name in field_names(value)},
        }
    if found := _kind_of(_parts, value):
        name, kind = found
        return {KIND: "part", "kind": name, "description": _written(dict(kind.describe(value)))}
    if callable(getattr(value, "evaluate", None)):
        return _written_map(value)
    raise ValueError(f"{value!r} cannot be saved: a {type(value).__name__} is no result.")


def _field(value: Any, name: str) -> Any:
    """Return a field; a single number as an array, if the class says that."""
    field = getattr(value, name)
    if not isinstance(field, np.generic):
        return field
    cls: Any = type(value)
    of_array: Any = get_origin(_hints(cls)[name])
    return np.asarray(field) if of_array is np.ndarray else field


def _kind_of(kinds: dict[str, _Kind], value: Any) -> tuple[str, _Kind] | None:
    """How values of a class are described; None if nothing of the kind is registered."""

    def known() -> Iterator[tuple[str, _Kind]]:
        return ((name, kind) for name, kind in kinds.items() if isinstance(value, kind.cls))

    if not any(known()) and type(value).__module__.startswith("stickslip."):
        import_public()
    return next(known(), None)


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


def _written_map(f: Any) -> dict[str, Any]:
    """Describe a map, as far as a file can hold it."""
    written: dict[str, Any] = {KIND: "map", "text": repr(f), "kind": None}
    if isinstance(parameters := getattr(f, "parameters", None), Mapping):
        written["parameters"] = _written(dict(parameters))
    if (found := _kind_of(_maps, f)) is None:
        return {**written, "why": "Python functions cannot be saved."}
    name, kind = found
    try:
        return {**written, "kind": name, "description": _written(dict(kind.describe(f)))}
    except ValueError as reason:
        return {**written, "why": str(reason)}


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

    def __init__(self, system: Any) -> None:
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
            case "map":
                return self._map(written, place)
            case "part":
                part = _known(_parts, written["kind"])[written["kind"]]
                return part.rebuild(self.value(written["description"], place))
        try:
            cls = class_named(kind)
        except KeyError:
            told = f"{place} is a {reprlib.repr(kind)}, of which nothing is known here."
            raise _DamagedError(told[:LONGEST]) from None
        hints = _hints(cls)
        fields = {
            name: self.value(item, f"{place}.{name}")
            for name, item in written.items()
            if name != KIND
        }
        for name, value in fields.items():
            is_missing = value is None and _is_map(written[name])  # nobody gave it again
            if name in hints and not is_missing and not _fits(value, hints[name]):
                given = f"{reprlib.repr(value)} ({type(value).__name__})"
                raise _DamagedError(f"{place}.{name} = {given} is no {_named(hints[name])}.")
        known = inspect.signature(cls).parameters
        needed = [name for name, each in known.items() if each.default is inspect.Parameter.empty]
        if off := [*(set(needed) - {*fields}), *({*fields} - {*known})]:
            names = ", ".join(sorted(off))
            told = f"{place} ({kind}) lacks these fields, or has them besides: {names}."
            raise _DamagedError(told[:LONGEST])
        return cls(**fields)

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
        if kind not in _known(_maps, kind):
            raise _SystemError(
                f"the result is one of {written['text']}, and how to make that is not known "
                f"here (kind {kind!r}; known: {', '.join(_maps) or 'none'}). Give system=."
            )
        return _maps[kind].rebuild(self.value(written["description"], place))

    def _given(self, parameters: dict[str, float]) -> Any:
        """Use the caller's map at the parameter values of the file."""
        system: Any = self.system
        while found := _kind_of(_parts, system):  # the file knows windows and powers
            system = found[1].describe(system)["of"]
        own = getattr(system, "parameters", {})
        if set(own) != set(parameters):
            raise _SystemError(
                f"system has the parameters {', '.join(own) or 'none'}; the result is one of a "
                f"system with {', '.join(parameters) or 'none'}."
            )
        return system.replace(**parameters) if parameters else system


def _is_map(written: Any) -> bool:
    return isinstance(written, dict) and written.get(KIND) == "map"


class _SystemError(ValueError):
    """The map given is not that of the file, or one is missing."""


# ------------------------------------------------------------------ types of fields


def _known(kinds: dict[str, _Kind], kind: str) -> dict[str, _Kind]:
    """Return the kinds, with those of all public modules if one is missing."""
    if kind not in kinds:
        import_public()
    return kinds


@cache
def _hints(cls: Any) -> dict[str, Any]:
    """Return what the fields of a class may hold, by its annotations."""
    return get_type_hints(cls, localns=_TypeChecked(*(base.__module__ for base in cls.__mro__)))


class _TypeChecked(dict[str, Any]):
    """Names in annotations of modules, which import much of it for the type checker only."""

    def __init__(self, *modules: str) -> None:
        self.modules = [module for module in modules if module.startswith("stickslip.")]

    def __missing__(self, name: str) -> Any:
        for module in self.modules:
            if (found := _meaning(module, name)) is not None:
                return found
        return registered()[name]


@cache
def _meaning(module: str, name: str) -> Any:
    """Return what the type checker takes a name of a module for; None if it has no such name."""
    loaded = importlib.import_module(module)
    if hasattr(loaded, name):
        return getattr(loaded, name)
    for node in ast.parse(inspect.getsource(loaded)).body:
        if not isinstance(node, ast.If) or ast.unparse(node.test) != "TYPE_CHECKING":
            continue
        for line in node.body:
            if isinstance(line, ast.Import | ast.ImportFrom):
                for item in line.names:
                    if name != (item.asname or item.name):
                        continue
                    if isinstance(line, ast.Import):
                        return importlib.import_module(item.name)
                    return _meaning(str(line.module), item.name)
            elif isinstance(line, ast.Assign) and ast.unparse(line.targets[0]) == name:
                return eval(ast.unparse(line.value), vars(loaded), _TypeChecked(module))
    return None


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is what an annotation says; a whole number is a float."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin in (Union, UnionType):
        return any(_fits(value, each) for each in inner)
    if origin is Literal:
        return value in inner
    if origin is Callable:
        return callable(value)
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
