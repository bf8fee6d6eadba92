"""
A bifurcation diagram
=====================

Stable orbits heavy, unstable ones thin, other attractors as dots, breaks of the map dashed. The
stable orbit of period 4 ends where it meets one of them.
"""

import numpy as np

import stickslip as ss

V = np.linspace(0.0366, 0.0372, 120)
ss.bifurcation_diagram(ss.examples.coulomb(), "V", V).plot()
