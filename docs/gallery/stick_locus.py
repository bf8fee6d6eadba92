"""
The plane of displacements and the stick locus
==============================================

Inside the parallelogram both blocks can ride. A motion enters it, rides along the diagonal, and
leaves where one block reaches its limit; the line AC is the domain of the event map.
"""

import stickslip as ss
from stickslip.plot.locus import trajectory_in_plane

motion = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=150)
trajectory_in_plane(motion)
