"""Plants with dry contacts, plainly: positions and velocities, scipy's integrator, its events."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

import stickslip as ss
from stickslip.mechanics.model.contact import weights_of

Floats = NDArray[np.float64]


SAME_TIME = 1e-7
AT_REST = 1e-12  # relative velocity after the integrator's search for zero


class Motion(NamedTuple):
    """Where a motion ended, and its changes of mode: time, contact from 0, new mode."""

    t: float
    q: Floats
    v: Floats
    events: list[tuple[float, int, int]]
    lost: bool


class Plain:
    """Equations of a structure in positions and velocities, from its own matrices."""

    def __init__(self, model: ss.Structure) -> None:
        self.contacts = model.contacts
        self.mass = np.diag(model.mass) if np.ndim(model.mass) == 1 else np.asarray(model.mass)
        self.stiffness, self.damping = np.asarray(model.stiffness), np.asarray(model.damping)
        n = len(self.mass)
        self.n = n
        self.choices = 0
        self.force = np.zeros(n) if model.force is None else np.asarray(model.force)
        self.waves = [(np.array(w.amplitudes(n)), w) for w in model.forcing or ()]
        self.b = np.array([weights_of(c, n, "contact") for c in self.contacts])
        self.inverse = np.linalg.inv(self.mass)
        self.response = self.b @ self.inverse @ self.b.T

    def belt(self, k: int, t: float) -> tuple[float, float]:
        """Velocity and acceleration of what contact k rubs on."""
        speed, wave = self.contacts[k].belt
        if wave is None:
            return speed, 0.0
        angle = wave.frequency * t + wave.phase
        size = float(np.ravel(wave.amplitude)[0])
        return speed + size * np.cos(angle), -size * wave.frequency * np.sin(angle)

    def limit(self, k: int, q: Floats) -> float:
        """Static limit of contact k."""
        load = self.contacts[k].load
        return self.contacts[k].static + (0.0 if load is None else float(np.dot(load, q)))

    def pull(self, t: float, q: Floats, v: Floats) -> Floats:
        """All forces but friction."""
        total = self.force - self.stiffness @ q - self.damping @ v
        for amplitude, wave in self.waves:
            total = total + amplitude * np.cos(wave.frequency * t + wave.phase)
        return total

    def slip(self, k: int, t: float, v: Floats) -> float:
        """Relative velocity at contact k."""
        return float(self.b[k] @ v) - self.belt(k, t)[0]

    def forces(
        self, t: float, q: Floats, v: Floats, mode: list[int]
    ) -> tuple[Floats, float, set[int]]:
        """Friction at all contacts, the largest share of a limit that sticking ones need, whose."""
        m = len(mode)
        force, limit = np.zeros(m), np.array([self.limit(k, q) for k in range(m)])
        stuck = [k for k in range(m) if mode[k] == 0]
        for k in set(range(m)) - set(stuck):
            s = max(mode[k] * self.slip(k, t, v), 0.0)
            law = self.contacts[k].friction
            force[k] = -mode[k] * limit[k] * float(law.force(s, forward=mode[k] > 0))
        if not stuck:
            return force, 0.0, set()
        own = self.b @ self.inverse @ self.pull(t, q, v) + self.response @ force
        right = np.array([self.belt(k, t)[1] - own[k] for k in stuck])
        matrix = self.response[np.ix_(stuck, stuck)]
        force[stuck] = np.linalg.lstsq(matrix, right, rcond=1e-9)[0]
        if np.abs(matrix @ force[stuck] - right).max() > 1e-9 * (1.0 + np.abs(right).max()):
            return force, np.inf, set()  # they cannot all stick
        shares = (np.abs(force) / limit)[stuck]
        share = float(shares.max())
        most = {k for k, each in zip(stuck, shares, strict=True) if each > share - 1e-9}
        if share > 1.0 and np.linalg.matrix_rank(matrix, tol=1e-9) < len(stuck):
            # Any forces that give these accelerations will do: those of the least largest share.
            one = np.ones((len(stuck), 1))
            scaled = matrix * limit[stuck]
            found = linprog(
                np.append(np.zeros(len(stuck)), 1.0),
                A_ub=np.block([[np.eye(len(stuck)), -one], [-np.eye(len(stuck)), -one]]),
                b_ub=np.zeros(2 * len(stuck)),
                A_eq=np.column_stack([scaled, 0.0 * one]),
                b_eq=scaled @ (force[stuck] / limit[stuck]),
                bounds=(None, None),
            )
            share = float(found.fun)
            slips = np.abs(scaled.T @ found.eqlin.marginals)
            most = {k for k, slip in zip(stuck, slips, strict=True) if slip > 1e-7}
        return force, share, most

    def rate(self, t: float, state: Floats, mode: list[int]) -> Floats:
        """Rate of change of (q, v) in given modes."""
        q, v = state[: self.n], state[self.n :]
        force, _, _ = self.forces(t, q, v, mode)
        return np.concatenate([v, self.inverse @ (self.pull(t, q, v) + self.b.T @ force)])

    def consistent(
        self, t: float, state: Floats, mode: list[int], resting: list[int]
    ) -> list[list[int]]:
        """All modes that contacts at rest can take, those with most sticking ones first."""
        q, v = state[: self.n], state[self.n :]
        _, share, most = self.forces(t, q, v, mode)
        leaving = most if share > 1.0 - 1e-9 else set()
        found = []
        ways = itertools.product((0, -1, 1), repeat=len(resting))
        for way in sorted(ways, key=lambda way: sum(map(abs, way))):
            tried = list(mode)
            for k, m in zip(resting, way, strict=True):
                tried[k] = m
            if any(tried[k] == 0 for k in leaving):
                continue
            _, share, _ = self.forces(t, q, v, tried)
            rate = self.b @ self.rate(t, state, tried)[self.n :]
            # What leaves a limit that kinetic friction keeps has no acceleration yet.
            along = [
                tried[k] * (rate[k] - self.belt(k, t)[1]) > (-1e-8 if k in leaving else 1e-8)
                for k in resting
                if tried[k] != 0
            ]
            if share < 1.0 - 1e-9 and all(along):
                found.append(tried)
        if not found:
            raise ArithmeticError("no modes are consistent")
        return found

    def follow(
        self,
        q: Floats,
        v: Floats,
        t_end: float,
        max_step: float = 0.05,
        choices: Sequence[tuple[float, int, int]] = (),
    ) -> Motion:
        """Integrate from event to event; `choices` among modes, where several are consistent."""
        # Static limits above kinetic friction leave a choice where contacts share inertia.
        t, state = 0.0, np.concatenate([q, v])
        slips = [self.slip(k, t, v) for k in range(len(self.contacts))]
        mode = [0 if abs(w) < 1e-14 else int(np.sign(w)) for w in slips]
        mode = self.consistent(t, state, mode, [k for k, m in enumerate(mode) if m == 0])[0]
        events: list[tuple[float, int, int]] = []
        if min(self.limit(k, q) for k in range(len(mode))) <= 0.0:
            return Motion(t, q, v, events, True)
        while True:
            signals = [self._landing(k, mode[k]) for k in range(len(mode)) if mode[k] != 0]
            signals += [self._release(tuple(mode))] * (0 in mode)
            n_changes = len(signals)
            signals += [self._load(k) for k, c in enumerate(self.contacts) if c.load is not None]
            found = solve_ivp(
                lambda s, y, mode=tuple(mode): self.rate(s, y, list(mode)),
                *((t, t_end), state),
                method="DOP853",
                rtol=2.5e-14,
                atol=1e-15,
                events=signals,
                max_step=max_step,
            )
            t, state = float(found.t[-1]), found.y[:, -1]
            if found.status == 0:
                return Motion(t, state[: self.n], state[self.n :], events, False)
            if any(len(times) for times in found.t_events[n_changes:]):
                return Motion(t, state[: self.n], state[self.n :], events, True)
            slips = [abs(self.slip(k, t, state[self.n :])) for k in range(len(mode))]
            resting = [k for k, w in enumerate(slips) if mode[k] == 0 or w < AT_REST]
            possible = self.consistent(t, state, mode, resting)
            asked = list(mode)
            for when, k, m in choices:
                asked[k] = m if abs(when - t) < SAME_TIME else asked[k]
            new = asked if asked in possible else possible[0]
            self.choices += len(possible) > 1
            events += [(t, k, m) for k, m in enumerate(new) if m != mode[k]]
            mode = new

    def _landing(self, k: int, mode: int):  # type: ignore[no-untyped-def]
        def event(t: float, state: Floats) -> float:
            return mode * self.slip(k, t, state[self.n :])

        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        return event

    def _release(self, mode: tuple[int, ...]):  # type: ignore[no-untyped-def]
        def event(t: float, state: Floats) -> float:
            return 1.0 - self.forces(t, state[: self.n], state[self.n :], list(mode))[1]

        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        return event

    def _load(self, k: int):  # type: ignore[no-untyped-def]
        def event(t: float, state: Floats) -> float:
            return self.limit(k, state[: self.n])

        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        return event


LAWS = (
    ss.Coulomb(mu=0.4),
    ss.Coulomb(mu=0.6, viscous=0.1),
    ss.PoppStelter(gamma=2.0),
    ss.Stribeck(mu=0.5, speed=0.3, viscous=0.05),
)
FEW_LAWS = (*LAWS[:3], ss.Coulomb(mu=0.5, viscous=0.05))
"""Three sets of kernels instead of seven for all mixtures; drawn alike."""


def random_structure(
    rng: np.random.Generator, laws: Sequence[ss.FrictionLaw] = LAWS, *, shared: bool = False
) -> ss.Structure:
    """Draw a structure nobody tuned for; `shared`: contacts may act on the same bodies."""
    n = int(rng.integers(1, 4 if shared else 5))
    root = rng.normal(size=(n, n))
    stiffness = root @ root.T + np.eye(n) * rng.uniform(0.2, 1.5)
    if rng.random() < 0.4:
        skew = rng.normal(size=(n, n)) * 0.3
        stiffness = stiffness + skew - skew.T
    damping = np.zeros((n, n))
    if rng.random() < 0.7:
        root = rng.normal(size=(n, n)) * rng.uniform(0.1, 0.5)
        damping = root @ root.T
        if rng.random() < 0.3:
            skew = rng.normal(size=(n, n)) * 0.2  # gyroscopic
            damping = damping + skew - skew.T
    bodies = rng.permutation(n).tolist()
    contacts = []
    for _ in range(int(rng.integers(2 if shared else 1, 4))):
        if shared:
            bodies = rng.permutation(n).tolist()
        if not bodies:
            break
        if len(bodies) > 1 and rng.random() < 0.35:
            at: object = (bodies.pop(), bodies.pop())
        elif rng.random() < 0.2:
            at = (np.eye(n)[bodies.pop()] * rng.uniform(0.5, 1.5)).tolist()
        else:
            at = bodies.pop()
        speed: object = float(rng.choice([0.0, *rng.uniform(-0.5, 0.8, size=3)]))
        if rng.random() < 0.25:
            wave = ss.Harmonic(rng.uniform(0.05, 0.4), rng.uniform(0.3, 3.0), rng.uniform(0, 6))
            speed = (speed, wave)
        load = rng.normal(size=n) * 0.15 if rng.random() < 0.4 else None
        law = laws[int(rng.integers(len(laws)))]
        contacts.append(
            ss.Contact(at=at, friction=law, static=rng.uniform(0.4, 1.5), V=speed, load=load)  # type: ignore[arg-type]
        )
    forcing = [
        ss.Harmonic(tuple(rng.normal(size=n) * 0.5), rng.uniform(0.3, 3.0), rng.uniform(0, 6))
        for _ in range(int(rng.integers(0, 3)))
    ]
    return ss.Structure(
        mass=rng.uniform(0.5, 2.5, size=n),
        stiffness=stiffness,
        damping=damping,
        contacts=contacts,
        force=rng.normal(size=n) * 0.3 if rng.random() < 0.5 else None,
        forcing=forcing or None,
    )
