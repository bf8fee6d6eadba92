"""Small motions about steady sliding: eigenvalues, and the friction laws' higher derivatives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np

from stickslip.mechanics.friction.code import law_code
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.orders import orders
from stickslip.mechanics.model.plant import unfelt

if TYPE_CHECKING:
    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.mechanics.model.plant import Plant
    from stickslip.numerics.arrays import Complexes, Floats


Model: TypeAlias = BeltModel

STILL: Final = 1e-9  # a slip so slow that friction is that of its beginning
WIDE: Final = np.geomspace(1e-6, 1e3, 400)  # of a typical speed: where balances are looked for
NEAR: Final = np.geomspace(0.8, 1.25, 9)  # of the last speed, likewise


class Modes(NamedTuple):
    """Linear motions about steady sliding: z' = matrix z; of blocks z = (displacements, w)."""

    matrix: Floats
    values: Complexes  # by descending real part, 0 if within rounding; without free turning
    vectors: Complexes  # columns


class Steady(NamedTuple):
    """A motion in which all contacts slip at constant velocities."""

    x: Floats  # displacements; of what turns freely, from its middle place
    v: Floats
    w: Floats  # at the contacts


def steady_states(model: Model, V: float = math.nan, near: Floats | None = None) -> list[Steady]:
    """Steady sliding of a model, with all contacts on belts of speed V (NaN: their own).

    Of what turns freely, all that is found, or that `near` given velocities of slip if there is.
    """
    plant = _at_speed(model, V)
    if not plant.turning.shape[1]:
        speeds = [-plant.V] if plant.V.all() else []
    else:
        speeds = [] if near is None else _possible_speeds(plant, model.laws, near, NEAR)
        if not speeds:
            everywhere = _balance(plant, model.laws, np.array([[-STILL], [STILL]]))[2] - plant.V
            size = max(float(np.abs(everywhere).max()), float(np.abs(plant.V).max()), STILL)
            sides = np.sign(everywhere[0]) + (everywhere[0] == 0.0)
            speeds = _possible_speeds(plant, model.laws, size * sides, WIDE)
    try:
        found = [_steady(plant, model.laws, w) for w in speeds]
    except np.linalg.LinAlgError:  # loads make the balance singular
        return []
    return [each for each in found if (plant.limits(each.x, each.v) > 0.0).all()]  # else one opens


def _steady(plant: Plant, laws: Sequence[FrictionLaw], w: Floats) -> Steady:
    q, v, reached = (values[0] for values in _balance(plant, laws, w[None]))
    return Steady(*plant.split(q, v), reached - plant.V)


def _at_speed(model: Model, V: float) -> Plant:
    plant = model.plant
    if math.isnan(V):
        return plant
    moved = replace(plant, V=np.full(plant.n_contacts, V))
    vars(moved)["turning"] = plant.turning  # springs know nothing of belts
    return moved


def _balance(plant: Plant, laws: Sequence[FrictionLaw], w: Floats) -> tuple[Floats, Floats, Floats]:
    """Positions, velocities, and velocities at contacts where forces balance at slips (k, m)."""
    n_q, turning, guides = plant.n_positions, plant.turning, _guides(plant)
    share = np.sign(w) * _forces(laws, w * np.ones(plant.n_contacts))  # friction: -share * limit
    drag = plant.into * share[:, None]
    damping = plant.damping + plant.into * guides @ plant.out
    matrix = _matrix(
        plant, plant.stiffness + drag @ plant.load[:, :n_q], damping + drag @ plant.load[:, n_q:]
    )
    force = plant.force - drag @ plant.static + (guides * (plant.V + w)) @ plant.into.T
    rest = np.zeros((len(w), matrix.shape[1] - force.shape[1]))
    unknown = np.linalg.solve(matrix, np.concatenate([force, rest], axis=1)[..., None])[..., 0]
    v = unknown[:, n_q:] @ turning.T
    return unknown[:, :n_q], v, v @ plant.out.T


def _matrix(plant: Plant, stiffness: Floats, damping: Floats) -> Floats:
    """Say what forces positions and turning make, and where the middle of what turns is."""
    turning = plant.turning
    matrix = np.concatenate([stiffness, damping @ turning], axis=-1)
    if not plant.n_positions:
        return matrix
    gauge = np.zeros((*matrix.shape[:-2], turning.shape[1], matrix.shape[-1]))
    gauge[..., : plant.n_positions] = turning.T
    return np.concatenate([matrix, gauge], axis=-2)


@lru_cache(maxsize=64)
def _guides(plant: Plant) -> Floats:
    """Return dampers, one at each contact, between its velocity and that of the slip asked for.

    None but where something turns that no damper feels, whose speed friction alone decides. Their
    forces vanish where both velocities agree: in steady sliding.
    """
    if not unfelt(_matrix(plant, plant.stiffness, plant.damping)).size:
        return np.zeros(plant.n_contacts)
    guides = plant.static / orders(plant).velocity
    damping = plant.damping + plant.into * guides @ plant.out
    if unfelt(_matrix(plant, plant.stiffness, damping)).size:
        raise ValueError(
            "what turns freely has no steady speed of its own where neither dampers nor contacts "
            "feel it: any will do. Give it a damper or a spring."
        )
    return guides


def _forces(laws: Sequence[FrictionLaw], w: Floats) -> Floats:
    columns = [
        np.where(s > 0.0, law.force(np.abs(s), forward=True), law.force(np.abs(s)))
        for law, s in zip(laws, w.T, strict=True)
    ]
    return np.array(columns).T


def _possible_speeds(
    plant: Plant, laws: Sequence[FrictionLaw], around: Floats, factors: Floats
) -> list[Floats]:
    """Slip velocities with which what turns freely can go on: roots of one equation, or one set."""
    from scipy.optimize import brentq, root  # not for the first value

    def residual(w: Floats) -> Floats:
        return np.asarray(_balance(plant, laws, w[None])[2][0] - plant.V - w)

    if plant.n_contacts > 1:
        found = root(residual, around, tol=1e-14)
        return [found.x] if found.success else []
    speeds = []
    for side in (-1.0, 1.0):
        grid = side * abs(around[0]) * factors
        off = (_balance(plant, laws, grid[:, None])[2] - plant.V - grid[:, None])[:, 0]
        for k in np.flatnonzero(off[:-1] * off[1:] < 0.0):
            ends = grid[k], grid[k + 1]
            w = brentq(lambda s: float(residual(np.array([s]))[0]), *ends, xtol=1e-300, rtol=1e-15)
            speeds.append(np.array([w]))
    return speeds


def steady_displacements(model: Model, V: float) -> Floats:
    """Displacements of the first steady sliding at a belt speed (NaN: the belts' own)."""
    return steady_states(model, V)[0].x


def modes(model: Model, V: float) -> Modes:
    """Small motions about the first steady sliding at a belt speed (NaN: the belts' own)."""
    return modes_about(model.plant, model.laws, steady_states(model, V)[0])


def modes_about(plant: Plant, laws: Sequence[FrictionLaw], steady: Steady) -> Modes:
    """Small motions about steady sliding: the flow linearised."""
    w, m, reduced = steady.w, plant.n_contacts, plant.reduced
    side, limits = np.sign(w), plant.limits(steady.x, steady.v)
    matrix, load = reduced.flow, reduced.matrix[-m:, plant.n_waves :]
    pairs = zip(laws, w.tolist(), strict=True)
    slopes = [float(law.slope(abs(s), forward=s > 0.0)) for law, s in pairs]
    friction = (side * _forces(laws, w[None])[0])[:, None] * load
    friction[:, -m:] += np.diag(limits * slopes)
    matrix[-m:] -= reduced.accelerations(friction)
    return _sorted_modes(matrix, plant, friction)


def linear_modes(model: Model) -> Modes:
    """Motions of the plant without friction."""
    return _sorted_modes(model.plant.reduced.flow, model.plant)


def _sorted_modes(matrix: Floats, plant: Plant, friction: Floats | float = 0.0) -> Modes:
    if plant.elastic:
        matrix = _without_feet(matrix, plant, friction)
    values, vectors = _eigenvalues(matrix)
    if plant.n_positions:
        zeros = plant.turning.shape[1] + plant.n_contacts - len(plant.independent)
        kept = np.sort(np.argsort(np.abs(values))[zeros:])
        values, vectors = values[kept], vectors[:, kept]
    order = np.lexsort((-values.imag, -values.real))
    return Modes(matrix, values[order], vectors[:, order])


def _eigenvalues(matrix: Floats) -> tuple[Complexes, Complexes]:
    """Eigenvalues and vectors; a real part that rounding explains is 0."""
    from scipy.linalg import eig, matrix_balance  # not for the first value

    # A change E of the matrix moves an eigenvalue with the vectors y (left) and x by
    # y^H E x / (y^H x). Rounding is a real E, of the size of n eps times the balanced matrix.
    balanced, scale = matrix_balance(matrix)
    found: Any = eig(balanced, left=True, right=True)
    values, left, right = found
    rounding = len(matrix) * np.finfo(float).eps * float(np.linalg.norm(balanced))
    for k, (y, x) in enumerate(zip(left.T.conj(), right.T, strict=True)):
        along = y @ x  # 0 where modes meet
        felt = float(np.linalg.norm((np.outer(y, x) * np.conj(along)).real))
        if abs(values[k].real) * abs(along) ** 2 <= rounding * felt:
            values[k] = 1j * values[k].imag
    return values.astype(complex), (scale @ right).astype(complex)


def _without_feet(matrix: Floats, plant: Plant, friction: Floats | float) -> Floats:
    """Flow of all but sliding feet, which keep e + friction at 0 and have no inertia."""
    m, feet = plant.n_contacts, list(plant.elastic)
    n_free, first = plant.reduced.n_free, plant.n_waves
    places = plant.n_bodies + np.arange(len(feet))
    held = (plant.reduced.matrix[n_free : n_free + m, first:] + friction)[feet]
    gone = np.concatenate([places, len(matrix) - m + np.array(feet)])
    kept = np.delete(np.arange(len(matrix)), gone)
    follow = -np.linalg.solve(held[:, places], held[:, kept])
    return np.asarray(matrix[np.ix_(kept, kept)] + matrix[np.ix_(kept, places)] @ follow)


def force_derivatives(model: Model, V: float) -> Floats | None:
    """First three derivatives of every law at a slip speed, shape (N, 3); None without a series."""
    code = law_code(model.laws)
    if code.series is None:
        return None
    derivatives = np.empty((model.n_blocks, 3))
    for i, law in enumerate(model.laws):
        row = code.parameter_row(law, V)
        series = np.zeros((code.N_ROWS, 4))
        series[0, :2] = V, 1.0
        for k in range(4):
            code.series(row, -1, series, k)
        derivatives[i] = series[code.FORCE_ROW, 1:] * [math.factorial(k) for k in (1, 2, 3)]
    return derivatives
