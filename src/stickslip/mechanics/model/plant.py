"""Numbers of a linear plant with dry contacts, and the coordinates in which it moves."""

# Derivation: docs/theory/plant.md. All functions take complex numbers too: a parameter moved by an
# imaginary step differentiates every number exactly (`derivative`).

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import MOST_KEPT, flag, random_generator, whole_number
from stickslip.numerics.arrays import Floats, Ints, applied
from stickslip.numerics.roots import EPSILON
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike

    from stickslip.mechanics.friction.law import FrictionLaw

Numbers: TypeAlias = NDArray[Any]
"""Real, or complex while they are differentiated."""

ROUNDING: Final = 64 * EPSILON
"""Of the sizes that cancel: what counts as zero."""
TINY: Final = 1e-30
"""The imaginary step: its square is lost, so that derivatives have no error of truncation."""
DEPENDENT: Final = 1e-9
"""Share of a contact's inertia that others leave to it: less is none."""
LARGEST_RATIO: Final = 1000
"""Of two frequencies with a common period: denominators up to this are tried."""


class Reduced(NamedTuple):
    """Coordinates z = (waves, y, w): rows of waves', y', needed forces e and limits L, in order.

    Waves are the cosines, then the sines of the harmonics' angles ``frequency t + phase``. Each row
    is ``matrix z + constant``; ``mass w' = coupling friction - e``. Velocities are ``out_matrix z +
    out_constant``; y begins with the positions.
    """

    mass: Numbers  # (m,): the inertia that each contact acts on
    coupling: Numbers  # (m, m), ones on its diagonal: how far forces act there; (0, 0): ones alone
    matrix: Numbers  # (waves + n + m, waves + n)
    constant: Numbers  # (waves + n + m,)
    frequency: Numbers  # (harmonics,), as phase
    phase: Numbers
    V: Numbers  # (m,), without oscillations
    out_matrix: Numbers  # (velocities, waves + n)
    out_constant: Numbers

    @property
    def n_waves(self) -> int:
        """Two of each harmonic."""
        return 2 * len(self.frequency)

    @property
    def n_free(self) -> int:
        """Coordinates (waves, y) that friction does not act on."""
        return self.matrix.shape[1] - len(self.mass)

    def accelerations(self, forces: Floats) -> Floats:
        """Accelerations at the contacts that forces there give, (m, ...)."""
        shared = self.coupling @ forces if len(self.coupling) else forces
        return np.asarray(shared / self.mass[:, None])

    @property
    def flow(self) -> Floats:
        """Matrix of (y, w)' without friction."""
        own = slice(self.n_waves, self.matrix.shape[1])
        flow = self.matrix[own, own].copy()
        flow[-len(self.mass) :] /= -self.mass[:, None]
        return flow


@lru_cache(maxsize=16)  # a plant is made at every value of a parameter that is looked at
def _bare(n: int) -> tuple[Floats, ...]:
    """Arrays of n masses on one belt that feel nothing else; nobody changes a plant's."""
    shapes = (n, 2 * n), (n,), (n, 0), (0,)
    arrays = np.eye(n), *map(np.zeros, shapes)
    for array in arrays:
        array.flags.writeable = False
    return arrays


@part
@dataclass(frozen=True, eq=False)
class Plant:
    """M v' + C v + K q = force + forcing + into f, q' = v; m contacts with w = out v - V(t).

    A plant in state-space form has no q: K has no columns, and v is the state. Contact c slips with
    ``f_c = -sign(w_c) L_c F_c(|w_c|)``, ``L = static + load (q, v)``.
    """

    mass: Numbers  # (n,), the diagonal, or (n, n)
    stiffness: Numbers  # (n, n), or (n, 0)
    damping: Numbers  # (n, n)
    into: Numbers  # (n, m)
    out: Numbers  # (m, n)
    static: Numbers  # (m,)
    load: Numbers  # (m, positions + n)
    V: Numbers  # (m,)
    force: Numbers  # (n,)
    amplitude: Numbers  # (n, harmonics): cos(frequency t + phase) of forces; of belts:
    belt: Numbers  # (m, harmonics)
    frequency: Numbers  # (harmonics,)
    phase: Numbers
    elastic: tuple[int, ...] = ()  # contacts whose feet, without mass, are the last bodies

    @classmethod
    def on_belt(
        cls, mass: Numbers, stiffness: Numbers, damping: Numbers, static: Numbers, V: Any
    ) -> Plant:
        """Plant each mass of which rubs on one belt."""
        n = len(mass)
        unit, load, force, none, nothing = _bare(n)
        return cls(
            *(mass, stiffness, damping, unit, unit, static, load),
            *(np.full(n, V), force, none, none, nothing, nothing),
        )

    def with_harmonic(self, amplitude: Numbers, belt: Numbers, frequency: Any, phase: Any) -> Plant:
        """Return the plant with one more harmonic of forces and belts."""
        return replace(
            self,
            amplitude=np.column_stack([self.amplitude, amplitude]),
            belt=np.column_stack([self.belt, belt]),
            frequency=np.append(self.frequency, frequency),
            phase=np.append(self.phase, phase),
        )

    def with_feet(self, springs: Mapping[int, Any]) -> Plant:
        """Return the plant with some contacts at the feet of springs of given stiffness."""
        # A foot has its spring's stiffness in place of a mass: what divides the force there.
        if not springs:
            return self
        elastic, k = list(springs), np.array(list(springs.values()))
        n, m, more = len(self.force), self.n_contacts, len(springs)
        reach = np.concatenate([self.out[elastic].T, -np.eye(more)])  # how springs are stretched
        feet = np.eye(m)[:, elastic] @ np.eye(more, n + more, n)
        rigid = ~np.isin(np.arange(m), elastic)

        def beside(array: Numbers) -> Numbers:
            return np.pad(array, [(0, more)] + [(0, more)] * (array.ndim - 1))

        stiff = np.append(np.zeros(n), k)
        mass = beside(self.mass) + (stiff if self.mass.ndim == 1 else np.diag(stiff))
        by_place, by_velocity = np.split(self.load, [n], axis=1)
        wide = [(0, 0), (0, more)]
        return replace(
            self,
            mass=mass,
            stiffness=beside(self.stiffness) + reach * k @ reach.T,
            damping=beside(self.damping),
            into=np.pad(self.into * rigid, wide[::-1]) + feet.T,
            out=np.pad(self.out * rigid[:, None], wide) + feet,
            load=np.concatenate([np.pad(by_place, wide), np.pad(by_velocity, wide)], axis=1),
            force=beside(self.force),
            amplitude=np.pad(self.amplitude, wide[::-1]),
            elastic=tuple(elastic),
        )

    @property
    def n_bodies(self) -> int:
        """Number of velocities but for those of feet."""
        return len(self.mass) - len(self.elastic)

    @property
    def n_contacts(self) -> int:
        """Number of contacts, which are the blocks where each block rubs."""
        return len(self.static)

    @property
    def n_positions(self) -> int:
        """Number of positions q: none in state-space form."""
        return self.stiffness.shape[1]

    @property
    def is_forced(self) -> bool:
        """Whether anything depends on time."""
        return bool(self.amplitude.any() or self.belt.any())

    @cached_property
    def period(self) -> float:
        """Common period of the harmonics; ValueError if there is none."""
        moving = self.amplitude.any(axis=0) | self.belt.any(axis=0)
        frequencies = np.unique(self.frequency[moving]).tolist()
        lowest, turns = frequencies[0], 1
        for other in frequencies[1:]:
            ratio = Fraction(other / lowest).limit_denominator(LARGEST_RATIO)
            if abs(other * ratio.denominator - lowest * ratio.numerator) > ROUNDING * other:
                raise ValueError(
                    f"the frequencies {lowest!r} and {other!r} have no common period: a "
                    "stroboscopic map and periodic motions need one."
                )
            turns = math.lcm(turns, ratio.denominator)
        return float(2.0 * np.pi * turns / lowest)

    @cached_property
    def rubs_as_one(self) -> bool:
        """Whether each mass rubs and all are carried alike: global stick phases are a section."""
        n = len(self.mass)
        unit, *_ = _bare(n)
        alike = self.into.shape == unit.shape and self.n_positions == n
        alike = alike and all(
            each is unit or bool((each == unit).all()) for each in (self.into, self.out)
        )
        alike = alike and not self.load.any() and bool((self.V == self.V[0]).all())
        # Masses on a diagonal share no inertia.
        return alike and (self.mass.ndim == 1 or not self.is_coupled) and not self.elastic

    @property
    def standing(self) -> Floats:
        """Forces that blocks of `rubs_as_one` need at x = 0 to ride on: V C 1 - g."""
        return np.asarray(self.V * self.damping.sum(axis=1) - self.force)

    @cached_property
    def dissipates(self) -> bool:
        """Whether energy bounds motions about steady sliding: springs pull back, dampers take."""
        has_springs = self.rubs_as_one and self.stiffness.any()
        if not has_springs or self.n_waves or not self.V[0] > 0.0:
            return False
        for matrix, least in ((self.stiffness, ROUNDING), (self.damping, -ROUNDING)):
            if not matrix.any():
                continue
            size = np.abs(matrix).max()
            if np.abs(matrix - matrix.T).max() > ROUNDING * size:
                return False
            # Gershgorin's bound of the eigenvalues is found sooner, and mostly enough.
            bound = (2.0 * matrix.diagonal() - np.abs(matrix).sum(axis=1)).min()
            if bound < least * size and np.linalg.eigvalsh(matrix)[0] < least * size:
                return False
        return True

    @cached_property
    def turning(self) -> Floats:
        """Columns: velocities that no spring feels; any, in state-space form."""
        return unfelt(self.stiffness) if self.n_positions else np.eye(len(self.mass))

    @cached_property
    def turns(self) -> Floats:
        """Columns: changes of (y, w) that nothing feels, as a free rotor turned as a whole."""
        own = self.reduced.matrix[self.n_waves :, self.n_waves :]
        ahead = own.shape[1] - self.n_contacts
        rubs = np.pad(self.gathered, ((0, 0), (ahead, 0)))  # what friction feels
        return unfelt(np.concatenate([own, rubs]))

    def felt(self, change: Floats) -> Floats:
        """Leave out of changes of (y, w), shape (..., n), what nothing feels."""
        return np.asarray(change - change @ self.turns @ self.turns.T)

    def ways(self, varies: NDArray[np.bool_]) -> Floats:
        """Columns: independent changes of what varies of (y, w), that something feels."""
        all_ways = np.eye(len(varies))
        if not self.turns.size:
            return all_ways[:, varies]
        # What is held belongs to the rows: of turns that contacts hold only rounding would be left.
        ways = unfelt(np.concatenate([self.turns.T, all_ways[~varies]]))
        return np.where(varies[:, None], ways, 0.0)

    # --- coordinates -------------------------------------------------------------------------

    @cached_property
    def is_coupled(self) -> bool:
        """Whether contacts share inertia: C B is not diagonal."""
        touches = (self.into != 0.0) | (self.out.T != 0.0)
        if self.mass.ndim == 1 and touches.sum(axis=1).max() <= 1:
            return False  # no body has two
        own = np.sqrt(np.diag(self.response))
        share = self.response / np.outer(own, own)
        shared = (np.abs(share) > ROUNDING) | (np.imag(share) != 0.0)
        return bool(shared.sum() > self.n_contacts)

    @property
    def response(self) -> Numbers:
        """What forces at contacts do to the accelerations there, C B, (m, m)."""
        return self.out @ solved(self.mass, self.into)

    @cached_property
    def independent(self) -> Ints:
        """Contacts whose velocities tell those of all others."""
        if not self.is_coupled:
            return np.arange(self.n_contacts)
        from scipy.linalg import qr

        own = np.sqrt(np.diag(self.response))
        _, upper, order = qr(self.response / np.outer(own, own), pivoting=True)
        return np.sort(order[np.abs(np.diag(upper)) > DEPENDENT])

    @cached_property
    def spread(self) -> Floats:
        """Velocities at all contacts from those at the independent ones, (m, independent)."""
        m, basis = self.n_contacts, self.independent
        if len(basis) == m:
            return np.eye(m)
        return np.asarray(np.linalg.lstsq(self.out[basis].T, self.out.T)[0].T)

    @cached_property
    def gathered(self) -> Floats:
        """Velocities at the independent contacts from those at all, (independent, m)."""
        return np.asarray(np.linalg.pinv(self.spread))

    @cached_property
    def mechanisms(self) -> Floats:
        """Ways to slip, a row each: velocities at contacts, as few of them moving as possible."""
        m, rank = self.n_contacts, len(self.independent)
        if rank == m:
            return np.eye(m)
        ways: dict[tuple[int, ...], Floats] = {}
        for resting in itertools.combinations(range(m), rank - 1):
            across = unfelt(self.spread[list(resting)]) if resting else np.eye(rank)
            if across.shape[1] == 1:
                way = self.spread @ across[:, 0]
                way = np.where(np.abs(way) > DEPENDENT * np.abs(way).max(), way, 0.0)
                ways[tuple(np.flatnonzero(way))] = way / np.abs(way).max()
        return np.array(list(ways.values()))

    @cached_property
    def kept(self) -> Ints:
        """Velocities that stay coordinates of y, once friction is projected out of them."""
        n, rank = len(self.mass), len(self.independent)
        if n == rank:
            return np.zeros(0, dtype=np.int64)
        from scipy.linalg import qr  # not for the first value of a map

        _, _, order = qr((np.eye(n) - self.lead(self) @ self.out).T, pivoting=True)
        return np.sort(order[: n - rank])

    def lead(self, of: Plant) -> Numbers:
        """Velocities from those at contacts, which friction changes alone; as `reduction`."""
        inert = solved(self.mass, self.into)
        if not of.is_coupled:
            return inert / np.einsum("cn,nc->c", self.out, inert)
        inverse = np.linalg.inv(self.response[np.ix_(of.independent, of.independent)])
        return np.asarray(inert @ of.gathered.T @ inverse @ of.gathered)

    @cached_property
    def reduced(self) -> Reduced:
        """The plant in the coordinates (y, w)."""
        return self.reduction(self)

    def reduction(self, of: Plant) -> Reduced:
        """Reduce the plant to the coordinates of another, that it is or has been moved from."""
        n, m = self.into.shape
        kept = of.kept
        n_q, n_u = self.n_positions, len(kept)
        inert = solved(self.mass, self.into)
        response = np.einsum("cn,nc->c", self.out, inert)
        needed = solved(self.mass.T, self.out.T).T / response[:, None]
        mass = np.einsum("cn,nc->c", needed, times(self.mass, inert / response))
        coupling = np.zeros((0, 0))
        if of.is_coupled:
            coupling = self.response / response[:, None]
            np.fill_diagonal(coupling, 1.0)
        lead = self.lead(of)
        free = np.zeros((n_u, n))
        spread = np.zeros((n, n_u))
        if n_u:
            project = np.eye(n) - lead @ self.out
            spread = project[:, kept] @ np.linalg.inv(project[np.ix_(kept, kept)])
            free = solved(self.mass.T, project[kept].T).T
        h = len(self.frequency)
        still, rest = np.zeros((n, h)), np.zeros((n, n_u + m))
        out = np.concatenate([lead @ self.belt, still, np.zeros((n, n_q)), spread, lead], axis=1)
        acting = np.concatenate([-self.amplitude, still, self.stiffness, rest], axis=1)
        pull = self.damping @ out + acting
        inert_contacts = ~np.isin(np.arange(m), self.elastic)
        swaying = np.zeros((m, h)), (mass * inert_contacts)[:, None] * self.belt * self.frequency
        inertia = np.concatenate([*swaying, np.zeros((m, n_q + n_u + m))], axis=1)
        out_constant = lead @ self.V
        pull_constant = self.damping @ out_constant - self.force
        positions = np.eye(n_q, out.shape[1], 2 * h)
        turning = np.kron([[0.0, -1.0], [1.0, 0.0]], np.diag(self.frequency))
        return Reduced(
            mass=mass,
            coupling=coupling,
            matrix=np.concatenate(
                [
                    np.pad(turning, ((0, 0), (0, n_q + n_u + m))),
                    out[:n_q],
                    -free @ pull,
                    needed @ pull - inertia,
                    self.load @ np.concatenate([positions, out]),
                ]
            ),
            constant=np.concatenate(
                [
                    np.zeros(2 * h),
                    out_constant[:n_q],
                    -free @ pull_constant,
                    needed @ pull_constant,
                    self.static + self.load[:, n_q:] @ out_constant,
                ]
            ),
            frequency=self.frequency,
            phase=self.phase,
            V=self.V,
            out_matrix=out,
            out_constant=out_constant,
        )

    # --- states ------------------------------------------------------------------------------

    def split(self, x: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Positions and velocities of a state as users give it; its own inverse."""
        return (x, v) if self.n_positions else (v, x)

    @property
    def n_waves(self) -> int:
        """Two of each harmonic."""
        return 2 * len(self.frequency)

    def waves(self, t: ArrayLike) -> Floats:
        """Cosines, then sines of the harmonics, shape (..., waves)."""
        angle = np.asarray(t, dtype=np.float64)[..., None] * self.frequency + self.phase
        return np.concatenate([np.cos(angle), np.sin(angle)], axis=-1)

    def oscillation(self, t: ArrayLike) -> Floats:
        """Cosines of the harmonics, shape (..., harmonics)."""
        return self.waves(t)[..., : len(self.frequency)]

    def belts(self, t: ArrayLike) -> Floats:
        """Velocities V(t) that the contacts rub on, shape (..., m)."""
        return np.asarray(self.V + self.oscillation(t) @ self.belt.T)

    def forces(self, t: ArrayLike) -> Floats:
        """Return the forces on the masses that depend on time alone, shape (..., n)."""
        return np.asarray(self.force + self.oscillation(t) @ self.amplitude.T)

    def coordinates(self, x: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0) -> Floats:
        """Coordinates z = (y, w) of states; w is 0 where rounding explains the difference."""
        q, v = self.split(np.asarray(x, dtype=np.float64), np.asarray(v, dtype=np.float64))
        belt, reached = self.belts(t), applied(self.out, v)
        lead = self.reduced.out_matrix[:, self.reduced.n_free :]
        free = (v - applied(lead, reached))[..., self.kept]
        y, w = np.concatenate([q, free], axis=-1), reached - belt
        ahead, along = self._rounding
        told = applied(ahead, np.abs(reached) + np.abs(belt)) + applied(along, np.abs(y))
        return np.concatenate([y, np.where(np.abs(w) <= told, 0.0, w)], axis=-1)

    @cached_property
    def _rounding(self) -> tuple[Floats, Floats]:
        """Bounds of what `states` makes of w = 0, per velocity at a contact and per y."""
        # Velocities of contacts that depend on each other are their own image: only there is
        # what the first product gives rounding.
        first, n = self.reduced.n_free, self.n_waves
        along, lead = np.split(self.reduced.out_matrix[:, n:], [first - n], axis=1)
        image = self.out @ lead
        unit = EPSILON * (len(self.mass) + n + self.reduced.out_matrix.shape[1])  # a term each
        size = unit * np.abs(self.out)
        return (
            np.abs((image - np.eye(len(image))) @ image) + size @ np.abs(lead),
            np.abs(self.out @ along) + size @ np.abs(along),
        )

    def states(self, z: Floats, t: ArrayLike = 0.0) -> tuple[Floats, Floats]:
        """Displacements and velocities at coordinates z."""
        r, n = self.reduced, self.n_waves
        v = z @ r.out_matrix[:, n:].T + r.out_constant + self.waves(t) @ r.out_matrix[:, :n].T
        return self.split(z[..., : self.n_positions], v)

    @cached_property
    def jacobians(self) -> tuple[Floats, Floats]:
        """Derivatives of states in coordinates z, and of z in states."""
        n_q, n = self.n_positions, len(self.mass)
        lead = self.reduced.out_matrix[:, self.reduced.n_free :]
        out = self.reduced.out_matrix[:, self.n_waves :]
        states = np.concatenate([np.eye(n_q, out.shape[1]), out])
        free = (np.eye(n) - lead @ self.out)[self.kept]
        own = np.concatenate([np.zeros((n_q, n)), free, self.out])
        return states, np.concatenate([np.eye(len(own), n_q), own], axis=1)

    def period_change(self, change: Reduced | None) -> float:
        """Change of the common period; ValueError where there would be none any more."""
        own = np.zeros(0) if change is None else np.asarray(change.frequency)
        if not self.is_forced or not own.any():
            return 0.0
        rates = own / self.frequency
        if np.ptp(rates) > 0.0:
            raise ValueError(
                "one of several frequencies is no parameter of a return map or a stroboscopic map: "
                "with it the forces would lose their common period, and the phase its meaning."
            )
        return float(-self.period * rates[0])

    def states_change(self, z: Floats, t: ArrayLike, change: Reduced) -> Floats:
        """Change at fixed z of the states (positions, velocities), shape (..., n)."""
        waves = self.waves(t)
        turned = change.phase + np.asarray(t)[..., None] * change.frequency
        cosine, sine = np.split(waves, 2, axis=-1)
        moved = np.concatenate([-sine * turned, cosine * turned], axis=-1)
        at = np.concatenate([waves, z], axis=-1)
        v = at @ change.out_matrix.T + change.out_constant
        v += moved @ self.reduced.out_matrix[:, : self.n_waves].T
        return np.concatenate([np.zeros((*v.shape[:-1], self.n_positions)), v], axis=-1)

    def rows(self, z: Floats, t: ArrayLike = 0.0) -> tuple[Floats, Floats, Floats]:
        """Rates y', needed forces and static limits at coordinates z."""
        r, n = self.reduced, self.n_waves
        values = applied(r.matrix[n:, n:], z) + r.constant[n:] + self.waves(t) @ r.matrix[n:, :n].T
        free = r.n_free - n
        m = free + self.n_contacts
        return values[..., :free], values[..., free:m], values[..., m:]

    def needed(self, z: Floats, t: Floats, mode: Ints, laws: Sequence[FrictionLaw]) -> Floats:
        """Force that each contact needs in order to stick, all others going on in their modes.

        Of sticking contacts that depend on each other, the least forces; all (k, m).
        """
        _, own, limits = self.rows(z, t)
        if not self.is_coupled:
            return own
        m, coupling = self.n_contacts, self.reduced.coupling
        slip = sliding_friction(laws, limits, z[:, -m:], mode)
        needed = np.empty_like(own)
        for modes, k in itertools.product(np.unique(mode, axis=0), range(m)):
            at = (mode == modes).all(axis=1)
            held = (modes == 0) | (np.arange(m) == k)
            pull = own[at][:, held] - slip[at][:, ~held] @ coupling[np.ix_(held, ~held)].T
            inverse = np.linalg.pinv(coupling[np.ix_(held, held)], rcond=DEPENDENT)
            needed[at, k] = pull @ inverse[held[:k].sum()]
        return needed

    def momenta(self, v: Floats) -> Floats:
        """Momenta of velocities, (..., n)."""
        bodies = v * (np.arange(len(self.mass)) < self.n_bodies)
        return np.asarray(bodies * self.mass if self.mass.ndim == 1 else bodies @ self.mass)

    def elastic_energy(self, x: Floats) -> Floats:
        """Energy of the springs at displacements, shape (...)."""
        return np.asarray(0.5 * np.sum(x * (x @ self.stiffness), axis=-1))

    def needed_force(self, x: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0) -> Floats:
        """Force that keeps each contact sticking, shape (..., m); (..., n) as `x` and `v`."""
        return self.rows(self.coordinates(x, v, t), t)[1]

    def with_relaxed_feet(self, x: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Displacements and velocities of bodies and of feet that stick, springs relaxed."""
        feet = list(self.elastic)
        n = self.n_bodies
        springs = np.diag(self.stiffness)[n:]
        places = -(self.stiffness[n:, :n] @ x) / springs
        return np.append(x, places), np.append(v, self.belts(0.0)[feet])

    def limits(self, x: Floats, v: Floats) -> Floats:
        """Return the static limits of the contacts, (..., m)."""
        return np.asarray(self.static + np.concatenate(self.split(x, v), axis=-1) @ self.load.T)

    def travel(self, x: Floats, t: float) -> Floats:
        """How far what each contact rubs on has left it behind; NaN without positions."""
        if not self.n_positions:
            return np.full(self.n_contacts, np.nan)
        turned = np.sin(self.frequency * t + self.phase) / self.frequency
        return np.asarray(self.V * t + self.belt @ turned - x @ self.out.T)

    @cached_property
    def neighbours(self) -> list[list[int]]:
        """Contacts that each is coupled to: directly, or through masses that do not rub."""
        from scipy.sparse.csgraph import connected_components  # loads linear algebra

        own = (self.into != 0.0) | (self.out != 0.0).T
        linked = self.damping != 0.0
        linked |= (self.stiffness if self.n_positions else self.damping) != 0.0
        linked |= np.diag(self.mass) != 0.0 if self.mass.ndim == 1 else self.mass != 0.0
        linked |= linked.T
        free = np.flatnonzero(~own.any(axis=1))
        _, group = connected_components(linked[np.ix_(free, free)], directed=False)
        for number in np.unique(group):
            beside = linked[free[group == number]].any(axis=0)
            linked |= np.outer(beside, beside)
        coupled = own.T.astype(np.int64) @ linked @ own > 0
        return [np.flatnonzero(row).tolist() for row in coupled & ~np.eye(len(coupled), dtype=bool)]

    def sample_state(
        self, rng: np.random.Generator | int | None, *, riding: bool, speed: float
    ) -> tuple[Floats, Floats]:
        """Draw a legal state, displacements and velocities, slip up to `speed`; see `BeltModel`."""
        generator = random_generator("rng", rng)
        m, n_waves = self.n_contacts, self.n_waves
        n_free = self.reduced.n_free - n_waves
        w = np.zeros(m) if flag("riding", riding) else generator.uniform(-speed, speed, size=m)
        z = np.concatenate([np.zeros(n_free), w])
        rest = self.rows(z)[1]
        first = self.reduced.n_free
        rows = self.reduced.matrix[first : first + m, n_waves:first]
        force = generator.uniform(-self.static, self.static)
        if self.is_coupled:
            force = self.reduced.coupling @ force
        z[:n_free] = np.linalg.lstsq(rows, force - rest)[0]
        return self.states(z)

    def sample_sticking(self, n: int, rng: np.random.Generator | int | None = None) -> Floats:
        """Draw positions, shape (n, masses), with all contacts sticking; uniform needed forces."""
        n = whole_number("n", n, 0, at_most=MOST_STATES)
        return self.sticking(random_generator("rng", rng).uniform(size=(n, self.n_contacts)))

    def sticking(self, share: ArrayLike) -> Floats:
        """Positions with needed forces at a `share` of their limits: 0 lower, 1 upper."""
        force = self.static * (2.0 * np.asarray(share) - 1.0)
        return np.asarray(np.linalg.solve(self.stiffness, (force - self.standing).T).T)


MOST_STATES: Final = 100 * MOST_KEPT
"""That may be drawn at once."""


def sliding_friction(laws: Sequence[FrictionLaw], limits: Floats, w: Floats, mode: Ints) -> Floats:
    """Friction forces of slipping contacts, shape (..., m); 0 of those that stick."""
    force = np.zeros(w.shape)
    for k, law in enumerate(laws):
        for sign in (-1, 1):
            slips = mode[..., k] == sign
            speed = np.maximum(sign * w[..., k][slips], 0.0)
            force[..., k][slips] = (
                -sign * limits[..., k][slips] * law.force(speed, forward=sign > 0)
            )
    return force


def unfelt(matrix: Floats) -> Floats:
    """Orthonormal columns that a matrix takes to nothing."""
    from scipy.linalg import null_space  # not for the first value of a map

    return np.asarray(null_space(matrix, rcond=ROUNDING))


def solved(mass: Numbers, right: Numbers) -> Numbers:
    """Apply the inverse of a mass matrix."""
    return right / mass[:, None] if mass.ndim == 1 else np.asarray(np.linalg.solve(mass, right))


def times(mass: Numbers, right: Numbers) -> Numbers:
    """Apply a mass matrix."""
    return np.asarray(mass[:, None] * right if mass.ndim == 1 else mass @ right)


def derivative(shifted: Reduced) -> Reduced:
    """Read the derivative off a plant that was reduced at a parameter plus ``TINY`` i."""
    return Reduced(*(np.imag(field) / TINY for field in shifted))
