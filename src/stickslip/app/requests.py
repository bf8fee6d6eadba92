"""What the page may ask, every number bounded, nothing unknown accepted; how answers travel to it.

A request is one struct a view; an answer is parts, each a small JSON header and arrays, back to
back.
"""

from __future__ import annotations

import dis
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Final, Literal, TypeAlias, TypeVar, cast

import msgspec
import numpy as np
from msgspec import Meta, Raw, Struct, inspect
from numpy.typing import NDArray

from stickslip.app.words import of_page
from stickslip.checks import finite_number, whole_number
from stickslip.files import text_of
from stickslip.mechanics.friction import UserLaw
from stickslip.mechanics.friction.formula import TracedFormula
from stickslip.mechanics.model.arguments import Model
from stickslip.mechanics.model.file import model_of_values, toml_of
from stickslip.mechanics.model.plant import solved
from stickslip.mechanics.model.structure import Structure
from stickslip.vocabulary import did_you_mean

T = TypeVar("T")

ALIGNED: Final = 8  # bytes: what the page's typed arrays need
DTYPES: Final = {"f8": "<f8", "f4": "<f4", "i4": "<i4", "u1": "|u1"}
FAR: Final = 10.0  # times beyond a slider's end: what is stiffer takes the server minutes
BLOCK: Final = re.compile(r"(_\d+)+$")
MOST_BLOCKS: Final = 20
MOST_KNOTS: Final = 200  # of a tabulated law
MOST_OPERATIONS: Final = 40  # of a formula: the compiler takes a second for each
RAISE: Final = dis.opmap["RAISE_VARARGS"]
PLACE: Final = re.compile(r" - at `\$\.?([^`]*)`$")
KINDS: Final = {"float": "a number", "int": "a whole number", "str": "a text", "array": "a list"}
EXPECTED: Final = re.compile(rf"^Expected `({'|'.join(KINDS)})`")
BOUND: Final = re.compile(r"^Expected `(?:float|int)` [<>]")
NAMED: Final = re.compile(r"(?:^(?:contact|block|force) (\d+): |^|[\]:] |\.)(\w+) = ")
SPRING: Final = re.compile(r"(?<=contact )(\d+: )(?=stiffness = )")


def slider(
    default: float, low: float, high: float, *, step: float = 0.001, scale: str = "linear"
) -> dict[str, Any]:
    """Describe a slider; typed values may lie some way beyond its ends."""
    return {"default": default, "min": low, "max": high, "step": step, "scale": scale}


SLIDERS: Final = {
    "alpha": slider(1.2, 0.0, 3.0),
    "beta": slider(1.3, 0.5, 2.5),
    "V": slider(0.0366, 0.001, 1.0, step=0.0001, scale="log"),
    "damping": slider(0.0, 0.0, 1.0),
    "stiffness": slider(1.0, -10.0, 10.0, step=0.01),
    "static": slider(1.0, 0.2, 3.0, step=0.01),
    "support": slider(1.0, 0.1, 10.0, step=0.01, scale="log"),
    "mass": slider(1.0, 0.1, 10.0, step=0.01, scale="log"),
    "amplitude": slider(0.5, 0.0, 3.0, step=0.01),
    "frequency": slider(1.0, 0.05, 10.0, step=0.01, scale="log"),
    "phase": slider(0.0, -3.1416, 3.1416, step=0.01),
    "mu": slider(0.22, 0.0, 1.0),
    "gamma": slider(3.0, 0.0, 10.0, step=0.01),
    "delta": slider(0.0, 0.0, 1.0),
    "eta": slider(0.0, 0.0, 2.0, step=0.01),
    "viscous": slider(0.0, 0.0, 1.0),
    "speed": slider(0.1, 0.01, 10.0, step=0.001, scale="log"),
}
"""Where the sliders start and end: what is worth looking at, not what is allowed."""


def reach(name: str) -> tuple[float, float] | None:
    """Least and largest value but 0 that the explorer computes with, of what has a slider."""
    slider = SLIDERS.get(BLOCK.sub("", name).rpartition(".")[2])
    if slider is None:
        return None
    low, high = slider["min"], slider["max"]
    if name.startswith("damping_"):  # of a matrix, whose other entries are below 0
        low = -high
    return low / FAR if low > 0 else low * FAR, high * FAR


def refuse_far(values: Mapping[str, float]) -> None:
    """Refuse numbers that would keep the server busy for long; none of them is 0."""
    for name, value in values.items():
        if value != 0.0 and (ends := reach(name)):
            low, high = ends
            finite_number(
                name,
                value,
                at_least=low,
                at_most=high,
                why="The explorer computes no models far beyond its sliders.",
                remedy="The library takes them.",
            )


FASTEST: Final = 1000.0  # rate of change: a motion takes some steps for each unit of its inverse


def fastest(model: Model) -> float:
    """Largest rate of a model that slips freely, and of what forces it."""
    plant = model.plant
    n = plant.n_bodies
    mass = plant.mass[:n] if plant.mass.ndim == 1 else plant.mass[:n, :n]
    flow = -solved(mass, plant.damping[:n, :n])
    if plant.n_positions:
        back = -solved(mass, plant.stiffness[:n, :n])
        flow = np.block([[np.zeros((n, n)), np.eye(n)], [back, flow]])
    rates = np.concatenate([np.abs(np.linalg.eigvals(flow)), plant.frequency])
    return float(rates.max())


def refuse_busy(model: Model) -> None:
    """Refuse a model that would keep the server busy for long."""
    if not isinstance(model, Structure):
        refuse_far(model.parameters)
    elif (rate := fastest(model)) > FASTEST:
        raise ValueError(
            f"the model's fastest motion has the rate {rate:.6g}; the "
            f"explorer follows rates up to {FASTEST:g}. The library takes them."
        )


Interval: TypeAlias = tuple[float, float]
Coordinate: TypeAlias = Annotated[float, Meta(ge=-1000, le=1000)]
Numbers: TypeAlias = Annotated[tuple[Coordinate, ...], Meta(max_length=MOST_BLOCKS)]
Word: TypeAlias = Annotated[str, Meta(max_length=40)]
Period: TypeAlias = Annotated[int, Meta(ge=1, le=8)]


class BadRequestError(ValueError):
    """A request that is not allowed, told in the words of the page."""

    # `field` is the dotted path of the field that is wrong, such as ``model.mu``; empty if all is.

    def __init__(self, text: str, field: str = "") -> None:
        super().__init__(of_page(text))
        self.field = field


def is_ours(error: BaseException) -> bool:
    """Whether the package itself raised an error: those of numpy and Python are not for users."""
    last = error.__traceback__
    while last is not None and last.tb_next is not None:
        last = last.tb_next
    if last is None:
        return False
    raised = last.tb_frame.f_code.co_code[last.tb_lasti] == RAISE
    return raised and last.tb_frame.f_globals["__name__"].startswith("stickslip.")


class Request(Struct, frozen=True, forbid_unknown_fields=True):
    """What every view needs: the model, as the table of a model file."""

    model: dict[str, Any]


class Section(Struct, frozen=True, forbid_unknown_fields=True):
    """Settings of a return map, as `stickslip.return_map` takes them."""

    contact: Annotated[int, Meta(ge=0, le=MOST_BLOCKS - 1)] = 0
    event: Literal["release", "landing"] = "release"
    direction: Literal["backward", "forward"] | None = None
    coordinates: Annotated[tuple[Word, ...], Meta(max_length=2 * MOST_BLOCKS)] | None = None
    domain: Annotated[tuple[Interval, ...], Meta(max_length=2 * MOST_BLOCKS)] | None = None


class OfMap(Request, frozen=True, kw_only=True):
    """What views of a map need: where it is taken, of models without global stick."""

    section: Section | None = None


class Returns(OfMap, frozen=True):
    """Which map a model has, and what a point of it is; why it has none."""


class EventMap(OfMap, frozen=True):
    """The map over a window, or a power of it, with branches and orbits."""

    window: Interval | None = None
    points: Annotated[int, Meta(ge=2, le=4000)] = 801
    power: Period = 1
    max_period: Annotated[int, Meta(ge=0, le=8)] = 4


class Cobweb(OfMap, frozen=True):
    """An orbit of the map."""

    d: float
    n: Annotated[int, Meta(ge=1, le=2000)] = 100


class Start(OfMap, frozen=True):
    """A state: a global stick phase d, or displacements and velocities."""

    d: float | Numbers | None = None
    x: Numbers | None = None
    v: Numbers | None = None


class Motion(Start, frozen=True):
    """A motion in time."""

    t_end: Annotated[float, Meta(gt=0, le=5000)] = 200.0
    samples: Annotated[int, Meta(ge=2, le=20_000)] = 4000


class Portrait(Motion, frozen=True):
    """The phase portrait of one block; a picture only."""

    block: Annotated[int, Meta(ge=1, le=MOST_BLOCKS)] = 1


class Plane(Motion, frozen=True):
    """A motion in the plane of displacements, over the stick locus; a picture only."""


class Mechanism(Motion, frozen=True):
    """Blocks, springs and belt at the start of a motion; as a film, the motion."""


class Cycle(Start, frozen=True):
    """The limit cycle that a motion settles on."""

    max_events: Annotated[int, Meta(ge=1, le=20_000)] = 2000


class Locus(Request, frozen=True):
    """The global stick locus in the plane of displacements."""


class Law(Request, frozen=True):
    """The friction laws of the blocks, up to a slip speed."""

    range: Annotated[float, Meta(gt=0, le=1000)] = 2.0
    points: Annotated[int, Meta(ge=2, le=4000)] = 401


class Basins(OfMap, frozen=True):
    """Basins of attraction on the whole domain; of more than two blocks in a plane section."""

    resolution: Annotated[float, Meta(gt=0, le=0.1)] = 1e-5


class Diagram(OfMap, frozen=True, kw_only=True):
    """Attractors, orbits and bifurcations over a parameter."""

    parameter: Word
    range: Interval
    window: Interval | None = None
    values: Annotated[int, Meta(ge=2, le=2000)] = 300
    max_period: Period = 4


REQUESTS: Final[dict[str, type[Request]]] = {
    "returns": Returns,
    "event_map": EventMap,
    "cobweb": Cobweb,
    "motion": Motion,
    "cycle": Cycle,
    "locus": Locus,
    "law": Law,
    "basins": Basins,
    "diagram": Diagram,
}
"""Views by name, and what is asked of each."""

PICTURES: Final[dict[str, type[Request]]] = {
    "portrait": Portrait,
    "plane": Plane,
    "mechanism": Mechanism,
}
"""Pictures of a motion, which has no view of its own for them: the page draws its motion."""


class Message(Struct, frozen=True, forbid_unknown_fields=True):
    """A message over the WebSocket: a request, or the slot of a request that is called off."""

    # Of each slot the latest request wins; it is the view, unless the page shows one twice.

    id: Annotated[int, Meta(ge=0, le=2**53)] = 0
    view: Word = ""
    slot: Word = ""
    request: Raw = Raw(b"{}")
    cancel: Word | None = None

    @property
    def place(self) -> str:
        """The slot of the message."""
        return self.slot or self.view


class Frame(Struct, frozen=True, forbid_unknown_fields=True):
    """What the page shows of a view's axes, where that is not all."""

    xlim: Interval | None = None
    ylim: Interval | None = None

    def settings(self, request: Request) -> dict[str, Any]:
        """Return arguments of ``Axes.set``; a map that is zoomed stays square, as on the page."""
        limits = {name: ends for name, ends in msgspec.structs.asdict(self).items() if ends}
        square = {"aspect": "auto", "box_aspect": 1} if isinstance(request, EventMap) else {}
        return limits and square | limits


WHOLE: Final = Frame()


class Export(Struct, frozen=True, forbid_unknown_fields=True):
    """A view as a file."""

    view: Word
    request: Raw
    format: Word
    frame: Frame = WHOLE


def request_of(view: str, content: Raw, known: Mapping[str, type[Request]] = REQUESTS) -> Request:
    """Decode a request of a view, one of the `known`."""
    if view not in known:
        raise BadRequestError(f"view = {view!r} is unknown. {did_you_mean(view, known)}", "view")
    return decoded(content, known[view])


def decoded(content: str | bytes | Raw, kind: type[T]) -> T:
    """Decode what the page sent: a `Message`, a request, or the wish for a file."""
    try:
        return msgspec.json.decode(content, type=kind)
    except msgspec.ValidationError as error:
        text, place = PLACE.sub("", str(error)), PLACE.search(str(error))
        field = place[1] if place else ""
        try:
            if BOUND.match(text):
                _check_range(field, content, kind)
        except ValueError as wrong:
            raise BadRequestError(str(wrong), field) from None
        wanted = EXPECTED.sub(lambda kind: f"{field} must be {KINDS[kind[1]]}", text)
        raise BadRequestError(wanted if field else text, field) from None
    except (msgspec.DecodeError, RecursionError) as error:
        raise BadRequestError(f"not JSON: {error}") from None


def _check_range(field: str, content: str | bytes | Raw, kind: type) -> None:
    """Say of a number of a request which value it has, and what is allowed."""
    value, known = msgspec.json.decode(content), cast(Any, inspect.type_info(kind))
    for key in re.findall(r"\w+", field):
        of_union = getattr(known, "types", (known,))
        if key.isdigit():
            value = value[int(key)]
            known = next(one.item_type for one in of_union if hasattr(one, "item_type"))
        else:
            value = value[key]
            (struct,) = (one for one in of_union if hasattr(one, "fields"))
            known = next(one.type for one in struct.fields if one.name == key)
    ends = {"at_least": known.ge, "above": known.gt, "at_most": known.le}
    check: Any = whole_number if isinstance(known, inspect.IntType) else finite_number
    check(field, value, **{name: end for name, end in ends.items() if end is not None})


def model_of_text(content: bytes) -> Model:
    """Make the model of a file, within the explorer's bounds."""
    try:
        table = toml_of(text_of(content))
    except ValueError as error:
        raise BadRequestError(str(error)) from None
    return model_of(Request(table))


def model_of(request: Request) -> Model:
    """Make the model that a request is about, within the explorer's bounds."""
    for key, value in request.model.items():
        _refuse_large(key, value)
    try:
        model = model_of_values(dict(request.model))
        refuse_busy(model)
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        if not is_ours(error):
            raise
        text = str(error)
        unnamed = "model.law" if text.startswith(("[friction", "friction:")) else "model"
        name = NAMED.search(SPRING.sub(r"\1contact_", of_page(text)))
        named = name and "_".join(filter(None, (f"model.{name[2]}", name[1])))
        raise BadRequestError(text, named or unnamed) from None
    for law in model.laws:
        size = len(law.formula.nodes) if isinstance(law.formula, TracedFormula) else 0
        if isinstance(law, UserLaw) and size > MOST_OPERATIONS:
            raise BadRequestError(
                f"the formula has {size} operations and names; the explorer takes at most "
                f"{MOST_OPERATIONS}. The library takes it.",
                "model.law",
            )
    return model


def _refuse_large(name: str, value: Any) -> None:
    """Refuse models that would keep the server busy by themselves, wherever a list is in them."""
    if isinstance(value, dict):
        for key, part in value.items():
            of_law = "law" in value and key in ("speed", "force")
            most = MOST_KNOTS if of_law else MOST_BLOCKS
            if isinstance(part, list) and len(part) > most:
                _too_long(key, part, most, "model.friction" if of_law else f"model.{name}")
            _refuse_large(name, [] if of_law else part)
    elif isinstance(value, list):
        if len(value) > MOST_BLOCKS:
            _too_long(name, value, MOST_BLOCKS, f"model.{name}")
        for part in value:
            _refuse_large(name, part)


def _too_long(key: str, value: list[Any], most: int, field: str) -> None:
    text = f"{key} has {len(value)} entries; the explorer takes at most {most}."
    raise BadRequestError(text, field)


@dataclass(frozen=True)
class Part:
    """A part of an answer."""

    name: str  # of the part, such as "samples"
    # floats, integers and booleans travel as f8, i4 and u1; single precision as f4
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    progress: float = 1.0  # share of the whole answer that has been sent with this part


def message(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None = None) -> bytes:
    """Pack a header and arrays: length of the header (4 bytes, little-endian), JSON, arrays."""
    # Each array starts at a multiple of 8 bytes.
    packed = {name: _packable(array) for name, array in (arrays or {}).items()}
    listed = [
        {"name": name, "dtype": kind, "shape": list(array.shape)}
        for name, (kind, array) in packed.items()
    ]
    head = msgspec.json.encode({**header, "arrays": listed})
    pieces = [_padded(len(head).to_bytes(4, "little") + head)]
    pieces += [_padded(array.tobytes()) for _, array in packed.values()]
    return b"".join(pieces)


def _packable(array: NDArray[Any]) -> tuple[str, NDArray[Any]]:
    kind = {"f": "f8", "i": "i4", "u": "i4", "b": "u1"}[array.dtype.kind]
    kind = {"uint8": "u1", "float32": "f4"}.get(array.dtype.name, kind)
    return kind, np.ascontiguousarray(array, dtype=DTYPES[kind])


def _padded(content: bytes) -> bytes:
    return content + bytes(-len(content) % ALIGNED)
