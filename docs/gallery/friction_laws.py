"""
Friction laws
=============

Kinetic friction over the static limit against slip speed: the laws that are built in, one of plain
Python, and one from measured points.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

laws = {
    "Coulomb": ss.Coulomb(mu=0.4),
    "law (9)": ss.PoppStelter(gamma=3.0, delta=0.1, eta=0.02),
    "Stribeck": ss.Stribeck(mu=0.4, speed=0.3),
    "of one's own": ss.friction_law(lambda s, a: 1 / (1 + a * s), parameters={"a": 3.0}),
    "measured": ss.TabulatedFriction(speed=[0, 0.2, 0.6, 1, 2], force=[1, 0.7, 0.5, 0.45, 0.6]),
}
s = np.linspace(0, 2, 400)
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
for name, law in laws.items():
    ax.plot(s, law.force(s), label=name)
ax.set(xlabel="slip speed $s$", ylabel="$F(s)$", ylim=(0, 1.05))
ax.legend()
