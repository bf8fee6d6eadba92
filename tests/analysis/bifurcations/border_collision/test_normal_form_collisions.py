"""Border collisions that the search finds in normal forms: exact places, outcomes as predicted."""

from functools import partial

import pytest
from tests.analysis import known_maps as examples
from tests.sizes import sizes, slow

from stickslip.analysis.bifurcations import bifurcations as lists
from stickslip.analysis.bifurcations.outcome import disagreement

# Fewer than by default: what lies between lists is found all the same.
bifurcations = partial(lists.bifurcations, n_lists=6)

LOCATED = 1e-12


@pytest.mark.parametrize(
    ("a", "b", "orbits", "before", "after"),
    [
        (0.5, 0.2, "persist", "periodic", "periodic"),
        *slow((0.5, -1.5, "period-doubled", "periodic", "periodic")),
        *slow((0.5, -3.2, "period-doubled", "periodic", "periodic")),  # to period 3
        (0.5, -6.0, "period-doubled", "periodic", "chaotic"),
        (-0.4, -3.0, "period-doubled", "periodic", "none"),
        (0.5, 1.5, "die in pairs", "periodic", "none"),
        (1.4, -2.2, "born in pairs", "none", "chaotic"),
        *slow((1.4, -5.0, "born in pairs", "none", "none")),
        (1.8, -0.6, "born in pairs", "none", "periodic"),
        *slow((2.0, 3.0, "persist", "none", "none")),
    ],
)
def test_one_collision_at_0(a, b, orbits, before, after):
    f = examples.border_collision(a, b, 0.0, size=25.0)
    (found,) = bifurcations(f, "mu", (-0.9, 1.0), max_period=2)
    assert found.kind == "border_collision"
    assert found.value == pytest.approx(0, abs=LOCATED)
    assert found.predicted_outcome.orbits == found.outcome.orbits == orbits
    assert found.predicted_outcome.before.kind == found.outcome.before.kind == before
    assert found.predicted_outcome.after.kind == found.outcome.after.kind == after
    assert disagreement(found.predicted_outcome, found.outcome) == ""


@pytest.mark.parametrize("b", [0.5, -0.4], ids=["adding", "incrementing"])
@pytest.mark.parametrize("longest", sizes(3, 4))
def test_windows_of_maximal_cycles_have_their_exact_borders(b, longest):
    a = 0.5
    low, high = 0.05, 0.62 if b < 0 else 0.95
    f = examples.border_collision(a, b, 0.3, -1.0, size=3.0)
    found = bifurcations(f, "mu", (low, high), max_period=longest)
    assert {x.kind for x in found} == {"border_collision"}
    expected = []
    for n in range(1, longest):
        windows = [examples.maximal_window(a, b, n)]
        if n > 1 and b > 0:  # and with the sides exchanged
            windows.append(tuple(1 - mu for mu in examples.maximal_window(b, a, n)))
        expected += [mu for window in windows for mu in window if low < mu < high]
    assert [x.value for x in found] == pytest.approx(sorted(expected), abs=LOCATED)
    for x in found:
        assert disagreement(x.predicted_outcome, x.outcome) == ""
        lost = x.predicted_outcome.before if x.born > 0 else x.predicted_outcome.after
        # Beside a window of adding cycles accumulate; of incrementing, the next one is there.
        assert lost.kind == ("period-adding" if b > 0 else "none")


def test_an_orbit_that_stays_on_the_corner_makes_no_event():
    # For a = 1/2, b = -3 and any mu > 0: 0 -> mu -> -2 mu -> 0.
    f = examples.border_collision(0.5, -3.0, 0.3)
    found = bifurcations(f, "mu", (0.1, 0.9), max_period=3, n_lists=9)
    assert len(found) == 0
    assert not found.unresolved
    (branch,) = (b for b in found.curves if b.period == 3)
    assert branch.end_reasons == ("end of range", "end of range")
    assert abs(branch.points[:, 1]).max() < 1e-15
