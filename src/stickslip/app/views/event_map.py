"""The event map: its graph, branches and orbits, and its basins of attraction.

While a slider moves, orbits are solved for from those of a map nearby. They are orbits of the map,
to rounding; only the search after them tells that there are no others.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip import status
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basins import basins as divided
from stickslip.analysis.branches.branches import branches
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.derived import windowed
from stickslip.analysis.maps.protocol import clip_to_domain, domain_width
from stickslip.analysis.orbits.newton import polish_on
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.app.requests import Part
from stickslip.app.views.model import map_of, naming, space_map_of
from stickslip.app.views.section import section

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.branches.table import Branch, BranchTable
    from stickslip.analysis.maps.protocol import Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.app import requests
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

    Arrays = dict[str, NDArray[Any]]


FIRST_EVENTS: Final = 64  # changes of mode after which the first, quick picture gives up
FEWEST: Final = 24  # points of a branch, however narrow


def event_map(request: requests.EventMap) -> Iterator[Part]:
    """Sample the map at once; find its branches and orbits; then say why it breaks."""
    # First come orbits that follow from those of a map nearby, if one was asked for before. Orbits
    # that stay in the window are soon found, all others take the map's whole domain.
    f = map_of(request)
    x = np.linspace(*window_of(f, request), request.points)
    g = shown_map(f, request)
    yield _samples(f, x, request)
    if request.max_period > 0:
        if near := list(KNOWN.followed(f, f.model, request.max_period)):
            yield Part("followed", data={"orbits": near}, progress=0.3)
    yield _branches(g, x, branch_table(g), "branches", 0.5)
    if request.max_period > 0:
        yield _orbits(windowed(f, request.window), f.model, request.max_period, 0.7)
    yield _branches(g, x, branches(g), "explained", 0.8)
    if request.max_period > 0 and request.window is not None:
        yield _orbits(f, f.model, request.max_period, 1.0)


def window_of(f: Any, request: requests.EventMap) -> tuple[float, float]:
    """Return the window of a view, the domain by default."""
    if request.window is None:
        return f.domain
    with naming("window"):
        window: tuple[float, float] = windowed(f, request.window).domain
        return window


def shown_map(f: Any, request: requests.EventMap) -> Any:
    """Return the power of the map over the window."""
    g = f if request.power == 1 else f.power(request.power)
    return windowed(g, request.window)


def _samples(f: Any, x: Floats, request: requests.EventMap) -> Part:
    """Sample where motions return soon: the long ones are left to the exact picture."""
    quick = type(f)(f.model, **{**f.settings, "max_events": FIRST_EVENTS})
    found = quick.power(request.power).evaluate(x)
    number, labels = _numbered(found.label, found.status)
    data = {"domain": f.domain, "labels": labels}
    if request.power == 1:
        first = [int(np.argmax(number == k)) for k in range(len(labels))]
        data["itineraries"] = [f.itinerary(x[k]) for k in first]
    arrays: Arrays = {"x": x, "f": found.value, "branch": number}
    return Part("samples", arrays, data, progress=0.2)


def _numbered(label: NDArray[Any], codes: NDArray[Any]) -> tuple[NDArray[np.int32], list[str]]:
    """Count runs of equal labels from the left; -1 where the map has no value."""
    ok = codes == status.OK
    starts = ok & np.concatenate([[True], (label[1:] != label[:-1]) | ~ok[:-1]])
    number = np.where(ok, np.cumsum(starts) - 1, -1).astype(np.int32)
    return number, [_name(value) for value in label[starts]]


def _name(label: int) -> str:
    """Name a label; branches of one itinerary have one name."""
    return f"{int(label):016x}"


def _branches(g: Any, x: Floats, table: BranchTable, name: str, progress: float) -> Part:
    """Each branch from its first point to its last, with one-sided values there."""
    lines = _lines(g, table, x)
    arrays = {
        "x": np.concatenate([line[0] for line in lines] or [np.empty(0)]),
        "f": np.concatenate([line[1] for line in lines] or [np.empty(0)]),
        "branch": np.repeat(np.arange(len(lines)), [len(line[0]) for line in lines]),
    }
    data = {
        "domain": getattr(g, "whole", g).domain,
        "labels": [_name(branch.label) for branch in table],
        "itineraries": [table.text(branch.label) for branch in table],
        "breakpoints": [_break(item) for item in table.breakpoints],
        "unresolved": [str(item) for item in table.unresolved],
    }
    return Part(name, arrays, data, progress)


def _lines(g: Any, table: BranchTable, x: Floats) -> list[tuple[Floats, Floats]]:
    """Sample all branches in one go: the even points inside each, and some more of narrow ones."""
    inner = [_inner(branch, x) for branch in table]
    values = g.evaluate(np.concatenate([*inner, np.empty(0)])).value
    ends = np.cumsum([len(points) for points in inner], dtype=np.intp)
    *by_branch, _ = np.split(values, ends)  # nothing lies behind the last
    return [
        (
            np.concatenate([[b.left], points, [b.right]]),
            np.concatenate([[b.value_left], y, [b.value_right]]),
        )
        for b, points, y in zip(table, inner, by_branch, strict=True)
    ]


def _inner(branch: Branch, x: Floats) -> Floats:
    points = x[(x > branch.left) & (x < branch.right)]
    if len(points) >= FEWEST:
        return points
    return np.linspace(branch.left, branch.right, FEWEST + 2)[1:-1]


def _break(item: Breakpoint) -> dict[str, Any]:
    return {
        "at": item.d,
        "left": item.left,
        "right": item.right,
        "kind": item.kind,
        "mechanism": item.mechanism,
        "block": item.block,
    }


def _orbits(f: Map1D, model: Model, max_period: int, progress: float) -> Part:
    """Orbits of the map itself, also where a power of it is shown."""
    found = periodic_orbits(f, max_period, infinitely_unstable=True)
    KNOWN.add(model, found)
    data = {
        "window": f.domain,
        "orbits": [_orbit(orbit) for orbit in found],
        "unresolved": [str(item) for item in found.unresolved],
        "complete": found.complete,
    }
    return Part("orbits", data=data, progress=progress)


def _orbit(orbit: PeriodicOrbit) -> dict[str, Any]:
    jump = orbit.jump
    return {
        "period": orbit.period,
        "points": orbit.points,
        "multiplier": orbit.multiplier,
        "kind": orbit.kind,
        "stable": bool(orbit.stable),
        "itinerary": list(orbit.itinerary),
        "jump": None if jump is None else {"d": jump.d, "y": jump.y, "share": jump.share},
    }


def cobweb(request: requests.Cobweb) -> Iterator[Part]:
    """Iterate the map, and say how the orbit ends."""
    f = map_of(request)
    with naming("d"):
        orbit = f.iterate(request.d, request.n)
    yield Part("orbit", {"orbit": orbit}, {"end": _end(f, orbit)})


def _end(f: Any, orbit: Floats) -> dict[str, Any]:
    """Tell whether the orbit repeats itself to rounding, or stops, and why."""
    if np.isnan(orbit[-1]):
        last = orbit[np.isfinite(orbit)][-1]
        inside = clip_to_domain(f.domain, last)[1]
        why = str(f.evaluate(last).message) if inside else "the orbit has left the domain"
        return {"kind": "left", "period": 0, "status": why}
    back = np.abs(orbit[-2::-1] - orbit[-1])
    repeats = np.flatnonzero(back <= 1e-9 * (f.domain[1] - f.domain[0]))
    if repeats.size:
        return {"kind": "periodic", "period": int(repeats[0]) + 1, "status": ""}
    return {"kind": "unsettled", "period": 0, "status": ""}


def basins(request: requests.Basins) -> Iterator[Part]:
    """Find the attractors, then the exact edges of their basins; of more blocks a section."""
    if (f := space_map_of(request)) is not None:
        yield from section(f, request)
        return
    f = map_of(request)
    known = attractors(f)
    yield Part("attractors", data={"attractors": [_attractor(a) for a in known]}, progress=0.3)
    found = divided(f, known, resolution=request.resolution)
    data = {
        "causes": [str(cause) for cause in found.causes],
        "undecided": found.undecided,
        "left": found.left,
        "thin": found.thin,
        "counts": found.counts,
        "unresolved": [found.reason] if found.reason else [],
    }
    yield Part("basins", {"edges": found.edges, "label": found.index}, data)


def _attractor(found: Attractor) -> dict[str, Any]:
    return {
        "kind": found.kind,
        "period": found.period,
        "points": None if found.orbit is None else found.orbit.points,
        "bands": found.bands,
        "lyapunov": found.lyapunov.value,
        "reason": found.reason,
    }


NEAR: Final = 0.05  # largest change of a parameter, of its size
MOVED: Final = 0.05  # of the domain's width: an orbit further off is another one
SAME: Final = 1e-9  # of the domain's width: points that coincide
MODELS: Final = 64  # that are remembered


class Known:
    """Orbits of the latest models, of all users."""

    def __init__(self) -> None:
        self._lists: deque[tuple[Model, tuple[Floats, ...]]] = deque(maxlen=MODELS)

    def add(self, model: Model, orbits: Iterable[PeriodicOrbit]) -> None:
        """Remember the orbits of a model, those through a jump aside."""
        self._lists.append((model, tuple(o.points for o in orbits if o.jump is None)))

    def followed(self, f: Map1D, model: Model, max_period: int) -> Iterator[dict[str, Any]]:
        """Solve for the orbits of the nearest model that is known, if one is near."""
        latest_first = tuple(self._lists)[::-1]
        nearest = min(latest_first, key=lambda item: _distance(item[0], model), default=None)
        if nearest is None or _distance(nearest[0], model) > NEAR:
            return
        by_period: dict[int, list[Floats]] = defaultdict(list)
        for points in nearest[1]:
            by_period[len(points)].append(points)
        for period in sorted(period for period in by_period if period <= max_period):
            yield from _solved(f, np.array(by_period[period]))


KNOWN: Final = Known()


def _distance(one: Model, other: Model) -> float:
    """Largest change of a parameter, relative to its size; infinite between other laws."""
    if [law.formula for law in one.laws] != [law.formula for law in other.laws]:
        return np.inf
    first, second = one.parameters, other.parameters
    if first.keys() != second.keys():
        return np.inf
    sizes = [max(abs(first[name]), abs(second[name]), NEAR) for name in first]
    steps = [abs(first[name] - second[name]) for name in first]
    return max(step / size for step, size in zip(steps, sizes, strict=True))


def _solved(f: Map1D, guesses: Floats) -> Iterator[dict[str, Any]]:
    """Solve for orbits of one period, shape (n, p), all together."""
    low, high = f.domain
    guesses = guesses[((guesses >= low) & (guesses <= high)).all(axis=1)]

    found = polish_on(f, guesses)
    width = domain_width(f)
    kept: list[Floats] = []
    for k in np.flatnonzero(found.converged):
        points = np.roll(found.points[k], -int(np.argmin(found.points[k])))
        is_near = np.abs(found.points[k] - guesses[k]).max() <= MOVED * width
        is_shorter = len(points) > 1 and np.diff(np.sort(points)).min() <= SAME * width
        is_known = any(np.abs(points - other).max() <= SAME * width for other in kept)
        if is_near and not is_shorter and not is_known:
            kept.append(points)
            yield _described(points, float(found.slopes[k].prod()))


def _described(points: Floats, multiplier: float) -> dict[str, Any]:
    stable = abs(multiplier) < 1.0
    return {
        "period": len(points),
        "points": points,
        "multiplier": multiplier,
        "kind": "stable" if stable else "unstable",
        "stable": stable,
    }
