"""
Proven basins
=============

Starts of the paper's system that are proven to tend to the fixed point S1 and to the orbit S4 of
period 4: all but slivers of the domain. Each cell is mapped into cells that are proven before it;
below, how late each one's turn comes.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

model = ss.examples.coulomb()
proof = ss.certify_basins(model, 0.999)
print(proof.statement)

f = ss.event_map(model)
low, high, owner = (
    np.array(column, float) for column in zip(*proof.document["cells"], strict=True)
)
figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(6, 6), height_ratios=(3, 1))
for branch in ss.branches(f):
    d = np.linspace(branch.left, branch.right, 100)
    above.plot(d, f(d), color="0.2", lw=1)
for k, (attractor, name) in enumerate(zip(proof.document["attractors"], ("S1", "S4"), strict=True)):
    mine = owner == k
    label = f"tend to {name}: {float(attractor['share']):.2%}"
    for a, b in zip(low[mine], high[mine], strict=True):
        above.axvspan(a, b, color=f"C{k}", alpha=0.25, lw=0, label=label)
        label = None
    turn = np.arange(len(owner))[mine]
    below.hlines(turn, low[mine], high[mine], color=f"C{k}", lw=2)
above.legend(loc="lower left")
above.set(ylabel="$f(d)$")
below.set(xlabel="$d$", ylabel="turn")
