"""
A bifurcation in the plane of two parameters
============================================

Where the stable orbit ends, as a curve, with the points at which its cause or kind changes.
"""

import stickslip as ss

model = ss.examples.coulomb()
(collision,) = ss.bifurcations(model, "V", (0.0366, 0.0372))
curve = ss.follow(collision, "alpha", (1.198, 1.204), solve_for="V")
print(curve)
curve.plot()
