"""Plants with elastic contacts, plainly: their springs' lengths are states beside q and v."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from tests.reference.structures import AT_REST, SAME_TIME, Motion, Plain, random_structure

import stickslip as ss
from stickslip.mechanics.friction.coulomb import is_constant

Floats = NDArray[np.float64]

FROM_ROUNDING = 1e-14  # a spring whose body rests stays at its limit


class Elastic(Plain):
    """As `Plain`, which knows the rigid contacts alone; elastic ones pull by their springs."""

    def __init__(self, model: ss.Structure) -> None:
        super().__init__(model)
        stiff = [contact.stiffness is None for contact in self.contacts]
        self.rigid, self.soft = (np.flatnonzero(np.array(stiff) == kind) for kind in (True, False))
        self.feet = [self.contacts[k] for k in self.soft]
        self.k = np.array([contact.stiffness for contact in self.feet])
        self.mu = np.array([contact.friction.force(1.0) for contact in self.feet])
        self.reach = self.b[self.soft]
        self.contacts = tuple(self.contacts[k] for k in self.rigid)
        self.b = self.b[self.rigid]
        self.response = self.b @ self.inverse @ self.b.T
        self.length = np.zeros(len(self.k))

    def see(self, state: Floats) -> tuple[Floats, Floats]:
        """Positions and velocities of a state; the springs' lengths are kept aside."""
        self.length = state[2 * self.n :]
        return state[: self.n], state[self.n : 2 * self.n]

    def pull(self, t: float, q: Floats, v: Floats) -> Floats:
        """All forces but those of rigid contacts."""
        return super().pull(t, q, v) - self.reach.T @ (self.k * self.length)

    def most(self, j: int, q: Floats) -> float:
        """Static limit of an elastic contact."""
        load = self.feet[j].load
        return self.feet[j].static + (0.0 if load is None else float(np.dot(load, q)))

    def stretch(self, j: int, t: float, q: Floats, v: Floats, mode: int) -> float:
        """Rate of a spring's length."""
        if mode == 0:
            speed, wave = self.feet[j].belt
            if wave is not None:
                speed += np.ravel(wave.amplitude)[0] * np.cos(wave.frequency * t + wave.phase)
            return float(self.reach[j] @ v) - speed
        load = self.feet[j].load
        return 0.0 if load is None else mode * self.mu[j] * float(np.dot(load, v)) / self.k[j]

    def flow(self, t: float, state: Floats, mode: list[int], feet: list[int]) -> Floats:
        """Rate of change of (q, v, lengths)."""
        q, v = self.see(state)
        rates = [self.stretch(j, t, q, v, m) for j, m in enumerate(feet)]
        return np.concatenate([self.rate(t, np.concatenate([q, v]), mode), rates])

    def signals(self, mode: list[int], feet: list[int]) -> list:  # type: ignore[type-arg]
        """Functions whose fall to zero is an event: of rigid contacts, of feet, of loads."""

        def of(function):  # type: ignore[no-untyped-def]
            def event(t: float, state: Floats) -> float:
                return float(function(t, *self.see(state)))

            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
            return event

        made = [
            of(lambda t, q, v, k=k, m=m: m * self.slip(k, t, v))
            for k, m in enumerate(mode)
            if m != 0
        ]
        if 0 in mode:
            made.append(of(lambda t, q, v: 1.0 - self.forces(t, q, v, mode)[1]))
        for j, m in enumerate(feet):
            if m != 0:
                made.append(
                    of(
                        lambda t, q, v, j=j, m=m: (
                            m * (self.stretch(j, t, q, v, 0) - self.stretch(j, t, q, v, m))
                        )
                    )
                )
            else:
                made.append(
                    of(
                        lambda t, q, v, j=j: (
                            self.most(j, q) + FROM_ROUNDING - abs(self.k[j] * self.length[j])
                        )
                    )
                )
        made += [of(lambda t, q, v, k=k: self.limit(k, q)) for k in range(len(mode))]
        return [*made, *(of(lambda t, q, v, j=j: self.most(j, q)) for j in range(len(feet)))]

    def follow_feet(
        self,
        q: Floats,
        v: Floats,
        t_end: float,
        max_step: float = 0.05,
        choices: Sequence[tuple[float, int, int]] = (),
    ) -> Motion:
        """Integrate from event to event, springs relaxed at the start; `choices` as in `follow`."""
        t, state = 0.0, np.concatenate([q, v, 0.0 * self.k])
        self.see(state)
        mode = [0 if abs(s := self.slip(k, t, v)) < 1e-14 else int(np.sign(s)) for k in self._each]
        mode = self._chosen(t, state, mode, [k for k, m in enumerate(mode) if m == 0], choices)
        feet = [0] * len(self.k)
        events: list[tuple[float, int, int]] = []
        while True:
            limits = [self.limit(k, q) for k in self._each]
            if min([*limits, *(self.most(j, q) for j in range(len(feet)))]) <= 1e-12:
                return Motion(t, q, v, events, True)
            if t >= t_end:
                return Motion(t, q, v, events, False)
            signals = self.signals(mode, feet)
            found = solve_ivp(
                lambda s, y, mode=tuple(mode), feet=tuple(feet): self.flow(s, y, mode, feet),
                *((t, t_end), state),
                method="DOP853",
                rtol=2.5e-14,
                atol=1e-15,
                events=signals,
                max_step=max_step,
            )
            t, state = float(found.t[-1]), found.y[:, -1].copy()
            q, v = self.see(state)
            if found.status == 0:
                continue
            moved = list(feet)
            for j, m in enumerate(feet):
                force, most = self.k[j] * self.length[j], self.most(j, q)
                grows = np.sign(force) * self.stretch(j, t, q, v, 0) > AT_REST
                if m == 0 and grows and abs(force) > most - AT_REST:
                    moved[j] = int(np.sign(force))
                    state[2 * self.n + j] = moved[j] * self.mu[j] * most / self.k[j]
                elif m != 0:
                    foot = self.stretch(j, t, q, v, 0) - self.stretch(j, t, q, v, m)
                    moved[j] = 0 if m * foot < AT_REST else m
            resting = [k for k, m in enumerate(mode) if m == 0 or abs(self.slip(k, t, v)) < AT_REST]
            new = self._chosen(t, state, mode, resting, choices)
            own = [(int(k), m) for k, m, was in zip(self.rigid, new, mode, strict=True) if m != was]
            own += [
                (int(k), m) for k, m, was in zip(self.soft, moved, feet, strict=True) if m != was
            ]
            events += [(t, k, m) for k, m in sorted(own)]
            mode, feet = new, moved

    @property
    def _each(self) -> range:
        return range(len(self.contacts))

    def _chosen(
        self,
        t: float,
        state: Floats,
        mode: list[int],
        resting: list[int],
        choices: Sequence[tuple[float, int, int]],
    ) -> list[int]:
        if not mode:
            return []
        possible = self.consistent(t, np.concatenate(self.see(state)), mode, resting)
        asked = dict(zip(self.rigid.tolist(), mode, strict=True))
        asked |= {k: m for when, k, m in choices if abs(when - t) < SAME_TIME and k in asked}
        return list(asked.values()) if list(asked.values()) in possible else possible[0]


def random_elastic(
    rng: np.random.Generator,
    laws: Sequence[ss.FrictionLaw] = (ss.Coulomb(mu=0.4), ss.Coulomb(mu=0.7)),
    *,
    shared: bool = False,
) -> ss.Structure:
    """Draw a structure with rigid and elastic contacts, on the same bodies too."""
    model = random_structure(rng, laws, shared=shared)
    n = len(model.mass)
    contacts = [
        replace(each, stiffness=rng.uniform(0.5, 8.0))
        if rng.random() < 0.5 and is_constant(each.friction)
        else each
        for each in model.contacts
    ]
    contacts.insert(
        int(rng.integers(len(contacts) + 1)),
        ss.Contact(
            at=rng.normal(size=n).tolist(),
            friction=ss.Coulomb(mu=float(rng.choice([1.0, rng.uniform(0.0, 1.0)]))),
            static=rng.uniform(0.1, 0.6),
            V=float(rng.choice([0.0, rng.normal() * 0.3])),
            stiffness=float(rng.uniform(0.5, 8.0)),
        ),
    )
    return model.replace(contacts=contacts)
