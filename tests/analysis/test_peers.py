"""Assertions of the public tests of other projects, one to a row.

AUTO-07p (github.com/auto-07p/auto-07p): numbers that test/hyper.all keeps of its demos hen and log.
Attractors.jl, ChaosTools.jl, PeriodicOrbits.jl (github.com/JuliaDynamics): what their test folders
assert of maps. More of theirs: test_attractors_nd.py (basins, matching, magnets), test_spectrum.py,
test_zero_one.py.
"""

import functools
import math

import numpy as np
import pytest
from tests.analysis.plane_maps import TURN, henon, newton, points, standard

import stickslip as ss
from stickslip.analysis.maps.protocol import box_points

PRINTED = 1e-5  # AUTO prints six digits, of values known to EPSL = EPSU = 1e-6
FOUR = 5e-5  # of four decimals
GREENE = 0.971635  # parameter of the standard map

# ------------------------------------------------------------------ systems


def auto_hen(alpha=2.0, beta=0.0):
    """Make x' = y, y' = alpha - beta x - y^2 (demos/hen/hen.f90)."""
    return ss.Map(
        lambda u, alpha, beta: points(u[..., 1], alpha - beta * u[..., 0] - u[..., 1] ** 2),
        2,
        parameters={"alpha": alpha, "beta": beta},
        domain=[(-4, 4), (-4, 4)],
    )


def logistic(r=3.2):
    return ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": r})


def halves(r):
    """Make the "dumb map" of Attractors.jl: one fixed point for r < 1/2, then one on each side."""

    def func(z, r):
        side = np.where(z[..., 0] >= 0, r, -r) * (r >= 0.5)
        return points(side, side)

    return ss.Map(func, 2, parameters={"r": r}, domain=[(-2, 2), (-2, 2)])


def cubic():
    return ss.PiecewiseMap(lambda x, r: r * x - x**3, (-2.5, 2.5), parameters={"r": 2.0})


# ------------------------------------------------------------------ what is asked of them


@functools.cache
def event(kind, name, ends, **fixed):
    """Bifurcation of a fixed point of hen along a parameter: its value and coordinate."""
    found = ss.bifurcations(auto_hen(**dict(fixed)), name, ends, max_period=1, n_lists=4)
    (item,) = [item for item in found if item.kind == kind]
    return [item.value, item.points[0, 0]]


def resonance(alpha, x):
    """Angle of the multipliers of the fixed point at x, beta = 1, in turns, and their modulus."""
    orbits = ss.periodic_orbits(auto_hen(alpha, 1.0), n_starts=64)
    (orbit,) = [orbit for orbit in orbits if abs(orbit.points[0, 0] - x) < PRINTED]
    first = orbit.multipliers[0]
    return [abs(np.angle(first)) / TURN, abs(first)]


@functools.cache
def cascade():
    found = ss.bifurcations(logistic(), "r", (2.9, 3.566), max_period=8, n_lists=6)
    return {item.period: item for item in found if item.kind == "flip"}


def flip(period, x):
    """Parameter of a flip of the logistic map, and its point closest to x."""
    at = cascade()[period]
    near = np.asarray(at.points).ravel()
    return [at.value, near[np.abs(near - x).argmin()]]


@functools.cache
def orbits(name, value, period, n_starts=None):
    f = {"henon": henon, "standard": standard}[name](value)
    return ss.periodic_orbits(f, period=period, n_starts=n_starts)


def off_by(f, period, orbit):
    """Distance from a point of an orbit to its image under f^period."""
    return max(float(np.abs(f.iterate(x, period)[-1] - x).max()) for x in orbit.points)


def four_decimals(period):
    """Coordinates of the standard map's orbits that are not among the published ones."""
    listed = {
        2: ("0 3.1416 1.3346 4.9486", "0 3.1416 2.6693 3.6139"),
        3: (
            "0 0.8121 5.471 3.1416 1.7774 4.5058 6.2832",
            "1.6243 2.3295 3.9537 4.6589 1.7774 4.5058 3.5548 2.7284",
        ),
    }[period]
    found = np.concatenate([orbit.points for orbit in orbits("standard", GREENE, period)])
    known = [np.array(text.split(), dtype=float) for text in listed]
    away = [
        np.abs((found[:, k, None] - known[k] + math.pi) % TURN - math.pi).min() for k in range(2)
    ]
    return max(away)


def born():
    """Fixed points of f^3 of the logistic map where period 3 is born: a near-fold of the list."""
    f = logistic(1 + math.sqrt(8))
    found = ss.periodic_orbits(f, 3)
    (fold,) = found.near_folds
    fixed = [orbit.points[0] for orbit in found if orbit.period == 1]
    return sorted([*fixed, *f.iterate(fold.x, 2)])


@functools.cache
def attractors(name, *values):
    maps = {"henon": henon, "halves": halves, "turned": lambda mu, j: henon(mu, -j, WIDE)}
    return ss.attractors(maps[name](*values))


WIDE = ((-3.0, 3.0), (-3.0, 4.0))


@functools.cache
def basins(name):
    if name == "henon":
        return ss.basins(henon(), attractors("henon", 1.4), grid=[(-2, 2, 100), (-2, 2, 100)])
    if name == "newton":
        starts = box_points(np.array([[-1.5, 1.5]] * 2), 64)
        found = ss.attractors(newton(), starts=starts)
        return ss.basins(newton(), found, grid=[(-1.5, 1.5, 400), (-1.5, 1.5, 400)])
    return ss.basins(halves(1.0), grid=[(-1, 1, 3), (-1, 1, 3)])


def shares(found):
    return sorted(found.share(k).value for k in range(len(found.attractors)))


def index_at(found, x, y):
    """Sign of the attractor's first coordinate, where the orbit from a point ends."""
    at = ss.basins(found.system, found, grid=[(x, x + 1e-9, 2), (y, y + 1e-9, 2)]).index[0, 0]
    return int(np.sign(found[at].points[0, 0])) if at >= 0 else int(at)


def smallest_shocks():
    """Smallest displacements of the roots into another basin, on the grid."""
    found = basins("newton")
    x, y = np.meshgrid(*found.axes, indexing="ij")
    roots = [attractor.points[0] for attractor in found.attractors]
    away = [
        np.hypot(x - root[0], y - root[1])[found.index != k].min() for k, root in enumerate(roots)
    ]
    return [min(away), max(away)]


def saddles():
    """Unstable fixed points of the cubic map; its other two are at a flip."""
    return [o.points[0] for o in ss.periodic_orbits(cubic()) if abs(o.multiplier) > 1.1]


def chaotic(start, k):
    """0-1 test of the angle of the standard map, as ChaosTools samples it."""
    series = standard(k).iterate(start, 10_000)[:, 0]
    return bool(ss.zero_one_test(series).chaotic)


def cat():
    return ss.Map(
        lambda z: points(2 * z[..., 0] + z[..., 1], z[..., 0] + z[..., 1]), 2, periodic=[1.0, 1.0]
    )


def values_at(r, n=3):
    """Points of an orbit of the logistic map after 5000 steps."""
    return logistic(r).iterate(0.4, 5000 + n)[5000:]


# ------------------------------------------------------------------ the table

HEN, LOG = "AUTO-07p test/hyper.all, hen:", "AUTO-07p test/hyper.all, log:"
CT, PO, AT = "ChaosTools.jl test/", "PeriodicOrbits.jl test/", "Attractors.jl test/"
FP, DL = CT + "stability/fixedpoints.jl:", CT + "periodicity/davidchacklai.jl:"
SD = PO + "algorithms/discrete_time/schmelcher_diakonos.jl:"
STABLE, MAPPING = PO + "stability.jl:", AT + "mapping/attractor_mapping.jl:"

ROWS = [
    # source and claim, ours, theirs, how far they may be apart
    (f"{HEN} PD", lambda: event("flip", "beta", (0.3, 0.9)), [0.632992, 0.816497], PRINTED),
    (f"{HEN} TR", lambda: event("neimark_sacker", "beta", (0.8, 1.2)), [1, 0.732051], PRINTED),
    (f"{HEN} PD", lambda: event("flip", "alpha", (0.2, 1.2)), [0.750001, 0.5], PRINTED),
    (f"{HEN} LP", lambda: event("fold", "alpha", (-0.6, 0.2)), [-0.25, -0.49999], 2 * PRINTED),
    (f"{HEN} R2", lambda: resonance(3.0, 1.0), [1 / 2, 1], PRINTED),
    (f"{HEN} R3", lambda: resonance(1.25, 0.5), [1 / 3, 1], PRINTED),
    (f"{HEN} R4", lambda: resonance(0.0, 0.0), [1 / 4, 1], PRINTED),
    (f"{HEN} R1", lambda: event("fold", "alpha", (-1.5, -0.5), beta=1.0), [-1, -1], PRINTED),
    (
        f"{HEN} PD curve, UZ",
        lambda: event("flip", "alpha", (3.7, 4.2), beta=1.3094),
        [3.99999, 1.1547],
        5 * PRINTED,  # beta is rounded
    ),
    (
        f"{HEN} PD curve, UZ, DS < 0",
        lambda: event("flip", "alpha", (2.5, 3.5), beta=-3.0),
        [3.0, -1.0],
        PRINTED,
    ),
    (
        f"{HEN} LP curve, UZ",
        lambda: event("fold", "alpha", (-2.4, -1.6), beta=1.82837),
        [-1.99993, -1.41419],
        5 * PRINTED,
    ),
    (
        f"{HEN} LP curve, UZ, DS < 0",
        lambda: event("fold", "alpha", (-1.3, -0.7), beta=-3.00004),
        [-1.00004, 1.00002],
        5 * PRINTED,
    ),
    (f"{LOG} PD of period 1", lambda: flip(1, 0.666667), [3.0, 0.666667], PRINTED),
    (f"{LOG} PD of period 2", lambda: flip(2, 0.43996), [3.44949, 0.43996], PRINTED),
    (f"{LOG} PD of period 4", lambda: flip(4, 0.523595), [3.54409, 0.523595], PRINTED),
    (f"{LOG} PD of period 8", lambda: flip(8, 0.490608), [3.56441, 0.490608], PRINTED),
    (
        f"{FP} two fixed points of the Hénon map",
        lambda: [orbit.stable for orbit in orbits("henon", 1.4, 1)],
        [False, False],
        0,
    ),
    (
        f"{FP} one of them in closed form",
        lambda: orbits("henon", 1.4, 1)[0].points[0].tolist(),
        [-0.25 - math.sqrt(6.09) / 2.8, -0.075 - 0.3 * math.sqrt(6.09) / 2.8],
        1e-12,
    ),
    (
        f"{FP} points of order 4 return",
        lambda: max(off_by(henon(), 4, orbit) for orbit in orbits("henon", 1.4, 4)),
        0.0,
        1e-8,
    ),
    (
        f"{DL} points of the Hénon map of order 10 return",
        lambda: max(off_by(henon(), 10, orbit) for orbit in orbits("henon", 1.4, 10)),
        0.0,
        1e-12,
    ),
    (f"{DL} two fixed points", lambda: len(ss.periodic_orbits(logistic(1 + math.sqrt(8)))), 2, 0),
    (
        f"{DL} they are 0 and (r - 1) / r",
        lambda: [x for o in ss.periodic_orbits(logistic(1 + math.sqrt(8))) for x in o.points],
        [0.0, 1 - 1 / (1 + math.sqrt(8))],
        1e-13,
    ),
    (
        f"{DL} order 3 at its birth",
        born,
        [0.0, 0.1599288, 0.5143553, 0.7387961, 0.9563178],
        1e-7,
    ),
    (f"{CT}timeevolution/orbitdiagram.jl: r = 2", lambda: values_at(2.0)[0], 0.5, 1e-8),
    (f"{CT}timeevolution/orbitdiagram.jl: r = 2.01", lambda: values_at(2.01)[0], 0.502487562, 1e-8),
    (
        f"{CT}timeevolution/orbitdiagram.jl: r = 4, different values",
        lambda: len(set(values_at(4.0, 2).tolist())),
        3,
        0,
    ),
    (
        f"{CT}periodicity/periodicorbits.jl, {SD} order 2",
        lambda: four_decimals(2),
        0.0,
        FOUR,
    ),
    (
        f"{CT}periodicity/periodicorbits.jl, {SD} order 3",
        lambda: four_decimals(3),
        0.0,
        FOUR,
    ),
    (
        f"{CT}rareevents/return_time_tests.jl: (0.8121, 1.6243) returns after 3 steps",
        lambda: min(
            np.abs(o.points - [0.8121, 1.6243]).max(axis=1).min()
            for o in orbits("standard", GREENE, 3)
        ),
        0.0,
        FOUR,
    ),
    (
        f"{CT}chaosdetection/expansionentropy.jl: cat map",
        lambda: ss.lyapunov_spectrum(cat(), [0.001245, 0.00875], 2000).values[0],
        math.log((3 + math.sqrt(5)) / 2),
        1e-12,
    ),
    (f"{CT}chaosdetection/01test.jl: chaotic", lambda: chaotic([0.001, 0.008], 1.0), True, 0),
    (f"{CT}chaosdetection/01test.jl: regular", lambda: chaotic([math.pi, 0.01], 1.0), False, 0),
    *(
        (
            f"{CT}chaosdetection/partially_predictable.jl: Hénon map at a = {a}",
            lambda a=a: [item.kind for item in attractors("henon", a)],
            [kind],
            0,
        )
        for a, kind in ((0.8, "periodic"), (1.0, "periodic"), (1.11, "chaotic"), (1.4, "chaotic"))
    ),
    *(
        (
            f"{STABLE} logistic map at r = {r}",
            lambda r=r: ss.periodic_orbits(logistic(r))[-1].stable,
            stable,
            0,
        )
        for r, stable in ((2.3, True), (3.3, False))
    ),
    (
        f"{STABLE} period 2 of the Hénon map",
        lambda: [orbit.stable for orbit in orbits("henon", 1.4, 2)],
        [False],
        0,
    ),
    (
        f"{PO}algorithms/discrete_time/davidchack_lai.jl: order 6 of 10, points return",
        lambda: max(off_by(henon(), 6, orbit) for orbit in orbits("henon", 1.4, 6)),
        0.0,
        1e-12,
    ),
    (
        f"{PO}minimal_period.jl: 3 of 12",
        lambda: ss.periodic_orbits(logistic(1 + math.sqrt(8)), 3).near_folds[0].period,
        3,
        0,
    ),
    (
        f"{MAPPING} shares of the map with two halves",
        lambda: shares(ss.basins(halves(1.0), n_samples=1000)),
        [0.5, 0.5],
        0.1,
    ),
    (
        f"{AT}mapping/basins_of_attraction.jl: shares on three columns",
        lambda: shares(basins("halves")),
        [0.33, 0.66],
        0.01,
    ),
    (f"{MAPPING} [r, r] goes to r", lambda: index_at(attractors("halves", 1.0), 1.0, 1.0), 1, 0),
    (
        f"{MAPPING} [-r, -r] goes to -r",
        lambda: index_at(attractors("halves", 1.0), -1.0, -1.0),
        -1,
        0,
    ),
    (f"{MAPPING} one attractor of the Hénon map", lambda: len(attractors("henon", 1.4)), 1, 0),
    (f"{MAPPING} [0, 2] diverges", lambda: index_at(attractors("henon", 1.4), 0.0, 2.0), -2, 0),
    (
        f"{MAPPING} share of the Hénon map",
        lambda: basins("henon").share(0).value,
        0.425,
        4 * math.sqrt(0.425 * 0.575 / 1000),  # theirs are 1000 starts
    ),
    (
        f"{MAPPING} shares add up",
        lambda: basins("henon").share(0).value + basins("henon").share(-2).value,
        1.0,
        1e-14,
    ),
    (
        f"{AT}mapping/recurrence.jl: from [10, 10] to infinity",
        lambda: bool(
            np.isnan(henon(domain=((-20, 20), (-20, 20))).iterate([10.0, 10.0], 5)[-1, 0])
        ),
        True,
        0,
    ),
    (
        f"{AT}nonlocal/stability_quantifiers_accumulator.jl: basin_fraction",
        lambda: shares(basins("halves")),
        [0.33333, 0.66667],
        1e-5,
    ),
    (
        f"{AT}nonlocal/stability_quantifiers_accumulator.jl: fixed point and period 3",
        lambda: sorted(item.period for item in attractors("turned", 1.05, 0.9)),
        [1, 3],
        0,
    ),
    (f"{AT}boundaries/edgetracking_tests.jl: saddle of the cubic map", saddles, [0.0], 1e-5),
    (
        f"{AT}nonlocal/mfstest.jl: smallest shocks of the roots of z^3 = 1",
        smallest_shocks,
        [0.622, 0.622],
        math.hypot(3 / 399, 3 / 399) + 0.01 * 0.622,  # a step of the grid, and theirs
    ),
    (
        f"{AT}continuation/recurrences_continuation.jl: one attractor for r < 1/2",
        lambda: len(attractors("halves", 0.3)),
        1,
        0,
    ),
    (
        f"{AT}continuation/seed_continue_generic.jl: two for r > 1/2",
        lambda: len(attractors("halves", 1.5)),
        2,
        0,
    ),
]


@pytest.mark.parametrize(
    ("ours", "theirs", "error"), [row[1:] for row in ROWS], ids=[row[0] for row in ROWS]
)
def test_a_claim_of_a_peer_holds(ours, theirs, error):
    assert ours() == pytest.approx(theirs, rel=0, abs=error) if error else ours() == theirs


def test_there_are_many_claims_of_several_projects():
    projects = {row[0].split()[0] for row in ROWS}
    assert projects == {"AUTO-07p", "ChaosTools.jl", "PeriodicOrbits.jl", "Attractors.jl"}
    assert len(ROWS) >= 40
