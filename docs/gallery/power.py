"""
A power of the map
==================

Points of period 4 are fixed points of the fourth power; its graph is traced so that no line crosses
a jump.
"""

import stickslip as ss
from stickslip.plot.maps import event_map, mark_orbit

f = ss.event_map(ss.examples.coulomb())
ax = event_map(f.power(4), power=4)
for orbit in ss.periodic_orbits(f, period=4):
    mark_orbit(ax, orbit.points, power=4, stable=orbit.stable)
