"""
Basins of attraction
====================

Which attractor each starting distance leads to; the attractors are marked above.
"""

import matplotlib.pyplot as plt

import stickslip as ss

fig, ax = plt.subplots(figsize=(7, 2), layout="constrained")
basins = ss.basins(ss.examples.coulomb())
print(basins)
basins.plot(ax)
