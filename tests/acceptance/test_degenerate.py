"""Degenerate legal inputs (rule 8), and points where two things happen at once (rules 1, 2, 5)."""

import math

import numpy as np
import pytest
from tests.acceptance.judge import Effort, Tally, judge
from tests.acceptance.systems import Case, case
from tests.reference.settle import RIGHT

SMALL = {"alpha": 1.2, "beta": 1.3, "V": 0.0366, "mu": 0.22}
COULOMB = {
    "plain": {},
    "uncoupled": {"alpha": 0.0},
    "equal blocks": {"beta": 1.0},
    "equal blocks, exact arithmetic": {"alpha": 0.75, "beta": 1.0, "V": 0.0625, "mu": 0.25},
    "no kinetic friction": {"mu": 0.0},
    "no kinetic friction, fast": {"mu": 0.0, "V": 0.2},
    "full friction": {"mu": 1.0},
    "full friction, uncoupled": {"mu": 1.0, "alpha": 0.0},
    "uncoupled, equal, frictionless": {"mu": 0.0, "alpha": 0.0, "beta": 1.0},
    "commensurate frequencies": {"alpha": 1.5, "V": 0.2},
    "light second block": {"beta": 0.25},
    "stiff coupling": {"alpha": 20.0},
}
LAW9 = {
    "no weakening": {"gamma": 0.0},
    "uncoupled": {"alpha": 0.0},
    "equal blocks": {"beta": 1.0},
    "delta is one": {"delta": 1.0},
}


def special_points(system: Case) -> np.ndarray:
    """Both ends and up to 4 ulp beyond, both blocks at once, zero, and neighbours of each."""
    corner = (system.beta - 1) / (1 + 2 * system.alpha)
    points = []
    for d in (-system.end, corner, 0.0, system.end):
        points += [d, math.nextafter(d, 9), math.nextafter(d, -9)]
        points += [d + step for step in (-1e-15, 1e-15, -1e-12, 1e-12, -1e-9, 1e-9)]
    reach = system.end * (1 + 2**-51)
    return np.array([d for d in points if abs(d) <= reach])


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
@pytest.mark.parametrize("name", COULOMB)
def test_coulomb(name, engine):
    system = case("coulomb", **(SMALL | COULOMB[name]))
    points = np.concatenate([special_points(system), np.linspace(-1, 1, 13) * system.end])
    tally = Tally()
    judge(
        tally,
        system,
        points,
        engine,
        np.random.default_rng(1),
        Effort(0.1, 100, 300, product_too=True),
    )
    assert not tally.wrong, str(tally)
    assert sum(tally.verdicts.values()) == points.size
    # From the belt one w starts at zero, so the amplitudes cannot sum to less than V (note 0004).
    assert tally.statuses["NEVER_SLIPPING"] == 0, str(tally)
    assert "full" in name or tally.verdicts[RIGHT] > 5, str(tally)


@pytest.mark.parametrize("name", LAW9)
def test_law_9(name):
    plain = {"alpha": 1.2, "beta": 1.3, "V": 0.15, "gamma": 2.0}
    system = case("law9", **(plain | LAW9[name]))
    points = np.concatenate([special_points(system)[::2], np.linspace(-0.9, 0.9, 7) * system.end])
    tally = Tally()
    judge(
        tally,
        system,
        points,
        "adaptive",
        np.random.default_rng(1),
        Effort(0.0, 30, 300, product_too=True),
    )
    assert not tally.wrong, str(tally)
    assert sum(tally.verdicts.values()) == points.size
