"""Normal forms: what is born at a bifurcation, on which side, and whether it is stable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, TypeAlias

import numpy as np

from stickslip.analysis.maps.differences import (
    N_STEPS,
    extrapolated_difference,
    extrapolated_second_difference,
)
from stickslip.analysis.maps.protocol import domain_width, mix_labels, reduced, sample, widths
from stickslip.analysis.scales import CLOSE, HALF_DIGITS
from stickslip.numerics.arrays import EPS
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Floats, Map1D, MapFamily, MapND, PointValues

Criticality: TypeAlias = Literal["super", "sub"]

ROUNDING: Final = 16 * EPS  # differences may agree by chance
FEW_STEPS: Final = N_STEPS // 2 + 1  # the first half of the way: down to 2e-6 of the domain


@dataclass(frozen=True)
class CubicCoefficient:
    """Cubic coefficient of the critical map: u -> -u + c u^3; |u| -> |u| + a |u|^3."""

    value: float  # on a line (g'')^2 / 4 + g''' / 6 of g = f^p: coordinates do not change its sign
    error: float
    kind: str = "flip"

    @property
    def criticality(self) -> Criticality | None:
        """``super`` if what is born is stable (c > 0, a < 0); None if the error leaves it open."""
        if not abs(self.value) > self.error:
            return None
        return "super" if (self.value > 0) == (self.kind == "flip") else "sub"


class FoldCoefficient(NamedTuple):
    """A fold: f^p(x) - x is half ``curvature`` u^2 + ``speed`` (q - q0) + ..."""

    curvature: float
    error: float  # of the curvature
    speed: float


@dataclass(frozen=True)
class CrossingCoefficients:
    """Two curves of orbits that cross: g = f^p(x) - x to the lowest orders."""

    curvature: float  # g_xx; zero at a pitchfork, where one of the curves is vertical
    error: float  # of the curvature: a smaller one is none
    cubic: float  # g_xxx
    doubt: float  # error of the cubic
    mixed: float  # g_xq
    discriminant: float  # g_xq^2 - g_xx g_qq: its ± root is the rate of multipliers along curves

    @property
    def kind(self) -> Literal["transcritical", "pitchfork"]:
        """Whether both orbits are there on both sides, or two of them on one side only."""
        return "pitchfork" if abs(self.curvature) <= self.error else "transcritical"

    @property
    def criticality(self) -> Criticality | None:
        """Of a pitchfork: ``super`` if the two new orbits are stable where they exist."""
        if self.kind == "transcritical" or not abs(self.cubic) > self.doubt:
            return None
        return "super" if self.cubic < 0 else "sub"

    @property
    def text(self) -> str:
        """The normal form in words."""
        if self.kind == "transcritical":
            return f"multipliers 1 ± {np.sqrt(abs(self.discriminant)):.5g} (q - q0)"
        return f"u -> u + {self.mixed:.5g} (q - q0) u + {self.cubic / 6:.5g} u^3"


def flip_coefficient(f: Map1D, points: ArrayLike) -> CubicCoefficient:
    """Find the cubic coefficient -S / 6 of a flip; NaN for a point alone on its branch."""
    # S, the Schwarzian of f^p, is the sum of S f(x_k) ((f^(k-1))'(x_1))^2 over the orbit
    # (Kuznetsov, Elements of Applied Bifurcation Theory, 4.5; de Melo and van Strien, One-
    # Dimensional Dynamics, II.6).
    x = np.asarray(points, dtype=np.float64)
    value, doubt = _schwarzian(*_derivatives(f, x))
    return CubicCoefficient(value / -6, doubt / 6)


def fold_coefficient(f: MapFamily, points: ArrayLike, name: str) -> FoldCoefficient:
    """Find curvature and speed of a fold: its two orbits exist where their signs differ."""
    x = np.asarray(points, dtype=np.float64)
    moved = np.asarray(f.parameter_derivative(x, name), dtype=np.float64)
    slope, (second, error_2), _ = _derivatives(f, x)
    weight = _before(slope) ** 2 * _after(slope)
    with np.errstate(all="ignore"):
        value = float(weight @ second)
        doubt = float(np.abs(weight) @ (error_2 + ROUNDING * np.abs(second)))
    return FoldCoefficient(
        value, doubt if np.isfinite(doubt) else np.inf, float(_after(slope) @ moved)
    )


def crossing_coefficients(
    f: Map1D, points: ArrayLike, mixed: float, discriminant: float
) -> CrossingCoefficients:
    """Find what tells a transcritical crossing of two curves of orbits from a pitchfork."""
    x = np.asarray(points, dtype=np.float64)
    slope, second, third = _derivatives(f, x)
    with np.errstate(all="ignore"):
        weight = _before(slope) ** 2 * _after(slope)
        curvature, error = float(weight @ second[0]), float(np.abs(weight) @ second[1])
        # g' = 1, so that g''' = S g + 3/2 (g'')^2 with the Schwarzian derivative S.
        schwarzian, doubt = _schwarzian(slope, second, third)
        cubic, doubt = schwarzian + 1.5 * curvature**2, doubt + 3 * abs(curvature) * error
    # A curvature that so small a shift makes is none.
    error += HALF_DIGITS * abs(cubic) * domain_width(f)
    return CrossingCoefficients(curvature, error, cubic, doubt, mixed, discriminant)


def _schwarzian(
    slope: Floats, second: tuple[Floats, Floats], third: tuple[Floats, Floats]
) -> tuple[float, float]:
    """Schwarzian derivative of f^p and its error, from derivatives of f along an orbit."""
    with np.errstate(all="ignore"):
        own = third[0] / slope - 1.5 * (second[0] / slope) ** 2
        error = third[1] / np.abs(slope) + 3 * np.abs(second[0]) * second[1] / slope**2
        error += ROUNDING * (np.abs(third[0] / slope) + 1.5 * (second[0] / slope) ** 2)
        weight = _before(slope) ** 2
        value, doubt = float(weight @ own), float(weight @ error)
    return value, doubt if np.isfinite(doubt) else np.inf


def _before(slope: Floats) -> Floats:
    """Products of the slopes before each point: derivatives of f^0, f^1, ... at the first."""
    return np.concatenate([[1.0], np.cumprod(slope[:-1])])


def _after(slope: Floats) -> Floats:
    """Products of the slopes after each point."""
    return _before(slope[::-1])[::-1]


def _derivatives(
    f: Map1D, x: Floats
) -> tuple[Floats, tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return f', and f'' and f''' with errors, from values of f' on the branch of each point."""
    # Short steps are for points close to a break: most others are known well enough without.
    at_x = sample(f, x)
    found = _differences(f, x, at_x, FEW_STEPS)
    with np.errstate(invalid="ignore"):
        sharp = np.all([doubt <= HALF_DIGITS * np.abs(value) for value, doubt in found], axis=0)
    if not sharp.all():
        rough = ~sharp
        finer = _differences(f, x[rough], sample(f, x[rough]), N_STEPS)
        for old, new in zip(found, finer, strict=True):
            for column, better in zip(old, new, strict=True):
                column[rough] = better
    return at_x.derivative, found[0], found[1]


def _differences(
    f: Map1D, x: Floats, at_x: PointValues, n_steps: int
) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return f'' and f''' with errors, given the values at the points themselves."""
    seen: dict[bytes, PointValues] = {}

    def values(points: Floats) -> PointValues:
        # First and second differences ask for the same points, once for slopes, once for labels.
        key = points.tobytes()
        if key not in seen:
            seen[key] = at_x if key == x.tobytes() else sample(f, points)
        return seen[key]

    def slopes(points: Floats) -> Floats:
        return values(points).derivative

    def same_branch(here: Floats, points: Floats) -> NDArray[np.bool_]:
        there = values(points)
        labels = np.resize(at_x.label, here.shape)  # here is x again and again
        return (there.status == OK) & (labels == there.label)

    width = domain_width(f)
    second = extrapolated_difference(slopes, x, width, same_branch, n_steps)
    third = extrapolated_second_difference(slopes, x, width, same_branch, n_steps)
    return second, third


# ------------------------------------------------------------------ in R^n


def coefficient(f: MapND, points: Floats, kind: str) -> CubicCoefficient:
    """Find the cubic coefficient of a flip or Neimark-Sacker bifurcation at an orbit (p, n)."""
    # Kuznetsov, Elements of Applied Bifurcation Theory, 5.4.
    a, b, b_error, c, c_error = _forms(f, points)
    multipliers, right = np.linalg.eig(a)
    on = -1.0 if kind == "flip" else 1j * np.inf
    off = np.abs(multipliers - on) if kind == "flip" else np.abs(np.abs(multipliers) - 1.0)
    off = np.where((kind == "flip") | (multipliers.imag > 0), off, np.inf)
    k = int(np.argmin(off))
    m, q = multipliers[k], right[:, k]
    p = np.linalg.inv(right)[k].conj()  # <p, q> = sum of conj(p) q = 1
    eye = np.eye(len(q))
    with np.errstate(all="ignore"):
        if kind == "flip":
            m, q, p = -1.0, q.real / np.linalg.norm(q.real), p.real * np.linalg.norm(q.real)
        resonances = [] if kind == "flip" else [m**r - 1.0 for r in (1, 2, 3, 4)]
        if min(map(abs, resonances), default=1.0) < CLOSE:
            return CubicCoefficient(np.nan, np.inf, kind)
        mean = np.linalg.solve(eye - a, _two(b, q, q.conj()))
        twice = np.linalg.solve(m * m * eye - a, _two(b, q, q)) if resonances else mean
        # At a flip m^2 = 1: both are one term, which counts three times.
        cubic = _three(c, q, q, q.conj())
        cubic = cubic + 2.0 * _two(b, q, mean) + _two(b, q.conj(), twice)
        share = 0.5 * m.conjugate() if resonances else 1.0 / 6.0
        value = float((share * (p.conj() @ cubic)).real)
        sizes = np.abs(q), np.abs(mean), np.abs(twice)
        doubt = _three(c_error, *(3 * [sizes[0]]))
        doubt = doubt + 4.0 * _two(b_error, sizes[0], sizes[1] + sizes[2])
        error = float(abs(share) * (np.abs(p) @ doubt))
    return CubicCoefficient(value, error if np.isfinite(error) else np.inf, kind)


def _two(b: Floats, u: Any, v: Any) -> Any:
    return np.einsum("ijk,i,k->j", b, u, v)


def _three(c: Floats, u: Any, v: Any, w: Any) -> Any:
    return np.einsum("hijk,h,i,k->j", c, u, v, w)


def _forms(f: MapND, points: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Jacobian of f^p at the first point, its derivatives by one and by two axes, with errors."""
    p, n = points.shape
    size = widths(f)
    pairs = [(i, j) for i in range(n) for j in range(i + 1, n)]
    ways = np.array([*np.eye(n), *(np.eye(n)[i] + np.eye(n)[j] for i, j in pairs)]) * size
    jacobian, label = _power(f, points[0], p)
    shape = (len(ways), n, n)

    def moved(s: Floats) -> Floats:
        shares = s.reshape(-1, *shape)[..., 0, 0, None]
        return np.asarray(points[0] + shares * ways)

    def slopes(s: Floats) -> Floats:
        got: Floats = _power(f, moved(s), p)[0]
        return got.ravel()

    def same_piece(_: Floats, s: Floats) -> NDArray[np.bool_]:
        same = _power(f, moved(s), p)[1] == label
        return np.repeat(same.ravel(), n * n)

    start = np.zeros(n * n * len(ways))
    with np.errstate(all="ignore"):
        first = extrapolated_difference(slopes, start, 1.0, same_piece, FEW_STEPS)
        second = extrapolated_second_difference(slopes, start, 1.0, same_piece, FEW_STEPS)
    (b, b_error), (d, d_error) = (
        tuple(each.reshape(shape) for each in both) for both in (first, second)
    )
    c, c_error = np.zeros((n, n, n, n)), np.zeros((n, n, n, n))
    for i in range(n):
        c[i, i], c_error[i, i] = d[i], d_error[i]
    for k, (i, j) in enumerate(pairs, start=n):
        c[i, j] = c[j, i] = 0.5 * (d[k] - d[i] - d[j])
        c_error[i, j] = c_error[j, i] = 0.5 * (d_error[k] + d_error[i] + d_error[j])
    one, two = size[:, None, None], (size[:, None] * size)[:, :, None, None]
    return jacobian, b[:n] / one, b_error[:n] / one, c / two, c_error / two


def _power(f: MapND, x: Floats, p: int) -> tuple[Floats, NDArray[np.uint64]]:
    """Jacobian of f^p at points (..., n), and one label for the pieces visited; NaN if it ends."""
    product: Any = np.eye(x.shape[-1])
    label = np.zeros(x.shape[:-1], dtype=np.uint64)
    for _ in range(p):
        got = sample(f, reduced(f, x))
        product = got.derivative @ product
        label = np.where(got.status == OK, mix_labels(label, got.label), np.uint64(0))
        x = got.value
    return product, label
