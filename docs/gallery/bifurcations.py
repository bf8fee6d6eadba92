"""
All bifurcations over a range
=============================

Each is marked by its kind where it happens, on the orbits concerned.
"""

import stickslip as ss

found = ss.bifurcations(ss.examples.coulomb(), "V", (0.09, 0.1), max_period=2)
print(found)
found.plot()
