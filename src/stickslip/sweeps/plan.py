"""Plans of sweeps as TOML files, checked key by key before anything is computed."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

import msgspec

from stickslip.checks import one_of, shown, whole_number
from stickslip.errors import StoreRefused
from stickslip.files import checked_path
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.friction.values import within
from stickslip.mechanics.model.file import model_of_values, read_model, read_toml
from stickslip.sweeps.identity import import_function
from stickslip.sweeps.job import LARGEST_SEED, axis
from stickslip.sweeps.observables import OBSERVABLES, Function, as_observables
from stickslip.sweeps.sweep import sweep
from stickslip.sweeps.systems import as_system
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from os import PathLike

    import xarray

    from stickslip.sweeps.job import Observable

T = TypeVar("T", bound=msgspec.Struct)
C = TypeVar("C")


ENDS: Final = {"lo": "from", "hi": "to"}
"""Arguments of `axis`, and their keys."""

WORDS: Final = {
    "int": "a whole number",
    "float": "a number",
    "str": "text",
    "array": "a list",
    "object": "a table",
}
"""What may be needed, by the name that a refusal has for it."""


class _Range(msgspec.Struct, frozen=True, forbid_unknown_fields=True, rename=ENDS):
    """An axis as a range."""

    lo: float
    hi: float
    n: int
    scale: Any = "linear"


class _Values(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An axis as a list."""

    values: list[float]


AXIS_KEYS: Final = {
    field.encode_name for kind in (_Range, _Values) for field in msgspec.structs.fields(kind)
}


class _Engine(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Settings of the event map."""

    rtol: float | None = None
    max_events: int | None = None
    max_time: float | None = None
    engine: str | None = None


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The keys of a plan; its tables are read further."""

    store: str
    axes: dict[str, Any]
    observables: list[Any]
    model: str | dict[str, Any] | None = None
    map: str | None = None
    engine: dict[str, Any] | None = None
    chunks: dict[str, Any] | None = None
    storage_options: dict[str, Any] | None = None
    seed: int = 0
    d: float | None = None


class Plan(msgspec.Struct, frozen=True):
    """A sweep that was read from a file."""

    path: Path
    store: str  # path or URL
    # of `stickslip.sweep`, apart from the store and what belongs to the machine
    arguments: dict[str, Any]

    def run(self, **more: Any) -> xarray.Dataset:
        """Run the sweep; further arguments as of `stickslip.sweep`."""
        try:
            return sweep(**self.arguments, **{"store": self.store, **more})
        except StoreRefused:
            raise
        except ValueError as error:
            told = re.sub(r"\baxis '([^']+)'", r"axes.\1", str(error))
            raise ValueError(f"{self.path}: {told}") from error


def read_plan(path: str | PathLike[str]) -> Plan:
    """Read a plan; paths in it are relative to its folder. Errors name file and key."""
    path = checked_path(path)
    table = read_toml(path)
    with within(f"{path}: "):
        file = _read(table, _File, "")
        arguments: dict[str, Any] = {
            "system": _system(file, path.parent),
            "axes": {name: _axis(name, given) for name, given in _dotted(file.axes).items()},
            "observables": as_observables(
                [_observable(*item) for item in enumerate(file.observables)]
            ),
            "rng": whole_number("seed", file.seed, 0, at_most=LARGEST_SEED - 1),
            "d": file.d,
            "chunks": file.chunks
            and {
                name: whole_number(f"chunks.{name}", size)
                for name, size in _dotted(file.chunks).items()
            },
            "storage_options": file.storage_options,
        }
    local = file.store and "://" not in file.store and not file.store.startswith("memory:")
    return Plan(path, str(path.parent / file.store) if local else file.store, arguments)


def _read(table: Any, kind: type[T], place: str) -> T:
    """Turn a table into one of the structures above; messages begin with the place of the key."""
    if not isinstance(table, dict):
        raise ValueError(
            f"{place.rstrip('.')} = {shown(table)}: a table is needed, {{ key = value }}."
        )
    keys = msgspec.structs.fields(kind)
    known = [field.encode_name for field in keys]
    for key in table:
        if key not in known:
            raise ValueError(f"{place}{key}: unknown key. {did_you_mean(key, known)}")
    for field in keys:
        if field.required and field.encode_name not in table:
            raise ValueError(f"{place}{field.encode_name}: missing.")
    return _converted(table, kind, place.rstrip("."))


def _converted(given: Any, kind: type[C], place: str) -> C:
    """Turn what a file holds into a kind; messages name the key, its value and what is needed."""
    try:
        return msgspec.convert(given, kind)
    except msgspec.ValidationError as error:
        told, _, path = str(error).rstrip("`").partition(" - at `$")
        for name, number in re.findall(r"\.(\w+)|\[(\d+)\]", path):
            given = given[name or int(number)]
        needed = re.findall(r"\w+", told.partition("`")[2].partition("`")[0])
        words = " or ".join(WORDS[each] for each in needed if each in WORDS)
        key = f"{place}{path}".removeprefix(".")
        why = f"{words} is needed" if words else told.lower()  # a number out of range
        raise ValueError(f"{key} = {shown(given)}: {why}.") from None


def _system(file: _File, folder: Path) -> Any:
    if (file.model is None) == (file.map is None):
        raise ValueError("model, map: exactly one of them is needed.")
    if file.map is not None:
        if file.engine is not None:
            raise ValueError("engine: settings of a model's event map, beside a map of one's own.")
        with within("map: "):
            found = import_function(file.map)
        try:
            as_system(found)
        except ValueError as error:
            told = str(error).removeprefix("system = ")
            raise ValueError(f"map = {shown(file.map)}: {told}") from error
        return found
    if isinstance(file.model, str):
        with within("model: "):
            model = read_model(folder / file.model)
    else:
        with within("[model] "):
            model = model_of_values(file.model or {})
    if file.engine is None:
        return model
    settings = msgspec.to_builtins(_read(file.engine, _Engine, "engine."))
    with within("engine: "):
        return event_map(model, **settings)


def _dotted(table: dict[str, Any]) -> dict[str, Any]:
    """Join names that TOML reads as tables in tables, as forcing.frequency without quotation."""
    found: dict[str, Any] = {}
    for name, given in table.items():
        if isinstance(given, dict) and given and not AXIS_KEYS & given.keys():
            found |= {f"{name}.{inner}": value for inner, value in _dotted(given).items()}
        else:
            found[name] = given
    return found


def _axis(name: str, given: Any) -> Any:
    if isinstance(given, list):
        return _converted(given, list[float], f"axes.{name}")
    place = f"axes.{name}."
    if isinstance(given, dict) and "values" in given:
        return _read(given, _Values, place).values
    if not isinstance(given, dict):
        raise ValueError(
            f"axes.{name} = {shown(given)}: a list of values is needed, or a table "
            "{ from = ..., to = ..., n = ... }."
        )
    found = _read(given, _Range, place)
    try:
        return axis(found.lo, found.hi, found.n, found.scale)
    except ValueError as error:
        told = re.sub(r"\b(?:lo|hi)\b(?!.*')", lambda end: ENDS[end[0]], str(error))
        raise ValueError(f"axes.{name}: {told}") from error


def _observable(number: int, given: Any) -> Observable | str:
    """Read an observable: a name, or a table with its name and settings."""
    if isinstance(given, str):
        return given
    place = f"observables[{number}]"
    if not isinstance(given, dict) or "name" not in given:
        raise ValueError(f"{place}: a name, or a table with name and settings, is needed.")
    settings = dict(given)
    name = settings.pop("name")
    one_of(f"{place}.name", name, OBSERVABLES)
    known = [field.name for field in fields(OBSERVABLES[name])]
    if name == Function.name and "function" not in settings:
        raise ValueError(f"{place}.function: missing.")
    for key in settings:
        if key not in known:
            raise ValueError(f"{place}.{key}: unknown key. {did_you_mean(key, known)}")
    try:
        return OBSERVABLES[name](**settings)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{place}: {error}") from error
