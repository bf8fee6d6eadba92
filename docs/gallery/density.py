"""
The density of a chaotic attractor
==================================

How often a chaotic motion passes each distance. Its edges are images of the map's turning point.
"""

import stickslip as ss

f = ss.event_map(ss.examples.law9(alpha=1.215))
(chaos,) = (a for a in ss.attractors(f) if a.kind == "chaotic")
density = ss.invariant_density(f, chaos)
print(density)
density.plot()
