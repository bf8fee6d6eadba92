"""
Limit cycles
============

All cycles that a search from many states found, both blocks in one phase plane: solid where they
attract.
"""

import stickslip as ss

cycles = ss.limit_cycles(ss.examples.coulomb(), n_starts=6, rng=1)
print(cycles)
cycles.plot()
