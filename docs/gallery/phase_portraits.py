"""
Phase portraits
===============

Velocity over displacement of each block. Heavy on the belt's velocity where the block rides.
"""

import matplotlib.pyplot as plt

import stickslip as ss
from stickslip.plot.motion import phase_portrait

motion = ss.simulate(ss.examples.law9(), d=0.3812, t_end=60)
fig, axes = plt.subplots(1, 2, figsize=(7, 3), layout="constrained")
for block, ax in enumerate(axes, start=1):
    phase_portrait(motion, block, ax)
