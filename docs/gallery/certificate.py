"""
A proof
=======

All fixed points of the paper's map, proven in ball arithmetic: the list is the list. Each decimal
carries its radius; ``stickslip verify`` checks the saved certificate again. The picture shows the
proven points on the map.
"""

import stickslip as ss
from stickslip.plot.maps import event_map, mark_orbit

f = ss.event_map(ss.examples.coulomb())
proof = ss.certify_orbits(ss.examples.coulomb())
print(proof.statement)
for name, enclosure in proof.enclosures.items():
    print(f"{name:24} {enclosure}")

# %%

ax = event_map(f)
for orbit in range(3):
    d = float(proof.enclosures[f"orbits[{orbit}].points[0]"].split()[0])
    slope = float(proof.enclosures[f"orbits[{orbit}].multiplier"].split()[0])
    mark_orbit(ax, [d], stable=abs(slope) < 1)
