"""
An orbit along a parameter
==========================

Followed through its folds and flips to where it ends, and why.
"""

import stickslip as ss

model = ss.examples.coulomb()
(orbit,) = (o for o in ss.periodic_orbits(model, period=4) if o.stable)
branch = ss.continue_orbit(orbit, model, "V", (0.036, 0.038))
print(branch)
branch.plot()
