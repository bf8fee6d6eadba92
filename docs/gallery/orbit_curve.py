"""
An orbit along a parameter
==========================

Followed through its fold and its flip to where it meets a break of the map: stable where the line
is heavy.
"""

import stickslip as ss

model = ss.examples.law9(alpha=1.2153)
orbit = next(o for o in ss.periodic_orbits(model) if o.stable)
curve = ss.follow(orbit, "alpha", (1.208, 1.2187))
print(curve)
curve.plot()
