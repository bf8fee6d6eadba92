"""Plants with dry contacts, plainly: positions and velocities, scipy's integrator, its events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import stickslip as ss
from stickslip.mechanics.model.contact import weights_of

Floats = NDArray[np.float64]


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
        self.force = np.zeros(n) if model.force is None else np.asarray(model.force)
        self.waves = [(np.array(w.amplitudes(n)), w) for w in model.forcing or ()]
        self.b = np.array([weights_of(c, n, "contact") for c in self.contacts])
        self.inverse = np.linalg.inv(self.mass)
        self.response = np.diag(self.b @ self.inverse @ self.b.T)

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

    def needed(self, k: int, t: float, q: Floats, v: Floats) -> float:
        """Force that keeps contact k sticking."""
        own = self.b[k] @ self.inverse @ self.pull(t, q, v)
        return -(own - self.belt(k, t)[1]) / self.response[k]

    def rate(self, t: float, state: Floats, mode: list[int]) -> Floats:
        """Rate of change of (q, v) in given modes."""
        q, v = state[: self.n], state[self.n :]
        total = self.pull(t, q, v)
        for k, m in enumerate(mode):
            if m == 0:
                f = self.needed(k, t, q, v)
            else:
                s = max(m * self.slip(k, t, v), 0.0)
                law = self.contacts[k].friction
                f = -m * self.limit(k, q) * float(law.force(s, forward=m > 0))
            total = total + f * self.b[k]
        return np.concatenate([v, self.inverse @ total])

    def follow(self, q: Floats, v: Floats, t_end: float, max_step: float = 0.05) -> Motion:
        """Integrate from event to event."""
        t, state = 0.0, np.concatenate([q, v])
        mode = []
        for k in range(len(self.contacts)):
            w = self.slip(k, t, v)
            mode.append(0 if abs(w) < 1e-14 else int(np.sign(w)))
            if mode[k] == 0:
                mode[k] = self._on_belt(k, t, state)
        events: list[tuple[float, int, int]] = []
        while True:
            signals = [self._signal(k, mode[k]) for k in range(len(mode))]
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
            k = next(i for i, times in enumerate(found.t_events) if len(times))
            if k >= len(mode):
                return Motion(t, state[: self.n], state[self.n :], events, True)
            before = mode[k]
            if before != 0:
                mode[k] = self._on_belt(k, t, state)
            else:
                mode[k] = -int(np.sign(self.needed(k, t, state[: self.n], state[self.n :])))
            if mode[k] != before:
                events.append((t, k, mode[k]))

    def _on_belt(self, k: int, t: float, state: Floats) -> int:
        q, v = state[: self.n], state[self.n :]
        needed = self.needed(k, t, q, v)
        return 0 if abs(needed) < self.limit(k, q) else -int(np.sign(needed))

    def _signal(self, k: int, mode: int):  # type: ignore[no-untyped-def]
        def event(t: float, state: Floats) -> float:
            q, v = state[: self.n], state[self.n :]
            if mode != 0:
                return mode * self.slip(k, t, v)
            return self.limit(k, q) - abs(self.needed(k, t, q, v))

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


def random_structure(
    rng: np.random.Generator, laws: Sequence[ss.FrictionLaw] = LAWS
) -> ss.Structure:
    """Draw a structure nobody tuned for."""
    n = int(rng.integers(1, 5))
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
    for _ in range(int(rng.integers(1, 4))):
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
