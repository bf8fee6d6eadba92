"""Attractors by brute force at many parameter values, against what the list says of them."""

import numpy as np
import pytest
from tests.analysis.bifurcations.scan.test_survey import MU, random_family

import stickslip as ss
from stickslip.analysis.bifurcations.bifurcations import bifurcations

PERIOD = 3  # longest that is asked for
STARTS = 31
RECURS = 1e-7
BESIDE = 1e-3  # of the range: closer to something listed transients are too long to tell


def settled(step, x, n, longest=64):
    """Periods that orbits from x settle on, 0 for what does not recur; nothing for what leaves."""
    for _ in range(n):
        x = step(x)
        x = x[np.isfinite(x)]
        if not x.size:
            return set()
    tail = [x]
    for _ in range(4 * longest):
        tail.append(step(tail[-1]))
    orbits = np.array(tail)
    orbits = orbits[:, np.isfinite(orbits).all(axis=0)]
    return {
        next((p for p in range(1, longest) if np.abs(o[p:] - o[:-p]).max() < RECURS), 0)
        for o in orbits.T
    }


def stable_periods(found, q):
    """Periods of the branches that are stable at a value."""
    periods = set()
    for branch in found.curves:
        values, stable = np.asarray(branch.values), np.asarray(branch.stable)
        here = (values[:-1] - q) * (values[1:] - q) < 0
        if (here & stable[:-1] & stable[1:]).any():
            periods.add(branch.period)
    return periods


def unaccounted(found, step_at, domain_at, n_values, n_steps):
    """Values at which orbits settle on what the list neither has nor sets apart."""
    (lo, hi), listed = found.range, np.array([item.value for item in found])
    silent = []
    for q in np.linspace(lo, hi, n_values + 2)[1:-1]:
        if listed.size and np.abs(listed - q).min() < BESIDE * (hi - lo):
            continue
        if any(item.lo <= q <= item.hi for item in (*found.outside, *found.unresolved)):
            continue
        known, (left, right) = stable_periods(found, q), domain_at(q)
        start = left + (right - left) * (np.arange(STARTS) + 0.37) / STARTS
        # Slow orbits are given more time before they count.
        for n in (n_steps, 20 * n_steps):
            strange = settled(step_at(q), start, n) - known
            if not strange:
                break
        if strange & set(range(1, PERIOD + 1)):
            silent.append((q, strange, known))
    return silent


def parabolas(seed):
    f = random_family(np.random.default_rng(seed))
    return f, bifurcations(f, "mu", MU, max_period=PERIOD)


def unaccounted_in_parabolas(found, f, n_values):
    def step_at(q):
        def step(x):
            with np.errstate(all="ignore"):
                y = f.func(x, q)
            return np.where(np.abs(y) <= 1, y, np.nan)

        return step

    return unaccounted(found, step_at, lambda q: (-1.0, 1.0), n_values, 1000)


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
    alpha, beta, V = rng.uniform(0.3, 4), rng.uniform(0.5, 2), 10 ** rng.uniform(-2.2, -0.5)
    if seed % 2:
        law = ss.PoppStelter(gamma=rng.uniform(0.5, 4), delta=rng.uniform(0, 0.4))
    else:
        law = ss.Coulomb(mu=rng.uniform(0.05, 0.8))
    model = ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=law)
    names = [name for name in ("alpha", "beta", "V", "mu", "gamma") if name in model.parameters]
    name = str(rng.choice(names))
    value = model.parameters[name]
    half = 0.5 * 10 ** rng.uniform(-3, -1) * value
    return model, name, (value - half, value + half)


def unaccounted_in_blocks(found, model, n_values):
    def map_at(q):
        return ss.event_map(model.replace(**{found.parameter: q}))

    def step_at(q):
        f = map_at(q)

        def step(x):
            image, here = np.full(x.shape, np.nan), np.isfinite(x)
            image[here] = f(x[here])
            return image

        return step

    return unaccounted(found, step_at, lambda q: map_at(q).domain, n_values, 600)


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
