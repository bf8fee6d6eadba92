"""
Where the event map is defined
==============================

From some distances the blocks never ride together again: a cycle without global stick holds them.
"""

import stickslip as ss

region = ss.return_region(ss.examples.law9(), "V", (0.25, 0.3), n_values=12, n_points=61)
print(region)
region.plot()
