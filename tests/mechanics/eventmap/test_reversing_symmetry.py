"""Slip against constant friction runs backwards with the blocks exchanged (theory page)."""

import numpy as np
import pytest

import stickslip as ss

FITS = 1e-11  # forces and times of cycles of order 1, whose points carry some rounding


def kinds(orbit):
    """Whether the slip phases of a cycle can be mirror images of each other by their order."""
    words = tuple(sorted(orbit.itinerary))
    own = words in [("-. -- .- ..",), (".- -- -. ..",)]
    return own or words == ("-. -- -. ..", ".- -- .- ..")


def phases(model, orbit):
    """Of each slip phase: (block, time since the start, forces) at all events, and its length."""
    alpha, found = model.parameters["alpha"], []
    for d in orbit.points:
        motion = ss.simulate(model, d=float(d), until="stick")
        start, rows = motion.t[0], []
        x1 = min(1 + alpha * d, model.parameters["beta"] - (1 + alpha) * d)
        first = 0 if 1 + alpha * d == x1 else 1
        rows.append((first, 0.0, forces(alpha, np.array([x1, x1 + d]))))
        for event in motion.events:
            x = motion.x(event.time)
            rows.append((event.block - 1, float(event.time - start), forces(alpha, x)))
        found.append(rows)
    return found


def forces(alpha, x):
    return np.array([(1 + alpha) * x[0] - alpha * x[1], (1 + alpha) * x[1] - alpha * x[0]])


def mismatch(model, orbit, mu=None):
    """Largest difference between the events of each phase and those of the next one mirrored."""
    beta = model.parameters["beta"]
    total = (model.parameters["mu"] if mu is None else mu) * (1 + beta)
    all_phases = phases(model, orbit)
    worst = 0.0
    for rows, following in zip(all_phases, [*all_phases[1:], all_phases[0]], strict=True):
        length = rows[-1][1]
        for (block, t, e), (other, s, e2) in zip(rows, following[::-1], strict=True):
            assert other == 1 - block
            worst = max(worst, abs(t - (length - s)), np.abs(e + e2[::-1] - total).max())
    return worst


@pytest.mark.parametrize("seed", range(2))
def test_cycles_with_one_release_a_block_are_their_own_mirror_image(seed):
    rng = np.random.default_rng(seed)
    seen = {1: 0, 2: 0}
    for _ in range(3):
        alpha, beta = rng.uniform(0.3, 3), rng.uniform(0.6, 1.7)
        friction = ss.Coulomb(mu=rng.uniform(0.1, 0.8))
        model = ss.TwoBlock(alpha=alpha, beta=beta, V=rng.uniform(0.02, 0.15), friction=friction)
        for orbit in filter(kinds, ss.periodic_orbits(ss.event_map(model), 2)):
            seen[orbit.period] += 1
            assert mismatch(model, orbit) < FITS * max(1, abs(orbit.multiplier))
    assert seen[1] >= 2


def test_a_pair_of_forces_keeps_the_symmetry():
    friction = (ss.Coulomb(mu=0.3), ss.Coulomb(mu=0.25))
    model = ss.TwoBlock(alpha=2, beta=1.1, V=0.05, friction=friction)
    mean = (0.3 + 0.25 * 1.1) / 2.1
    orbits = list(filter(kinds, ss.periodic_orbits(ss.event_map(model), 2)))
    assert orbits
    assert all(
        mismatch(model, orbit, mean) < FITS * abs(orbit.multiplier) + FITS for orbit in orbits
    )


def test_viscous_friction_breaks_it():
    exact = ss.TwoBlock(alpha=2, beta=1.1, V=0.05, friction=ss.Coulomb(mu=0.3))
    model = exact.replace(friction=ss.Coulomb(mu=0.3, viscous=0.01))
    orbits = list(filter(kinds, ss.periodic_orbits(ss.event_map(model), 2)))
    assert orbits
    assert all(mismatch(model, orbit) > 1e-4 for orbit in orbits)
