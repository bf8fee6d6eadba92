"""Attractors by brute force at many parameter values, against what the list says of them."""

from collections import Counter
from itertools import pairwise, product

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from tests.analysis.bifurcations.scan.test_survey import MU, random_family

import stickslip as ss
from stickslip.analysis.bifurcations.bifurcations import bifurcations
from stickslip.numerics.targets import kernel

PERIOD = 3  # longest that is asked for
STARTS = 31
PART = 1000  # steps of orbits that are kept at once
RECURS = 1e-7
BESIDE = 1e-3  # of the range: closer to something listed transients are too long to tell
TINY = 1e-9  # what roots of polynomials are good for
BESIDE_REAL = 1e-5  # imaginary part of roots that are about to be real
EVERY = 10  # value at which orbits are counted by roots


def settled(orbits_of, x, n, longest=64):
    """Periods that orbits from x settle on, 0 for what does not recur, and where they are.

    Nothing for what leaves.
    """
    while n > 0:
        x, n = orbits_of(x, min(n, PART))[:, -1], n - PART
        x = x[np.isfinite(x)]
    orbits = orbits_of(x, 4 * longest)
    orbits = orbits[np.isfinite(orbits[:, -1])]
    periods = [
        next((p for p in range(1, longest) if np.abs(o[p:] - o[:-p]).max() < RECURS), 0)
        for o in orbits
    ]
    return np.array(periods, dtype=int), orbits[:, -1]


def stable_periods(found, q):
    """Periods of the branches that are stable at a value."""
    periods = set()
    for branch in found.curves:
        values, stable = np.asarray(branch.values), np.asarray(branch.stable)
        here = (values[:-1] - q) * (values[1:] - q) < 0
        if (here & stable[:-1] & stable[1:]).any():
            periods.add(branch.period)
    return periods


def unaccounted(found, orbits_at, domain_at, n_values, n_steps):
    """Values at which orbits settle on what the list neither has nor sets apart."""
    (lo, hi), listed = found.range, np.array([item.value for item in found])
    silent = []
    for q in np.linspace(lo, hi, n_values + 2)[1:-1]:
        if listed.size and np.abs(listed - q).min() < BESIDE * (hi - lo):
            continue
        if any(item.lo <= q <= item.hi for item in (*found.outside, *found.unresolved)):
            continue
        known, (left, right) = stable_periods(found, q), domain_at(q)
        orbits_of = orbits_at(q)
        x = left + (right - left) * (np.arange(STARTS) + 0.37) / STARTS
        # Slow orbits are given more time before they count; of what looks like chaos one, and less.
        for more in (1, 20, 400):
            periods, ends = settled(orbits_of, x, more * n_steps)
            strange = set(periods.tolist()) - known
            if not strange or (more > 1 and strange == {0}):
                break
            x = np.append(ends[np.isin(periods, [*strange - {0}])], ends[periods == 0][:1])
        if strange & set(range(1, PERIOD + 1)):
            silent.append((q, strange, known))
    return silent


def contradictory(found):
    """Events whose orbits on both sides are not those that theory puts there."""
    wrong = []
    for item in found:
        before, after = (
            [o.multiplier for o in orbits if o.period == item.period]
            for orbits in (item.orbits_before, item.orbits_after)
        )
        if item.kind == "flip":  # of one orbit that crosses
            crosses = len(before) == len(after) == 1 and (before[0] + 1) * (after[0] + 1) < 0
        elif item.kind == "fold":  # of two that end or begin
            pair = before or after
            crosses = len(before + after) == len(pair) == 2 and np.prod(np.subtract(pair, 1)) < 0
        else:
            continue
        if not crosses:
            wrong.append((item.kind, item.value, before, after))
    return wrong


def pieces_of(f):
    """Coefficients of the parabolas of a map, and the ends of each, from three points of it."""
    ends = [-1.0, *f.breakpoints.clip(-1, 1), 1.0]
    for a, b in pairwise(ends):
        if b > a:
            x = a + (b - a) * np.array([0.25, 0.5, 0.75])
            coefficients = Polynomial.fit(x, f(x), 2, domain=[-1, 1]).coef
            yield np.where(np.abs(coefficients) < TINY, 0.0, coefficients).tolist(), a, b


def after(piece, inner):
    """Coefficients of a parabola of a polynomial."""
    outer = piece[2] * np.convolve(inner, inner)
    outer[: inner.size] += piece[1] * inner
    outer[0] += piece[0]
    return outer


def count_of_orbits(f):
    """How many orbits of each period there are, as roots of polynomials; None near a change."""
    found, pieces = set(), list(pieces_of(f))
    for period in range(1, PERIOD + 1):
        for word in product(pieces, repeat=period):
            off = np.array([0.0, 1.0])
            for piece, _, _ in word:
                off = after(piece, off)
            off[1] -= 1
            for root in Polynomial(off).trim(TINY).roots():
                if abs(root.imag) > BESIDE_REAL:
                    continue
                x, slope, orbit, room = float(root.real), 1.0, [], np.inf
                for (c_0, c_1, c_2), a, b in word:
                    orbit.append(x)
                    room = min(room, x - a, b - x)
                    slope *= c_1 + 2 * c_2 * x
                    x = c_0 + x * (c_1 + x * c_2)
                if room < -TINY or len({round(x, 7) for x in orbit}) < period:
                    continue
                if abs(root.imag) > TINY or room < TINY or abs(abs(slope) - 1) < BESIDE:
                    return None
                found.add((period, round(min(orbit), 7)))
    return Counter(period for period, _ in found)


def parabolas(seed):
    f = random_family(np.random.default_rng(seed))
    return f, bifurcations(f, "mu", MU, max_period=PERIOD)


def miscounted(found, f, n_values):
    """Values at which the branches are not as many as the orbits."""
    wrong = []
    for q in np.linspace(*found.range, n_values + 2)[1:-1]:
        there = count_of_orbits(f.replace(mu=q))
        if there is None or any(item.lo <= q <= item.hi for item in found.unresolved):
            continue
        branches = Counter()
        for branch in found.curves:
            off = np.asarray(branch.values) - q
            branches[branch.period] += int((off[1:] * off[:-1] < 0).sum())
        listed = Counter({p: n for p, n in branches.items() if n and p <= PERIOD})
        if there != listed:
            wrong.append((q, there, listed))
    return wrong


@kernel
def fill_orbits(orbits, breaks, a, b, c):
    """Iterate the parabolas a + b x + c x^2 between breaks from the first column on."""
    for orbit in orbits:
        for k in range(1, orbit.size):
            y, here = orbit[k - 1], np.searchsorted(breaks, orbit[k - 1], side="right")
            y = a[here] + y * (b[here] + y * c[here])
            if not abs(y) <= 1:
                break
            orbit[k] = y


def unaccounted_in_parabolas(found, f, n_values):
    def orbits_at(q):
        pieces = list(pieces_of(f.replace(mu=q)))
        breaks = np.array([a for _, a, _ in pieces[1:]])
        coefficients = np.array([piece for piece, _, _ in pieces]).T.copy()

        def orbits_of(x, n):
            orbits = np.full((x.size, n + 1), np.nan)
            orbits[:, 0] = x
            fill_orbits(orbits, breaks, *coefficients)
            return orbits

        return orbits_of

    strange = unaccounted(found, orbits_at, lambda q: (-1.0, 1.0), n_values, 1000)
    return strange + contradictory(found) + miscounted(found, f, n_values // EVERY)


@pytest.mark.parametrize("seed", [3])
def test_attractors_of_families_of_parabolas(seed):
    f, found = parabolas(seed)
    assert not unaccounted_in_parabolas(found, f, 40)
    assert not found.unresolved


@pytest.mark.slow
def test_attractors_of_many_families_of_parabolas():
    told = 0
    for seed in range(60):
        f, found = parabolas(seed)
        assert not unaccounted_in_parabolas(found, f, 2000), seed
        told += bool(found.unresolved)
    assert told <= 2


def random_blocks(seed):
    """A two-block system, law (9) if the seed is odd, and a range of one of its parameters."""
    rng = np.random.default_rng(seed)
    plant = random_plant(rng)
    if seed % 2:
        law = ss.PoppStelter(gamma=rng.uniform(0.5, 4), delta=rng.uniform(0, 0.4))
    else:
        law = ss.Coulomb(mu=rng.uniform(0.05, 0.8))
    return with_range(rng, ss.TwoBlock(**plant, friction=law), "gamma")


def random_stribeck(seed):
    """Likewise under Stribeck's law, a Gaussian if the seed is odd, from narrow to wide."""
    rng = np.random.default_rng(seed)
    plant = random_plant(rng)
    mu, speed = rng.uniform(0.3, 0.9), 10 ** rng.uniform(-2, -0.3)
    viscous = float(rng.uniform(0, 0.3)) * (seed % 3 == 0)
    law = ss.Stribeck(mu, speed, viscous, exponent=1 + seed % 2)
    return with_range(rng, ss.TwoBlock(**plant, friction=law), "speed")


def random_plant(rng):
    alpha, beta, V = rng.uniform(0.3, 4), rng.uniform(0.5, 2), 10 ** rng.uniform(-2.2, -0.5)
    return {"alpha": alpha, "beta": beta, "V": V}


def with_range(rng, model, own):
    names = [name for name in ("alpha", "beta", "V", "mu", own) if name in model.parameters]
    name = str(rng.choice(names))
    value = model.parameters[name]
    half = 0.5 * 10 ** rng.uniform(-3, -1) * value
    return model, name, (value - half, value + half)


def unaccounted_in_blocks(found, model, n_values):
    def map_at(q):
        return ss.event_map(model.replace(**{found.parameter: q}))

    def orbits_at(q):
        return map_at(q).iterate

    strange = unaccounted(found, orbits_at, lambda q: map_at(q).domain, n_values, 600)
    return strange + contradictory(found)


@pytest.mark.slow
@pytest.mark.parametrize("law", [0, 1])
def test_attractors_of_random_two_block_systems(law):
    told = 0
    for seed in range(law, 600, 2):
        model, name, ends = random_blocks(seed)
        found = bifurcations(model, name, ends, max_period=PERIOD)
        assert not unaccounted_in_blocks(found, model, 60), seed
        told += bool(found.unresolved)
    assert told <= 0.02 * 300
