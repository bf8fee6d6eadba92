"""Comparisons of laws: the law that made the data is preferred, and what is compared is told."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sizes import sizes

import stickslip as ss

BLOCK = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=0.1)
LAWS = {
    "Coulomb": (ss.Coulomb(mu=0.5), ["mu"]),
    "Stribeck": (ss.Stribeck(mu=0.5, speed=0.3), ["mu", "speed"]),
    "law (9)": (ss.PoppStelter(gamma=3.0, eta=0.05), ["gamma", "eta"]),
    "own": (
        # One formula with test_fit.py: it shares its kernels.
        ss.friction_law("a - b * log1p(s / v)", parameters={"a": 1.0, "b": 0.15, "v": 0.1}),
        ["b", "v"],
    ),
}
S = np.geomspace(0.01, 2.0, 60)


def forces(law, seed: int, sigma: float = 0.005) -> ss.ForcePoints:  # type: ignore[no-untyped-def]
    noise = np.random.default_rng([seed, 1]).normal(scale=sigma, size=len(S))
    return ss.ForcePoints(S, law.force(S) + noise, sigma=sigma)


def compared(seen, **settings) -> ss.identification.comparison.Comparison:  # type: ignore[no-untyped-def,name-defined]
    fits = {
        name: ss.fit(BLOCK.replace(friction=law), seen, names)
        for name, (law, names) in LAWS.items()
    }
    return ss.compare_fits(fits, **settings)


@pytest.mark.parametrize("n", sizes(2, 5))
@pytest.mark.parametrize("true", LAWS)
def test_the_law_that_made_the_forces_is_preferred(true: str, n: int) -> None:
    law, names = LAWS[true]
    best = [compared(forces(law, seed)) for seed in range(n)]
    assert [found.law[0] for found in best].count(true) >= n - 1
    for found in best:
        at = found.law.index(true)
        assert found.unknowns[at] == len(names)
        assert found.aic_rise[at] < 8.0
        assert 0.7 < found.left_out[at] < 1.3  # as large as the errors
        others = [name for name in found.law if true != "Coulomb" and name == "Coulomb"]
        for other in others:
            assert found.left_out[found.law.index(other)] > 5.0
        assert found.weight.sum() == pytest.approx(1.0)
        assert (np.diff(found.aic_rise) >= 0.0).all()


def test_records_are_left_out_one_by_one() -> None:
    t = np.linspace(0.0, 20.0, 200)

    def short(seed: int, x: float) -> ss.Record:
        seen = ss.simulate(BLOCK, [x], [0.0], t_end=20.0).x(t)
        noise = np.random.default_rng(seed).normal(scale=0.005, size=seen.shape)
        return ss.Record(t, seen + noise, sigma=0.005)

    records = [short(1, 0.0), short(2, -0.4), short(3, 0.3)]
    right = ss.fit(BLOCK.replace(mu=0.45), records, ["mu", "speed"])
    coulomb = BLOCK.replace(friction=ss.Coulomb(mu=0.45))
    found = ss.compare_fits([ss.fit(coulomb, records, ["mu"]), right])
    assert found.law == ("stribeck", "coulomb")
    assert found.fits[0] is right
    assert found.unknowns[0] == 8  # two parameters, three starts
    assert 0.8 < found.left_out[0] < 1.2
    assert found.left_out[1] > 3.0
    assert "coulomb: the model does not tell these data" in found.message
    (one, *_) = records
    alone = ss.compare_fits({"a": ss.fit(BLOCK, one, ["mu"]), "b": ss.fit(BLOCK, one, [])})
    assert np.isnan(alone.left_out).all()  # one record is not cut


def test_a_law_of_measured_points_has_no_unknowns() -> None:
    law, _ = LAWS["Stribeck"]
    knots = np.linspace(0.0, 2.0, 21)
    table = BLOCK.replace(friction=ss.TabulatedFriction(knots, law.force(knots)))
    seen = forces(law, 3)
    as_it_is = ss.fit(table, seen, [])
    assert as_it_is.n_unknowns == 0
    assert as_it_is.table().n_rows == 0
    off = (table.laws[0].force(S) - seen.force) / 0.005
    assert as_it_is.chi2 == pytest.approx(float(np.sum(off**2)), rel=1e-12)
    assert "chi2" in repr(as_it_is)
    found = ss.compare_fits([as_it_is, ss.fit(BLOCK, seen, ["mu", "speed"])])
    assert set(found.law) == {"TabulatedFriction", "stribeck"}
    assert np.isfinite(found.left_out).all()


def test_a_table_of_the_very_points_is_no_law_to_compare() -> None:
    s = np.linspace(0.0, 2.0, 21)
    seen = ss.ForcePoints(s, LAWS["Stribeck"][0].force(s))
    table = BLOCK.replace(friction=ss.TabulatedFriction(seen.speed, seen.force))
    with pytest.raises(ValueError, match="very points"):
        ss.compare_fits([ss.fit(table, seen, []), ss.fit(BLOCK, seen, ["mu"])])


def test_data_taken_in_any_units_are_left_out_like_others() -> None:
    law, s = ss.Stribeck(mu=0.5, speed=30.0), np.geomspace(1.0, 300.0, 40)
    noise = np.random.default_rng(1).normal(scale=0.005, size=len(s))
    seen = ss.ForcePoints(s, law.force(s) + noise, sigma=0.005)
    fits = [
        ss.fit(BLOCK.replace(friction=each), seen, names, check_units=False)
        for each, names in ((law, ["mu", "speed"]), (ss.Coulomb(mu=0.5), ["mu"]))
    ]
    found = ss.compare_fits(fits)
    assert found.law == ("stribeck", "coulomb")
    assert found.left_out[0] == pytest.approx(1.0, abs=0.3)
    assert found.left_out[1] > 5.0
    with pytest.raises(ValueError, match="same units"):
        fits[0].misfit(seen)


def test_what_is_known_besides_counts_as_data() -> None:
    seen = forces(LAWS["Stribeck"][0], 4)
    free = ss.fit(BLOCK, seen, ["mu", "speed"])
    vague = ss.fit(BLOCK, seen, ["mu", "speed"], priors={"mu": (0.5, 1e3)})
    assert vague.n_unknowns == free.n_unknowns == 2
    assert vague.aic == pytest.approx(free.aic, abs=1e-4)
    wrong = ss.fit(BLOCK, seen, ["mu", "speed"], priors={"mu": (0.8, 0.01)})
    assert wrong.aic > free.aic + 100.0


def test_what_cannot_be_compared_is_refused() -> None:
    law, names = LAWS["Stribeck"]
    one, other = (ss.fit(BLOCK, forces(law, seed), names) for seed in (1, 2))
    with pytest.raises(ValueError, match="other data"):
        ss.compare_fits({"one": one, "other": other})
    with pytest.raises(ValueError, match="two or more"):
        ss.compare_fits([one])
    with pytest.raises(ValueError, match="same law"):
        ss.compare_fits([one, one])
    with pytest.raises(ValueError, match="two or more fits"):
        ss.compare_fits({"one": one, "other": forces(law, 1)})  # type: ignore[dict-item]
