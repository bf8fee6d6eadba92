"""One result of every public kind, computed once."""

from functools import cache
from typing import ClassVar

import numpy as np
from tests.analysis import known_maps as examples
from tests.analysis import known_maps_nd as examples_nd
from tests.analysis import plane_maps

import stickslip as ss

COULOMB = ss.examples.coulomb()
BLOCK = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=1.0)
CHAIN = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=ss.Coulomb(mu=0.3))


class Samples:
    """Results by the names of their classes; ``systems``: what `load` must be given for some."""

    systems: ClassVar = {
        "BifurcationList": examples.logistic(3.0),
    }

    @cache  # noqa: B019 (one instance lives for the whole session)
    def __getitem__(self, name):
        return getattr(self, f"make_{name}")()

    names = property(lambda self: [key[5:] for key in dir(self) if key.startswith("make_")])

    # --- of one map ---------------------------------------------------------------------------

    def make_OrbitList(self):
        return ss.periodic_orbits(COULOMB, 1, infinitely_unstable=True)

    def make_PeriodicOrbit(self):
        return self["OrbitList"][0]

    def make_BranchTable(self):
        return ss.branches(COULOMB)

    def make_Branch(self):
        return self["BranchTable"][0]

    def make_BreakpointList(self):
        return ss.breakpoints(ss.event_map(COULOMB))

    def make_Breakpoint(self):
        return self["BreakpointList"][0]

    def make_AttractorList(self):
        return ss.attractors(COULOMB)

    def make_Attractor(self):
        return self["AttractorList"][0]

    def make_Basins(self):
        return ss.basins(COULOMB)

    def make_LyapunovExponent(self):
        return ss.lyapunov_exponent(COULOMB, [0.1, 0.2], 2000)

    def make_InvariantDensity(self):
        f = examples.tent(1.9)
        return ss.invariant_density(f, ss.attractors(f)[0], cells=200)

    def make_PointValues(self):
        return examples.logistic(3.3).evaluate([0.2, 0.3])

    def make_EventMapResult(self):
        return ss.event_map(COULOMB).evaluate([-0.2, 0.1, 0.3])

    def make_QuasistaticSlips(self):
        return ss.quasistatic_map(COULOMB).slips([0.1, 0.5])

    # --- of maps of R^n -----------------------------------------------------------------------

    def make_AttractorListND(self):
        return ss.attractors(plane_maps.henon(), n_starts=16)

    def make_AttractorND(self):
        return self["AttractorListND"][0]

    def make_BasinsND(self):
        found = self["AttractorListND"]
        return ss.basins(plane_maps.henon(), found, grid=[(-2, 2, 16), (-2, 2, 16)])

    def make_BasinFractions(self):
        return ss.basin_fractions(plane_maps.henon(), "a", [1.2, 1.25], n_samples=32, n_starts=8)

    def make_Safety(self):
        return ss.safety(COULOMB, kicks=0.05, n_samples=64, n_runs=16, n_impulses=4)

    def make_SafetyList(self):
        return ss.safety(examples.logistic(3.0), "r", [3.2, 3.3], n_samples=64)

    def make_RotationNumber(self):
        f = ss.Map(lambda x, w: x + w, 1, parameters={"w": 0.4}, periodic=[1.0])
        return ss.rotation_number(f, [[0.1], [0.2]], 100)

    def make_OrbitListND(self):
        return ss.periodic_orbits(examples_nd.henon(), 2)

    def make_PeriodicOrbitND(self):
        return self["OrbitListND"][0]

    def make_LyapunovSpectrum(self):
        return ss.lyapunov_spectrum(examples_nd.henon(), [0.1, 0.1], 500)

    def make_LyapunovSpectra(self):
        return ss.lyapunov_spectra(examples_nd.henon(), "a", [1.2, 1.4], [0.1, 0.1], 500)

    def make_ZeroOneTest(self):
        return ss.zero_one_test(np.cos(np.arange(200.0)), n_frequencies=5)

    # --- along a parameter --------------------------------------------------------------------

    def make_BifurcationList(self):
        f = self.systems["BifurcationList"]
        return ss.bifurcations(f, "r", (2.9, 3.56), max_period=2, n_lists=6)

    def make_Bifurcation(self):
        return self["BifurcationList"][0]

    def make_Cascade(self):
        return self["BifurcationList"].cascades[0]

    def make_Diagram(self):
        return ss.bifurcation_diagram(examples.logistic(3.0), "r", (2.9, 3.5, 31), max_period=2)

    def make_Curve(self):
        return ss.follow(ss.periodic_orbits(COULOMB)[0], "V", (0.0366, 0.0368))

    # --- in time ------------------------------------------------------------------------------

    def make_Trajectory(self):
        return ss.simulate(COULOMB, d=0.1, t_end=60)

    def make_Sensitivity(self):
        return self["Trajectory"].derivative("mu", "d")

    def make_Fit(self):
        t = np.linspace(0, 20, 60)
        x = ss.simulate(BLOCK, [0.3], [0.1], t_end=20).x(t)
        return ss.fit(BLOCK, ss.Record(t, x + 1e-3 * np.sin(9 * t)[:, None]), ["gamma"])

    def make_Comparison(self):
        other = BLOCK.replace(friction=ss.Coulomb(mu=0.5))
        return ss.compare_fits([self["Fit"], ss.fit(other, self["Fit"].data, ["mu"])])

    def make_Propagated(self):
        return ss.propagate(COULOMB, {"V": [0.0366, 0.0372]}, lambda model: model.V)

    def make_Profile(self):
        return self["Fit"].profile("gamma")

    def make_Energy(self):
        return self["Trajectory"].energy([0.0, 10.0, 20.0])

    def make_PhysicalTrajectory(self):
        units = ss.Units(m=2.0, k=8.0, fs1=4.0)
        return COULOMB.to_physical(self["Trajectory"], units)

    def make_Cycle(self):
        return ss.find_cycle(BLOCK, [0.0], [0.0])

    def make_CycleList(self):
        return ss.limit_cycles(BLOCK, n_starts=4, rng=1)

    def make_TrappingBall(self):
        return ss.trapping_ball(self["Cycle"])

    def make_Equilibrium(self):
        return ss.equilibria(BLOCK)[0]

    def make_HopfPoint(self):
        return self["Equilibrium"].hopf_points[0]

    def make_NeutralFamily(self):
        return ss.equilibria(COULOMB)[0].neutral_family

    def make_ReturnRegion(self):
        return ss.return_region(COULOMB, "V", (0.3, 0.5), n_values=2, n_points=31)

    def make_Gap(self):
        return next(gap for gaps in self["ReturnRegion"].gaps for gap in gaps)

    # --- proofs -------------------------------------------------------------------------------

    def make_Certificate(self):
        return ss.certify(next(o for o in self["OrbitList"] if o.jump is None), COULOMB)

    def make_Enclosure(self):
        return ss.enclose(COULOMB, ("0.27", "0.2701"), V=("0.0366", "0.03661"))
