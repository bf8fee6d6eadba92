"""Plants with dry contacts in doubles, quickly: Dormand and Prince's steps of order eight.

As plain as `structures.py` and `elastic.py`, positions and velocities and what holds for them, and
a thousand times as fast, for samples of a hundred thousand. Of the package it takes the compiler
alone: numba's own needs four times as long. Each contact's signals are looked at in both ends of a
short step with their rates, and where one turns back within a step its minimum is searched for. It
proves nothing: where it is unsure it says so, and where it and the package differ `structures.py`
decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import stickslip as ss
from stickslip.mechanics.model.contact import weights_of
from stickslip.numerics.targets import write_module

Floats = NDArray[np.float64]

# As a generated module, which the package's cache keeps.
KERNELS = write_module(
    "dormand", Path(__file__).with_name("dormand_kernels.py").read_text(encoding="utf-8")
)
ENDED, LOST, ARRIVED = KERNELS.ENDED, KERNELS.LOST, KERNELS.ARRIVED


class Waves(NamedTuple):
    """Constant velocities, and an oscillation of each."""

    mean: Floats
    size: Floats
    frequency: Floats
    phase: Floats


class Plant(NamedTuple):
    """A structure in the form that kernels take."""

    inverse: Floats  # of the mass matrix
    stiffness: Floats
    damping: Floats
    force: Floats
    amplitude: Floats  # of forcing, (waves, n)
    frequency: Floats
    phase: Floats
    b: Floats  # of rigid contacts, (m, n)
    belt: Waves
    static: Floats
    load: Floats
    law: NDArray[np.int64]
    numbers: Floats  # of laws
    response: Floats
    sticking: Floats  # pseudo-inverse of the response for each set of sticking contacts
    first: NDArray[np.int64]  # of each set's mechanisms
    mechanism: Floats
    reach: Floats  # of elastic contacts, (r, n)
    spring: Floats
    kinetic: Floats
    foot_static: Floats
    foot_load: Floats
    foot_belt: Waves


class Motion(NamedTuple):
    """How a motion ended and when, its state then, and its changes of mode."""

    ending: int
    t: float
    q: Floats
    v: Floats
    length: Floats
    events: list[tuple[float, int, int]]
    paces: list[float]  # rates of the signals that came to zero
    margin: float  # by which the closest decision was made


def mechanisms(b: Floats) -> list[Floats]:
    """Velocities at contacts in which as few as possible move (all combinations of others rest)."""
    rank = np.linalg.matrix_rank(b, tol=1e-9)
    found: list[Floats] = []
    space = np.linalg.svd(b)[2][:rank]
    for rest in combinations(range(len(b)), rank - 1):
        still = b[list(rest)] @ space.T
        if rank > 1 and np.linalg.matrix_rank(still, tol=1e-9) < rank - 1:
            continue
        own = np.linalg.svd(still)[2][-1] if rank > 1 else np.ones(1)
        u = b @ (space.T @ own)
        u = np.where(abs(u) < 1e-9 * abs(u).max(), 0.0, u / abs(u).max())
        if not any(np.allclose(u, turn * each, rtol=1e-5) for each in found for turn in (1, -1)):
            found.append(u)
    return found


def _waves(contacts: Sequence[ss.Contact]) -> Waves:
    rows = []
    for contact in contacts:
        speed, wave = contact.belt
        none = (0.0, 0.0, 0.0)
        own = none if wave is None else (float(np.ravel(wave.amplitude)[0]), *_turn(wave))
        rows.append((speed, *own))
    return Waves(*np.array(rows, dtype=float).reshape(-1, 4).T.copy())


def _turn(wave: ss.Harmonic) -> tuple[float, float]:
    return wave.frequency, wave.phase


def _law(law: ss.FrictionLaw) -> tuple[int, list[float]]:
    if isinstance(law, ss.Coulomb):
        return KERNELS.COULOMB, [law.mu, law.viscous, 0.0, 0.0]
    if isinstance(law, ss.PoppStelter):
        return KERNELS.POPP_STELTER, [law.gamma, law.delta, law.eta, 0.0]
    return KERNELS.STRIBECK, [law.mu, law.speed, law.viscous, float(law.exponent)]  # type: ignore[attr-defined]


def plant_of(model: ss.Structure) -> Plant:
    """A structure's own matrices, nothing of what the package makes of them."""
    mass = np.asarray(model.mass)
    mass = np.diag(mass) if mass.ndim == 1 else mass
    n = len(mass)
    b = np.array([weights_of(c, n, "contact") for c in model.contacts])
    rigid = [k for k, c in enumerate(model.contacts) if c.stiffness is None]
    soft = [k for k, c in enumerate(model.contacts) if c.stiffness is not None]
    stiff, feet = [model.contacts[k] for k in rigid], [model.contacts[k] for k in soft]
    m = len(rigid)
    inverse, b_all = np.linalg.inv(mass), b
    b = b_all[rigid].reshape(m, n)
    response = b @ inverse @ b.T
    sticking, rows, first = np.zeros((2**m, m, m)), [np.zeros((0, m))], [0]
    for mask in range(2**m):
        stuck = [k for k in range(m) if mask >> k & 1]
        if stuck:
            own = np.ix_(stuck, stuck)
            sticking[mask][own] = np.linalg.pinv(response[own], rcond=1e-9)
            for u in mechanisms(b[stuck]):
                rows.append(np.zeros((1, m)))
                rows[-1][0, stuck] = u
        first.append(sum(map(len, rows)))
    waves = tuple(model.forcing or ())
    laws = [_law(c.friction) for c in stiff]

    def loads(contacts: Sequence[ss.Contact]) -> Floats:
        return np.array([c.load or np.zeros(n) for c in contacts], dtype=float).reshape(-1, n)

    return Plant(
        inverse=inverse,
        stiffness=np.array(model.stiffness),
        damping=np.array(model.damping),
        force=np.zeros(n) if model.force is None else np.array(model.force),
        amplitude=np.array([w.amplitudes(n) for w in waves], dtype=float).reshape(-1, n),
        frequency=np.array([w.frequency for w in waves], dtype=float),
        phase=np.array([w.phase for w in waves], dtype=float),
        b=b,
        belt=_waves(stiff),
        static=np.array([c.static for c in stiff], dtype=float),
        load=loads(stiff),
        law=np.array([law for law, _ in laws], dtype=np.int64),
        numbers=np.array([numbers for _, numbers in laws], dtype=float).reshape(-1, 4),
        response=response,
        sticking=sticking,
        first=np.array(first),
        mechanism=np.concatenate(rows),
        reach=b_all[soft].reshape(-1, n),
        spring=np.array([c.stiffness for c in feet], dtype=float),
        kinetic=np.array([c.friction.mu for c in feet], dtype=float),  # type: ignore[attr-defined]
        foot_static=np.array([c.static for c in feet], dtype=float),
        foot_load=loads(feet),
        foot_belt=_waves(feet),
    )


class Desk(NamedTuple):
    """Where a motion is worked out."""

    y: Floats
    lost: Floats  # what rounding took from y
    end: Floats
    trial: Floats
    stages: Floats
    pull: Floats
    pulled: Floats  # rate of `pull`
    force: Floats
    own: Floats
    value: Floats
    value_rate: Floats
    value_end: Floats
    rate_end: Floats
    mode: NDArray[np.int64]
    foot: NDArray[np.int64]
    tried: NDArray[np.int64]
    chosen: NDArray[np.int64]
    wanted: NDArray[np.int64]
    before: NDArray[np.int64]
    times: Floats
    paces: Floats
    changes: NDArray[np.int64]


def new_desk(p: Plant) -> Desk:
    """An empty one."""
    n, m, r = len(p.inverse), len(p.b), len(p.reach)
    size, signals = 2 * n + r, 2 * len(p.mechanism) + 2 * m + 3 * r + 1
    whole = np.int64
    return Desk(
        *np.zeros((4, size)),
        np.zeros((KERNELS.STAGES, size)),
        *np.zeros((2, n)),
        *np.zeros((2, m)),
        *np.zeros((4, signals)),
        np.zeros(m, dtype=whole),
        np.zeros(r, dtype=whole),
        *np.zeros((4, m), dtype=whole),
        *np.zeros((2, KERNELS.MOST_EVENTS)),
        np.zeros((KERNELS.MOST_EVENTS, 2), dtype=whole),
    )


class Follower:
    """A structure's motions; contacts are numbered as in the structure."""

    def __init__(self, model: ss.Structure) -> None:
        self.plant = plant_of(model)
        self.desk = new_desk(self.plant)
        soft = [c.stiffness is not None for c in model.contacts]
        self.order = [k for kind in (False, True) for k, s in enumerate(soft) if s is kind]

    def follow(
        self,
        q: Floats,
        v: Floats,
        t_end: float,
        *,
        t: float = 0.0,
        mode: Sequence[int] | None = None,
        until: tuple[int, int, int, int] = (0, 0, 0, 0),
        choices: Sequence[tuple[float, int, int]] = (),
        noise: float = 0.0,
    ) -> Motion:
        """Follow one; `choices` among modes, where several are consistent; `noise` at events."""
        p, o, n = self.plant, self.desk, len(q)
        o.y[:n], o.y[n : 2 * n], o.y[2 * n :], o.lost[:] = q, v, 0.0, 0.0
        place = {k: i for i, k in enumerate(self.order)}
        when = np.array([c[0] for c in choices], dtype=float)
        what = np.array([(place[c[1]], c[2]) for c in choices], dtype=np.int64).reshape(-1, 2)
        if mode is None:
            ways = KERNELS.begin(p, t, o)
        else:
            ways, o.mode[:] = 1, mode
        if ways <= 0:
            return self._told(LOST if ways < 0 else KERNELS.NO_MODES, t, 0, 0.0)
        return self._told(*KERNELS.follow(p, t, t_end, until, when, what, noise, o))

    def _told(self, ending: int, t: float, count: int, margin: float) -> Motion:
        o, n = self.desk, len(self.plant.inverse)
        pairs = zip(o.times[:count].tolist(), o.changes[:count].tolist(), strict=True)
        events = [(time, self.order[k], m) for time, (k, m) in pairs]
        events = sorted(events, key=lambda event: event[:2])
        y, paces = o.y.copy(), o.paces[:count].tolist()
        return Motion(ending, t, y[:n], y[n : 2 * n], y[2 * n :], events, paces, margin)
