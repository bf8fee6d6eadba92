"""One result of every public kind, computed once."""

from functools import cache
from typing import ClassVar

from tests.analysis import known_maps as examples
from tests.analysis import known_maps_nd as examples_nd

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

    def make_OrbitListND(self):
        return ss.periodic_orbits(examples_nd.henon(), 2)

    def make_PeriodicOrbitND(self):
        return self["OrbitListND"][0]

    # --- along a parameter --------------------------------------------------------------------

    def make_BifurcationList(self):
        f = self.systems["BifurcationList"]
        return ss.bifurcations(f, "r", (2.9, 3.56), max_period=2)

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
