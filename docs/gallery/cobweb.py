"""
A cobweb
========

How distances move under the map: up to the map, across to the diagonal, and again.
"""

import stickslip as ss
from stickslip.plot.maps import cobweb

f = ss.event_map(ss.examples.law9(alpha=1.215))
orbits = ss.periodic_orbits(f)
cobweb(f, [0.3795], steps=60, orbits=orbits, window=(0.379, 0.390))
