"""
A motion over time
==================

Displacement, velocity and friction of both blocks. Riding blocks move with the belt, and feel the
force they need.
"""

import matplotlib.pyplot as plt

import stickslip as ss
from stickslip.plot.motion import time_series

motion = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=80)
fig, axes = plt.subplots(3, 1, figsize=(7, 6), sharex=True, layout="constrained")
for name, ax in zip(("x", "v", "friction"), axes, strict=True):
    time_series(motion, name, ax)
