"""
Limit cycles
============

All cycles that a search from many states found, in the phase plane of each block: solid where they
attract.
"""

import stickslip as ss

cycles = ss.limit_cycles(ss.examples.law9(), n_starts=12, rng=1)
print(cycles)
cycles.plot()
