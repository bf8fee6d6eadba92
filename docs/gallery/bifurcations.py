"""
All bifurcations over a range
=============================

Each is marked by its kind where it happens, on the orbits concerned: stable ones heavy.
"""

import stickslip as ss

model = ss.TwoBlock(alpha=0.8, beta=1.15, V=0.1, friction=ss.Coulomb(mu=0.3))
found = ss.bifurcations(model, "V", (0.095, 0.105), max_period=2)
print(found)
found.plot()
