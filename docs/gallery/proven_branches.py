"""
Proven branches
===============

Orbits of the paper's system proven for every value of V in an interval, not at samples of it: the
fixed points, and the orbit of period 4 up to the value at which it is lost at a jump of the map.
What is proven is solid, the rest dashed.
"""

import stickslip as ss
from stickslip.plot.bifurcations import draw_orbit_curve
from stickslip.proofs.certify import certify_branch

model = ss.examples.coulomb()
ax = None
for orbit in ss.periodic_orbits(model, 4):
    curve = ss.follow(orbit, "V", (0.0364, 0.0374))
    proof = certify_branch(model, orbit.points[0], orbit.period, "V", (0.0366, 0.0372), digits=10)
    print(proof.statement, end="\n\n")
    ax = draw_orbit_curve(curve, ax, proven=proof)

ax.set_title("solid: proven for every V")
