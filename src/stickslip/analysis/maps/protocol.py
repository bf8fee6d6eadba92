"""What a map of the line or of R^n must offer, and the ways in which this layer asks for values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, wraps
from typing import (
    Any,
    ClassVar,
    Final,
    NamedTuple,
    Protocol,
    Self,
    TypeAlias,
    TypeVar,
    runtime_checkable,
)

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.checks import MOST_STEPS, real_numbers, whole_number
from stickslip.results.result import Result
from stickslip.results.table import numbered, per_point
from stickslip.status import OK

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.intp]
Integers: TypeAlias = NDArray[np.int64]
Labels: TypeAlias = NDArray[np.uint64]
Codes: TypeAlias = NDArray[np.integer[Any]]

M = TypeVar("M", covariant=True)
T = TypeVar("T")

# Statuses beside those of motions: the map's function returned NaN there, a gap; the argument is
# NaN or outside the domain, an orbit that has left.
UNDEFINED, OUTSIDE = -1, -2

SAME: Final = 1e-12  # of a domain's width: positions so close agree, but for rounding
EXACT: Final = 1e-13  # ... and those of one orbit or break that was solved for agree so well
REMEMBERED: Final = 64  # tables and breaks kept, 100 kB a table: a map is asked many questions
DOMAIN_SLACK_ULP: Final = 4  # an argument this far outside the domain counts as its end


def remembered(told: Callable[..., T]) -> Callable[..., T]:
    """Keep what is told of the last maps, the first argument, but of those that are no keys."""
    kept = lru_cache(maxsize=REMEMBERED)(told)

    @wraps(told)
    def asked(f: Any, *rest: Any) -> T:
        try:
            hash(f)
        except TypeError:
            return told(f, *rest)
        return kept(f, *rest)

    return asked


@runtime_checkable
class MapValues(Protocol):
    """Values of a map at many points, all arrays of one shape.

    ``value`` is NaN exactly where ``status`` is not `stickslip.status.OK`. ``derivative`` is
    exact, one-sided at a breakpoint. Points of one branch share a ``label``; where the status
    is not OK the label means nothing.
    """

    @property
    def value(self) -> Floats:
        """f(x), NaN where the map has none."""

    @property
    def derivative(self) -> Floats:
        """f'(x), exact; one-sided at a breakpoint."""

    @property
    def label(self) -> Labels:
        """One number per branch."""

    @property
    def status(self) -> Codes:
        """OK, or why there is no value."""


@runtime_checkable
class Map1D(Protocol):
    """A piecewise-smooth map of an interval into the line, immutable and hashable.

    ``evaluate`` takes any shape and raises ``ValueError`` for an argument that is NaN or
    outside the domain; what the map does (no value there) is data: NaN and a status.

    It may also offer, and the analysis then uses:

    - ``margin`` among the values: a distance, zero at a breakpoint, that tells how far a
      point is from changing its label;
    - ``value_and_derivative(x)``, these two alone, faster than ``evaluate``;
    - ``iterate(x, n)``, shape (..., n + 1), faster than a loop over ``evaluate``;
    - ``iterate_each(maps, xs, n)``, this of several maps of its kind, faster than one by one;
    - ``itinerary(x)``, a text per point that says more than the label's number;
    - ``base`` and ``exponent``: this map is ``base`` applied ``exponent`` times;
    - ``explain_break(left, right)``, the `Mechanism` of a breakpoint between two points.
    """

    @property
    def domain(self) -> tuple[float, float]:
        """Ends ``lo < hi`` of the closed interval of arguments."""

    def evaluate(self, x: ArrayLike, /) -> MapValues:
        """Return value, derivative, label and status, all shaped like ``x``."""


class Mechanism(NamedTuple):
    """Why a map breaks, in words, and the block that the break concerns, if one does."""

    text: str
    block: int | None


@runtime_checkable
class Modelled(Protocol[M]):
    """A model: something that makes its own map."""

    def as_map(self) -> M:
        """Return the map, of the line or of R^n."""


class Varied(Protocol):
    """What a map with parameters offers, exact derivatives with respect to each included."""

    @property
    def parameters(self) -> Mapping[str, float]:
        """Names and values."""

    def replace(self, **changes: Any) -> Self:
        """Return the map with other parameter values."""

    def parameter_derivative(self, x: ArrayLike, name: str, /) -> Any:
        """Return df/d(name) at fixed ``x``, shaped like it."""


@runtime_checkable
class MapFamily(Map1D, Varied, Protocol):
    """A map of the line with named parameters."""


@runtime_checkable
class MapND(Protocol):
    """A piecewise-smooth map of a part of R^n into R^n, immutable.

    ``evaluate`` takes points of shape (..., n): ``value`` is shaped like them, ``derivative`` is
    the Jacobian (..., n, n), ``label`` and ``status`` are (...). It may raise ValueError outside
    the domain. A map may also offer ``itinerary(x)``, a text per point that says more than the
    label's number, and ``periods`` of its coordinates, infinite for those that are no angles.
    """

    @property
    def dimension(self) -> int:
        """The n."""

    def contains(self, x: ArrayLike, /) -> Bools:
        """Tell which points are in the domain, shape (...); False for NaN."""

    def spread(self, count: int, /) -> Floats:
        """Return points spread evenly over the domain, shape (count, n), always the same."""

    def evaluate(self, x: ArrayLike, /) -> MapValues:
        """Return value, Jacobian, label and status."""


@runtime_checkable
class FamilyND(MapND, Varied, Protocol):
    """A map of R^n with named parameters."""


@dataclass(frozen=True, eq=False, repr=False)
class PointValues(Result):
    """Values of a map at many points: the plain container of `MapValues`; margins may be NaN."""

    value: Floats
    derivative: Floats
    label: Labels
    status: Integers
    margin: Floats
    # Of each motion, if the map is one of motions.
    n_events: Integers = field(default_factory=lambda: np.zeros((), np.int64))
    _drawn: ClassVar = ("point", "value")

    def _columns(self) -> dict[str, Any]:
        shape = self.status.shape
        return {
            "point": np.arange(self.status.size) + 1,
            **numbered("value", per_point(self.value, shape)),
            **numbered("derivative", per_point(self.derivative, shape)),
            **{name: getattr(self, name).ravel() for name in ("label", "status", "margin")},
        }


def shaped(shape: tuple[int, ...], *columns: Any) -> PointValues:
    """Return values of a map of the line, known at points in a row, in the points' own shape."""
    return PointValues(*(column.reshape(shape) for column in columns))


def clip_to_domain(domain: tuple[float, float], x: Floats) -> tuple[Floats, Bools]:
    """Return points, moved to the nearest end of the domain, and which lie inside, by a few ulp."""
    lo, hi = domain
    inside = (x >= lo) & (x <= hi)
    if np.count_nonzero(inside) == inside.size:  # nearly always
        return x, inside
    slack = DOMAIN_SLACK_ULP * math.ulp(max(abs(lo), abs(hi)))
    inside = (x >= lo - slack) & (x <= hi + slack)
    return np.minimum(np.maximum(x, lo), hi), inside


def checked_points(domain: tuple[float, float], x: ArrayLike, name: str = "x") -> Floats:
    """Return ``x`` as floats inside the domain, within 4 ulp, or say which element is not."""
    points = real_numbers(name, x)
    clipped, inside = clip_to_domain(domain, points)
    if not inside.all():
        position = tuple(int(i) for i in np.argwhere(~inside)[0])
        where = f"{name}[{', '.join(map(str, position))}]" if position else name
        raise ValueError(
            f"{where} = {points[position]:.17g} is outside the domain "
            f"[{domain[0]:.17g}, {domain[1]:.17g}]. Take {name} from the map's domain."
        )
    return clipped


def sample(f: Map1D | MapND, x: ArrayLike) -> PointValues:
    """Evaluate a map at any points; outside: NaN, label 0 and status `OUTSIDE`."""
    points = np.asarray(x, dtype=np.float64)
    contains = getattr(f, "contains", None)  # of maps of R^n
    if contains is None:
        points, inside = clip_to_domain(f.domain, points)  # type: ignore[union-attr]
        f = getattr(f, "whole", f)  # the window is passed
    else:
        inside = contains(points)
    if inside.all() and (contains is None or inside.size):
        got = f.evaluate(points)
        return PointValues(
            np.asarray(got.value, dtype=np.float64),
            np.asarray(got.derivative, dtype=np.float64),
            np.asarray(got.label, dtype=np.uint64),
            np.asarray(got.status, dtype=np.int64),
            _margin(got),
            np.asarray(getattr(got, "n_events", 0), dtype=np.int64),
        )
    value, margin = np.full(points.shape, np.nan), np.full(inside.shape, np.nan)
    shape = points.shape if contains is None else (*points.shape, points.shape[-1])
    derivative = np.full(shape, np.nan)
    label = np.zeros(inside.shape, dtype=np.uint64)
    status = np.full(inside.shape, OUTSIDE, dtype=np.int64)
    n_events = np.zeros(inside.shape, dtype=np.int64)
    if inside.any():
        got = f.evaluate(points[inside])
        value[inside], derivative[inside] = got.value, got.derivative
        label[inside], status[inside] = got.label, got.status
        margin[inside], n_events[inside] = _margin(got), getattr(got, "n_events", 0)
    return PointValues(value, derivative, label, status, margin, n_events)


def values_and_slopes(f: Map1D, x: Floats) -> tuple[Floats, Floats]:
    """Value and derivative at points that may be NaN or outside its domain, NaN there."""
    offered = getattr(f, "value_and_derivative", None)
    if offered is None:
        got = sample(f, x)
        return got.value, got.derivative
    clipped, inside = clip_to_domain(f.domain, x)
    if inside.all():
        return offered(clipped)
    value, slope = np.full(x.shape, np.nan), np.full(x.shape, np.nan)
    value[inside], slope[inside] = offered(clipped[inside])
    return value, slope


def _margin(values: MapValues) -> Floats:
    known = getattr(values, "margin", None)
    if known is None:
        return np.full(np.shape(values.label), np.nan)
    return np.asarray(known, dtype=np.float64)


def iterate(f: Map1D, x: ArrayLike, n: int) -> Floats:
    """Apply a map ``n`` times, keeping every point, shape ``x.shape + (n + 1,)``; NaN stays."""
    n = whole_number("n", n, 0, at_most=MOST_STEPS, what="applications of a map")
    start = checked_points(f.domain, x)
    orbit = np.empty((*start.shape, n + 1))
    orbit[..., 0] = start
    for k in range(n):
        orbit[..., k + 1] = sample(f, orbit[..., k]).value
    return orbit


def advance(f: Map1D, x: Floats, n: int) -> Floats:
    """Iterate points, NaN allowed, `n` times, by the map's own ``iterate`` if any: (m, n + 1)."""
    orbit = np.full((len(x), n + 1), np.nan)
    alive = np.flatnonzero(clip_to_domain(f.domain, x)[1])
    if alive.size:
        native = getattr(f, "iterate", None)
        orbit[alive] = native(x[alive], n) if native is not None else iterate(f, x[alive], n)
    return orbit


def advance_each(maps: Sequence[Map1D], xs: Sequence[Floats], n: int) -> list[Floats]:
    """Iterate points of several maps of one kind as `advance` does, side by side if they can."""
    native = getattr(maps[0], "iterate_each", None)
    if native is None:
        return [advance(f, x, n) for f, x in zip(maps, xs, strict=True)]
    orbits = [np.full((len(x), n + 1), np.nan) for x in xs]
    alive = [clip_to_domain(f.domain, x)[1] for f, x in zip(maps, xs, strict=True)]
    concerned = [k for k, rows in enumerate(alive) if rows.any()]
    if concerned:
        found = native([maps[k] for k in concerned], [xs[k][alive[k]] for k in concerned], n)
        for k, some in zip(concerned, found, strict=True):
            orbits[k][alive[k]] = some
    return orbits


def mix_labels(seed: Labels, label: Labels) -> Labels:
    """Combine labels in their order into one, practically unique (splitmix64's finaliser)."""
    with np.errstate(over="ignore"):  # modulo 2^64 is meant; NumPy warns for single numbers
        z = seed * np.uint64(0x9E3779B97F4A7C15) + label + np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


def domain_width(f: Map1D) -> float:
    """Length of a map's domain, the scale that relative tolerances refer to."""
    lo, hi = f.domain
    return hi - lo


def domain_size(f: Map1D) -> float:
    """Largest modulus in a map's domain, the scale of rounding."""
    return max(abs(end) for end in f.domain)


def length(width: Any) -> Any:
    """Return the power of 1024 nearest to a width: 1 of widths about 1.

    Measured in it, as in metres or kilometres, nothing depends on a unit, nor loses a digit.
    """
    return np.exp2(10.0 * np.round(np.log2(width) / 10.0))


def is_ok(values: MapValues) -> Bools:
    """Return where a map has a value, so that slopes and labels there mean something."""
    return np.asarray(values.status) == OK


def explanation(f: Map1D, left: float, right: float) -> Mechanism:
    """Return why a map breaks between two points; no words from a map that offers none."""
    explain = getattr(f, "explain_break", None)
    if explain is None:
        return Mechanism("", None)
    if not clip_to_domain(f.domain, np.array([left, right]))[1].all():
        return Mechanism("the orbit has left the domain", None)  # of a power of the map
    return explain(left, right)


def base_and_exponent(f: Map1D) -> tuple[Map1D, int]:
    """Return the map that ``f`` is a power of, and the exponent: (f, 1) for a plain map."""
    base, exponent = getattr(f, "base", None), getattr(f, "exponent", None)
    if isinstance(base, Map1D) and isinstance(exponent, int):
        inner, times = base_and_exponent(base)
        return inner, times * exponent
    return f, 1


# ------------------------------------------------------------------ points of R^n


def apart(f: Map1D | MapND, x: Floats, y: Floats) -> Floats:
    """Differences of points, angles the short way round."""
    difference: Floats = x - y
    return difference - _whole_turns(f, difference)


@remembered
def widths(f: MapND) -> Floats:
    """Width of a map's domain in each direction, (n,); ValueError without bounds."""
    return np.ptp(f.spread(256), axis=0)


@remembered
def lengths(f: MapND) -> Floats:
    """Lengths to measure the coordinates of a map's points in, (n,); 1 of an endless domain."""
    domain = getattr(f, "domain", None)
    if domain is not None:
        width = np.ptp(np.asarray(domain, dtype=np.float64), axis=1)
    else:
        try:
            width = widths(f)
        except ValueError:  # no bounds
            width = np.ones(f.dimension)
    return length(np.where(np.isfinite(width) & (width > 0.0), width, 1.0))


def measured(jacobians: Floats, unit: Floats | float) -> Floats:
    """Jacobians (..., n, n) of points that are measured in units, or slopes of those of a line."""
    return jacobians * unit / np.asarray(unit)[..., None]


def turned_near(f: MapND, x: Floats, near: Floats) -> Floats:
    """Return points with each angle turned by whole periods to where it is closest to others."""
    return x + _whole_turns(f, near - x)


def _whole_turns(f: Map1D | MapND, difference: Floats) -> Floats | float:
    """Return what of differences between points is whole periods of angles."""
    if (periods := getattr(f, "periods", None)) is None:
        return 0.0
    angle = np.isfinite(periods)  # of a line's one number for all points, (p,)
    period = np.where(angle, periods, 1.0)
    return np.where(angle, np.round(difference / period) * period, 0.0)


def meet_on_circle(f: Map1D, left: float, right: float) -> bool:
    """Tell whether two values apart on the line are one point, where a phase begins anew."""
    same = SAME * domain_width(f)
    off = np.abs(apart(f, np.array([left]), np.array([right])))
    return bool((off <= same).all() and same < abs(left - right))


def turns(f: MapND) -> Floats:
    """Return the period of each coordinate from its low end on, (n, 2); infinite for no angle."""
    period = np.asarray(getattr(f, "periods", np.full(f.dimension, np.inf)))
    domain = getattr(f, "domain", None)
    low = np.zeros(f.dimension) if domain is None else np.asarray(domain, dtype=np.float64)[:, 0]
    low = np.where(np.isfinite(low), low, 0.0)
    return np.stack([low, low + period], axis=1)


def reduced(f: MapND, x: Floats) -> Floats:
    """Return points with each angle in the period that begins at the domain's low end."""
    if not np.isfinite(getattr(f, "periods", np.inf)).any():
        return x
    box = turns(f)
    angle = np.isfinite(box[:, 1])
    low, period = box[angle, 0], np.ptp(box[angle], axis=1)
    led = np.array(x, dtype=np.float64)
    within = np.mod(led[..., angle] - low, period)
    led[..., angle] = low + np.where(within < period, within, 0.0)  # rounded up
    return led


def box_points(box: Floats, count: int) -> Floats:
    """Return the first points of a Sobol sequence in a box (n, 2), always the same."""
    from scipy.stats.qmc import Sobol  # not for the first value

    low, high = box.T
    shares = Sobol(len(box), rng=0).random_base2(max(count - 1, 1).bit_length())[:count]
    return np.asarray(low + shares * (high - low))


def orbits(f: Any, x: Floats, n: int) -> Floats:
    """Return orbits (m, n + 1, d) of any points (m, d); NaN once they have left the domain."""
    made = np.full((len(x), n + 1, x.shape[1]), np.nan)
    made[:, 0] = x
    inside = f.contains(x)
    if hasattr(f, "iterate"):
        if n and inside.any():
            made[inside] = f.iterate(x[inside], n)
        return made
    for k in range(n):
        made[:, k + 1] = sample(f, made[:, k]).value
    return made
