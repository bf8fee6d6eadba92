"""
The event map and its branches
==============================

One colour a branch, that is a sequence of sticks and slips; circles are stable fixed points,
squares unstable ones.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

f = ss.event_map(ss.examples.coulomb())
fig, ax = plt.subplots(figsize=(6, 5), layout="constrained")
for branch in (table := ss.branches(f)):
    d = np.linspace(branch.left, branch.right, 300)
    ax.plot(d, f(d), label=table.text(branch.label))
ax.plot(f.domain, f.domain, color="0.6", lw=0.6)
ss.periodic_orbits(f).plot(ax)
ax.set(xlabel="$d$", ylabel="$f(d)$")
ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), fontsize=7)
