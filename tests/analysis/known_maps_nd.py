"""Smooth maps of the plane with known orbits and bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from stickslip.analysis.maps.protocol import PointValues

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Floats

Function = Callable[..., Any]


@dataclass(frozen=True)
class SmoothMap:
    """A map of a box into R^n by plain functions of points (..., n) and of parameters.

    ``label(x, **parameters)``: of the pieces of a map that is only piecewise smooth.
    """

    func: Function
    jacobian: Function
    rates: Mapping[str, Function]
    box: tuple[tuple[float, float], ...]
    values: tuple[tuple[str, float], ...]
    label: Function | None = None

    @property
    def dimension(self) -> int:
        """Length of a point."""
        return len(self.box)

    @property
    def parameters(self) -> dict[str, float]:
        """Names and values."""
        return dict(self.values)

    def replace(self, **changes: float) -> Self:
        """Return the map with other parameter values."""
        return replace(self, values=tuple((self.parameters | changes).items()))

    def contains(self, x: ArrayLike) -> NDArray[np.bool_]:
        """Whether points lie in the box."""
        low, high = np.array(self.box).T
        points = np.asarray(x)
        return np.asarray(((points >= low) & (points <= high)).all(axis=-1))

    def spread(self, count: int) -> Floats:
        """Points of a Sobol sequence in the box."""
        from scipy.stats.qmc import Sobol

        low, high = np.array(self.box).T
        shares = Sobol(self.dimension, rng=0).random_base2(max(count - 1, 1).bit_length())
        return np.asarray(low + (high - low) * shares[:count])

    def evaluate(self, x: ArrayLike) -> PointValues:
        """Value and Jacobian."""
        points = np.asarray(x, dtype=np.float64)
        shape = points.shape[:-1]
        label = np.zeros(shape) if self.label is None else self.label(points, **self.parameters)
        return PointValues(
            self.func(points, **self.parameters),
            self.jacobian(points, **self.parameters),
            np.asarray(label, dtype=np.uint64),
            np.zeros(shape, dtype=np.int64),
            np.full(shape, np.nan),
        )

    def parameter_derivative(self, x: ArrayLike, name: str) -> Floats:
        """df/d(name)."""
        return np.asarray(self.rates[name](np.asarray(x), **self.parameters))


def _rows(*rows: tuple[Any, Any]) -> Floats:
    """Jacobians of a map of the plane from their entries."""
    return np.stack([np.stack(np.broadcast_arrays(*row), axis=-1) for row in rows], axis=-2)


def _points(*coordinates: Any) -> Floats:
    return np.stack(np.broadcast_arrays(*coordinates), axis=-1)


def delayed_logistic(a: float = 1.9) -> SmoothMap:
    """Make x' = a x (1 - y), y' = x (Maynard Smith): a Neimark-Sacker bifurcation at a = 2.

    The fixed point x = y = 1 - 1/a has the multipliers m with m^2 - m + a - 1 = 0, which at
    a = 2 are (1 ± i sqrt(3)) / 2.
    """
    return SmoothMap(
        lambda z, a: _points(a * z[..., 0] * (1 - z[..., 1]), z[..., 0]),
        lambda z, a: _rows((a * (1 - z[..., 1]), -a * z[..., 0]), (1.0 + 0 * z[..., 0], 0.0)),
        {"a": lambda z, a: _points(z[..., 0] * (1 - z[..., 1]), 0.0)},
        ((-0.5, 1.5), (-0.5, 1.5)),
        (("a", a),),
    )


def henon(a: float = 1.4, b: float = 0.3) -> SmoothMap:
    """Make x' = 1 - a x^2 + y, y' = b x (Hénon 1976).

    At 1.4, 0.3 all orbits up to period 10 are known: 2, 1, 0, 1, 0, 2, 4, 7, 6, 10 (Galias, Int.
    J. Bifurcation and Chaos 8, 1998; his list leaves out the fixed point off the attractor).
    The fixed points are born at a = -(1 - b)^2 / 4 and one flips at a = 3 (1 - b)^2 / 4.
    """
    return SmoothMap(
        lambda z, a, b: _points(1 - a * z[..., 0] ** 2 + z[..., 1], b * z[..., 0]),
        lambda z, a, b: _rows((-2 * a * z[..., 0], 1.0), (b + 0 * z[..., 0], 0.0)),
        {
            "a": lambda z, a, b: _points(-(z[..., 0] ** 2), 0.0),
            "b": lambda z, a, b: _points(0.0, z[..., 0]),
        },
        ((-6.0, 6.0), (-6.0, 6.0)),
        (("a", a), ("b", b)),
    )


def kinked(mu: float = -0.1, jump: float = 0.0) -> SmoothMap:
    """Make the normal form x' = tau x + y + mu, y' = -x/4, with tau = 1/2 for x < 0, else -3/2.

    Nusse & Yorke, Physica D 57 (1992) 39-57. The fixed point of the left piece, x = mu / (3/4),
    meets the border x = 0 at mu = 0. `jump` is added to x' on the right.
    """

    def right(z: Any) -> Any:
        return z[..., 0] >= 0.0

    def func(z: Any, mu: float, jump: float) -> Floats:
        tau = np.where(right(z), -1.5, 0.5)
        return _points(tau * z[..., 0] + z[..., 1] + mu + jump * right(z), -0.25 * z[..., 0])

    return SmoothMap(
        func,
        lambda z, mu, jump: _rows(
            (np.where(right(z), -1.5, 0.5), 1.0), (-0.25 + 0 * z[..., 0], 0.0)
        ),
        {
            "mu": lambda z, mu, jump: _points(1.0 + 0 * z[..., 0], 0.0),
            "jump": lambda z, mu, jump: _points(1.0 * right(z), 0.0),
        },
        ((-2.0, 2.0), (-2.0, 2.0)),
        (("mu", mu), ("jump", jump)),
        label=lambda z, mu, jump: 1 + right(z),
    )


def plain(func: Function, jacobian: Function, n: int = 2, **values: float) -> SmoothMap:
    """Make a map of a wide box whose parameters are not varied."""
    return SmoothMap(func, jacobian, {}, ((-1e6, 1e6),) * n, tuple(values.items()))


def linear(matrix: ArrayLike) -> SmoothMap:
    """Make x' = A x."""
    a = np.asarray(matrix, dtype=np.float64)
    return plain(lambda z: z @ a.T, lambda z: np.broadcast_to(a, (*z.shape, len(a))), len(a))


def lozi(a: float = 1.7, b: float = 0.5) -> SmoothMap:
    """Make x' = 1 - a |x| + y, y' = b x (Lozi 1978), chaotic at 1.7, 0.5 (Misiurewicz 1980)."""
    return plain(
        lambda z, a, b: _points(1 - a * np.abs(z[..., 0]) + z[..., 1], b * z[..., 0]),
        lambda z, a, b: _rows((-a * np.sign(z[..., 0]), 1.0), (b + 0 * z[..., 0], 0.0)),
        a=a,
        b=b,
    )


def ikeda(u: float = 0.9) -> SmoothMap:
    """Make z' = 1 + u z exp(i (0.4 - 6 / (1 + |z|^2))) (Ikeda 1979; Hammel et al. 1985)."""

    def terms(z: Any, u: float) -> tuple[Any, ...]:
        x, y = z[..., 0], z[..., 1]
        size = 1 + x * x + y * y
        t = 0.4 - 6 / size
        return x, y, u * np.cos(t), u * np.sin(t), 12 * x / size**2, 12 * y / size**2

    def func(z: Any, u: float) -> Floats:
        x, y, c, s, _, _ = terms(z, u)
        return _points(1 + c * x - s * y, s * x + c * y)

    def jacobian(z: Any, u: float) -> Floats:
        x, y, c, s, t_x, t_y = terms(z, u)
        turn, along = -(s * x + c * y), c * x - s * y
        return _rows((c + turn * t_x, -s + turn * t_y), (s + along * t_x, c + along * t_y))

    return plain(func, jacobian, u=u)


def standard(k: float = 1.0, copies: int = 1, coupling: float = 0.0) -> SmoothMap:
    """Make p' = p + k sin t, t' = t + p' (Chirikov 1979), not wrapped; neighbours coupled."""
    eye = np.eye(copies)
    ring = np.roll(eye, 1, axis=0)

    def func(z: Any, k: float) -> Floats:
        t, p = z[..., :copies], z[..., copies:]
        force = k * np.sin(t) + coupling * (np.sin(t @ ring - t) + np.sin(t @ ring.T - t))
        return np.concatenate([t + p + force, p + force], axis=-1)

    def jacobian(z: Any, k: float) -> Floats:
        t = z[..., :copies]
        ahead, behind = np.cos(t @ ring - t), np.cos(t @ ring.T - t)
        own = k * np.cos(t) - coupling * (ahead + behind)
        slope = own[..., None] * eye
        slope += coupling * (ahead[..., None] * ring.T + behind[..., None] * ring)
        return np.concatenate(
            [
                np.concatenate([eye + slope, np.broadcast_to(eye, slope.shape)], axis=-1),
                np.concatenate([slope, np.broadcast_to(eye, slope.shape)], axis=-1),
            ],
            axis=-2,
        )

    return plain(func, jacobian, 2 * copies, k=k)


def towel() -> SmoothMap:
    """Make the folded towel map (Rössler 1979): two directions grow."""

    def func(z: Any) -> Floats:
        x, y, w = np.moveaxis(z, -1, 0)
        return _points(
            3.8 * x * (1 - x) - 0.05 * (y + 0.35) * (1 - 2 * w),
            0.1 * ((y + 0.35) * (1 - 2 * w) - 1) * (1 - 1.9 * x),
            3.78 * w * (1 - w) + 0.2 * y,
        )

    def jacobian(z: Any) -> Floats:
        x, y, w = np.moveaxis(z, -1, 0)
        rows = (
            (3.8 * (1 - 2 * x), -0.05 * (1 - 2 * w), 0.1 * (y + 0.35)),
            (
                -0.19 * ((y + 0.35) * (1 - 2 * w) - 1),
                0.1 * (1 - 2 * w) * (1 - 1.9 * x),
                -0.2 * (y + 0.35) * (1 - 1.9 * x),
            ),
            (0 * x, 0.2 + 0 * x, 3.78 * (1 - 2 * w)),
        )
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    return plain(func, jacobian, 3)
