"""
A belt that hardly moves
========================

As the belt slows down the event map tends to one with branches of slope 1, computed exactly.
"""

import matplotlib.pyplot as plt

import stickslip as ss
from stickslip.plot.maps import event_map

model = ss.examples.coulomb()
fig, axes = plt.subplots(1, 3, figsize=(9, 3.2), layout="constrained")
for V, ax in zip((0.2, 0.05), axes, strict=False):
    event_map(ss.event_map(model.replace(V=V)), ax).set_title(f"$V = {V}$")
event_map(ss.quasistatic_map(model), axes[2]).set_title(r"$V \to 0$")
