"""Structures in any coherent units: from nanometres to kilometres, microseconds to days."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip.mechanics.cycle.mode_changes import touches
from stickslip.mechanics.cycle.shooting import Shooter

UNITS = [(1e-9, 1.0), (1e-9, 1e-6), (1e-6, 1e-3), (1e3, 1e5)]  # metres, seconds in one of ours


def falling(speed: float) -> ss.FrictionLaw:
    return ss.PoppStelter(gamma=3.0 / speed)


def measured(speed: float) -> ss.FrictionLaw:
    return ss.TabulatedFriction(speed * np.array([0.0, 0.1, 0.3, 1.0]), [1.0, 0.8, 0.6, 0.7])


def pair(length: float, time: float, law=falling) -> ss.Structure:  # type: ignore[no-untyped-def]
    """Two bodies that rub, one of them shaken, in units of so many metres and seconds."""
    k, c, v = time**-2, 1.0 / time, length / time
    forces = {"friction": law(v), "V": 0.2 * v}
    return ss.Structure(
        mass=[1.0, 1.5],
        stiffness=k * np.array([[2.2, -1.2], [-1.2, 2.2]]),
        damping=c * np.diag([0.02, 0.03]),
        contacts=[
            ss.Contact(at=0, static=length * k, **forces),
            ss.Contact(at=1, static=1.3 * length * k, **forces),
        ],
        forcing=ss.Harmonic((0.7 * length * k, 0.0), 1.3 / time),
    )


@pytest.mark.parametrize(("length", "time"), UNITS)
@pytest.mark.parametrize("law", [falling, measured])
def test_units_change_neither_a_motion_nor_its_steps(length, time, law):
    ends, steps = [], []
    for a, b in [(1.0, 1.0), (length, time)]:
        x, v = np.array([0.1, 0.2]) * a, np.array([0.2, 0.1]) * a / b
        motion = ss.simulate(pair(a, b, law), x, v, t_end=40 * b)
        end = motion.final_state
        ends.append(np.concatenate([end.x / a, end.v * b / a]))
        steps.append(len(motion.t))
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-12)
    assert abs(steps[1] - steps[0]) <= 2


@pytest.mark.parametrize(("length", "time"), UNITS)
def test_units_change_no_cycle_that_is_found(length, time):
    def found(a: float, b: float) -> tuple[float, int, np.ndarray]:
        contact = ss.Contact(at=0, friction=falling(a / b), V=0.2 * a / b, static=a / b**2)
        block = ss.Structure([1.0], [1 / b**2], [0.1 / b], contacts=[contact])
        shaken = ss.Structure(
            [1.0],
            [1 / b**2],
            [0.1 / b],
            contacts=[contact],
            forcing=ss.Harmonic(0.7 * a / b**2, 1.3 / b),
        )
        free = ss.find_cycle(block, [0.0], [0.0])
        state = [0.5 * a, 0.1 * a / b]
        forced = ss.stroboscopic_map(shaken).periodic_point(state)
        curve = ss.follow(free, "V_1", (0.15 * a / b, 0.3 * a / b))
        numbers = [free.period / b, forced.period / b, *forced.multipliers.real]
        return np.array(numbers), len(forced.events), len(curve.values)

    (numbers, *counts), (expected, *known) = found(length, time), found(1.0, 1.0)
    np.testing.assert_allclose(numbers, expected, rtol=1e-10, atol=1e-10)
    assert counts == known


def rubbing(length: float, time: float) -> ss.Structure:
    """Two bodies whose cycle goes through changes of its modes as the belt becomes slower."""
    k, c, v = time**-2, 1.0 / time, length / time
    law = ss.PoppStelter(gamma=1.0 / v)
    return ss.Structure(
        mass=[1.0, 1.5],
        stiffness=k * np.array([[2.2, -1.2], [-1.2, 2.2]]),
        damping=c * np.diag([0.1, 0.15]),
        contacts=[
            ss.Contact(at=i, static=limit * length * k, friction=law, V=0.3 * v)
            for i, limit in enumerate([1.0, 1.3])
        ],
    )


@pytest.mark.parametrize(("length", "time"), UNITS)
def test_units_change_no_clearance_of_derivatives(length, time):
    def found(a: float, b: float) -> list[float]:
        x, v = np.array([0.1, 0.2]) * a, np.array([0.2, 0.1]) * a / b
        rates = ss.simulate(rubbing(a, b), x, v, t_end=30 * b).derivative("mass_1")
        return [rates.status, rates.t_end / b, rates.margin, rates.margin_time / b]

    np.testing.assert_allclose(found(length, time), found(1.0, 1.0), rtol=1e-9)


@pytest.mark.parametrize(("length", "time"), UNITS)
def test_units_change_no_room_that_a_motion_has_from_other_modes(length, time):
    def found(a: float, b: float) -> list[tuple[str, int, float]]:
        shooter = Shooter(rubbing(a, b), tangents=False)
        start = shooter.start(np.array([0.1, 0.2]) * a, np.array([0.2, 0.1]) * a / b)
        return [(each.kind, each.block, each.room) for each in touches(shooter, start, 30 * b)]

    *names, rooms = zip(*found(length, time), strict=True)
    *known, expected = zip(*found(1.0, 1.0), strict=True)
    assert names == known
    np.testing.assert_allclose(rooms, expected, rtol=1e-9)


@pytest.mark.parametrize(("length", "time"), UNITS)
def test_units_change_no_state_that_is_drawn(length, time):
    here, known = (rubbing(a, b).sample_state(3) for a, b in [(length, time), (1.0, 1.0)])
    np.testing.assert_allclose(here[0], known[0] * length, rtol=1e-12)
    np.testing.assert_allclose(here[1], known[1] * length / time, rtol=1e-12)
