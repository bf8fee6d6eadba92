"""
The mechanism
=============

Two blocks on a belt at given displacements, the springs, and the forces with which the belt can
hold each block.
"""

import stickslip as ss
from stickslip.plot.breaks import mechanism

model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22))
mechanism(model, x=(0.6, 0.3))
