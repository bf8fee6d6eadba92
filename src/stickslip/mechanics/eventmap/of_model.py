"""The event map of a model, of two blocks or of many."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, TypedDict, Unpack, overload

from stickslip.checks import one_of
from stickslip.mechanics.eventmap.event_map import BlocksEventMap, EventMap
from stickslip.mechanics.model.arguments import checked_model
from stickslip.mechanics.model.file import model_of_values, model_values
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.results.files import register_map
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from stickslip.mechanics.flow.engine import EngineName
    from stickslip.mechanics.model.arguments import Model
    from stickslip.mechanics.model.belt_model import BeltModel

NOT_KEPT: Final = ("device", "threads")  # of the machine, not of the result


class Settings(TypedDict, total=False):
    """Keyword arguments of `event_map`, for the type checker."""

    rtol: float
    max_events: int
    max_time: float
    engine: EngineName
    device: str
    threads: int | None


@overload
def event_map(model: TwoBlock, **settings: Unpack[Settings]) -> EventMap: ...
@overload
def event_map(model: BeltModel, **settings: Unpack[Settings]) -> EventMap | BlocksEventMap: ...
@suggests
def event_map(
    model: TwoBlock | BeltModel,
    *,
    rtol: float = 1e-15,
    max_events: int = 10_000,
    max_time: float = math.inf,
    engine: EngineName = "auto",
    device: str = "cpu",
    threads: int | None = None,
) -> EventMap | BlocksEventMap:
    """Make the event map of a model: d of one global stick phase -> d of the next.

    Parameters
    ----------
    model : TwoBlock, Blocks or Chain
        Of two blocks, d is the number ``X_2 - X_1``; of N, the N - 1 differences
        ``X_{i+1} - X_i``.
    rtol : float
        Local truncation error of the adaptive engine. The default leaves rounding dominant;
        a larger one is faster and voids the guarantee next to grazing points.
    max_events : int
        A motion is given up (status EVENT_LIMIT) after so many changes of mode. Returns may
        take thousands.
    max_time : float
        A motion is given up (TIME_LIMIT) after so long, units of sqrt(m / k).
    engine : {"auto", "exact", "adaptive"}
        "exact": closed forms, for constant kinetic friction. "adaptive": series of high
        order, for every law. "auto" takes the exact engine where it exists, which is for two
        equal undamped blocks with constant kinetic friction.
    device : {"cpu", "cuda"}
        "cuda": an NVIDIA GPU (extra ``gpu``) carries the motions of two equal undamped blocks, with
        the same arithmetic up to fused multiply-adds; itineraries come from the CPU.
    threads : int, optional
        Processor cores used for large arrays; all by default.

    Returns
    -------
    EventMap or BlocksEventMap
        The first, a map of the line, of two blocks whatever they are.

    Raises
    ------
    ValueError
        A setting is not allowed; a forced model or a single block, which have no event map.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.event_map(ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22)))
    >>> round(f(0.1), 8)
    0.13121305
    """
    checked_model(model)
    made = EventMap if model.n_blocks == 2 else BlocksEventMap
    return made(
        model,
        rtol=rtol,
        max_events=max_events,
        max_time=max_time,
        engine=engine,
        device=device,
        threads=threads,
    )


def map_of(model: Model, **settings: Any) -> Any:
    """Event map of a model that has one, else the return map of its first contact."""
    plant = model.plant
    if plant.rubs_as_one and not plant.n_waves and model.n_blocks > 1:
        return event_map(model, **settings)
    from stickslip.mechanics.cycle.return_map import return_map  # not for an event map

    one_of("engine", settings.pop("engine", "auto"), ("auto", "adaptive"))
    return return_map(model, **settings)


def _values_of(f: Any) -> dict[str, Any]:
    """Describe a map of a model for files of results, apart from the machine it runs on."""
    settings = {name: value for name, value in f.settings.items() if name not in NOT_KEPT}
    return {"model": model_values(f.model), "settings": settings}


def register_model_map(kind: str, made: type, make: Callable[..., Any]) -> None:
    """Let files of results hold maps that `make` makes of a model and settings."""

    def again(values: dict[str, Any]) -> Any:
        return make(model_of_values(values["model"]), **values["settings"])

    register_map(kind, made, _values_of, again)


register_model_map("event map", EventMap, event_map)
register_model_map("event map of blocks", BlocksEventMap, event_map)
