"""Normal forms of flips and of Neimark-Sacker bifurcations of maps of R^n."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

import numpy as np

from stickslip.analysis.maps.differences import (
    extrapolated_difference,
    extrapolated_second_difference,
)
from stickslip.analysis.maps.protocol import mix_labels
from stickslip.analysis.maps.protocol_nd import reduced, sample
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats
    from stickslip.analysis.maps.protocol_nd import MapND

FEW_STEPS: Final = 14  # of differences: down to 2e-6 of the domain
RESONANT: Final = 1e-6  # distance of a power of the critical multiplier from 1


@dataclass(frozen=True)
class Coefficient:
    """Cubic coefficient of the critical map: u -> -u + c u^3, or |u| -> |u| + a |u|^3."""

    kind: str
    value: float
    error: float

    @property
    def criticality(self) -> Literal["super", "sub"] | None:
        """``super`` if what is born is stable (c > 0, a < 0); None if the error leaves it open."""
        if not abs(self.value) > self.error:
            return None
        return "super" if (self.value > 0) == (self.kind == "flip") else "sub"


class Forms(NamedTuple):
    """Jacobian of f^p at a point, and its derivatives along the axes, with errors."""

    a: Floats  # (n, n)
    b: Floats  # (n, n, n): of a, along the first axis
    b_error: Floats
    c: Floats  # (n, n, n, n): of b, along the first axis
    c_error: Floats


def coefficient(f: MapND, points: Floats, kind: str) -> Coefficient:
    """Find the cubic coefficient of a flip or Neimark-Sacker bifurcation at an orbit (p, n)."""
    # Kuznetsov, Elements of Applied Bifurcation Theory, 5.4.
    forms = _forms(f, points)
    multipliers, right = np.linalg.eig(forms.a)
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
        if min(map(abs, resonances), default=1.0) < RESONANT:
            return Coefficient(kind, np.nan, np.inf)
        mean = np.linalg.solve(eye - forms.a, _two(forms.b, q, q.conj()))
        twice = np.linalg.solve(m * m * eye - forms.a, _two(forms.b, q, q)) if resonances else mean
        # At a flip m^2 = 1: both are one term, which counts three times.
        cubic = _three(forms.c, q, q, q.conj())
        cubic = cubic + 2.0 * _two(forms.b, q, mean) + _two(forms.b, q.conj(), twice)
        share = 0.5 * m.conjugate() if resonances else 1.0 / 6.0
        value = float((share * (p.conj() @ cubic)).real)
        sizes = np.abs(q), np.abs(mean), np.abs(twice)
        doubt = _three(forms.c_error, *(3 * [sizes[0]]))
        doubt = doubt + 4.0 * _two(forms.b_error, sizes[0], sizes[1] + sizes[2])
        error = float(abs(share) * (np.abs(p) @ doubt))
    return Coefficient(kind, value, error if np.isfinite(error) else np.inf)


def _two(b: Floats, u: Any, v: Any) -> Any:
    return np.einsum("ijk,i,k->j", b, u, v)


def _three(c: Floats, u: Any, v: Any, w: Any) -> Any:
    return np.einsum("hijk,h,i,k->j", c, u, v, w)


def _forms(f: MapND, points: Floats) -> Forms:
    """Differentiate the Jacobian of f^p at the first point, along axes and diagonals."""
    p, n = points.shape
    size = np.ptp(f.spread(256), axis=0)
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
    return Forms(jacobian, b[:n] / one, b_error[:n] / one, c / two, c_error / two)


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
