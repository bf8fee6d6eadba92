"""
A forced block
==============

The largest displacement of a block with dry friction over the frequency of the force on it, for
several shares of friction in the force. Above pi/4 friction bounds resonance (Den Hartog 1931).
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

frequencies = np.delete(np.linspace(0.5, 1.8, 40), slice(14, 16))  # not within 1 % of resonance
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
for share in (0.4, 0.6, 0.9):
    largest = []
    for w in frequencies:
        shaken = ss.Harmonic(amplitude=1 / share, frequency=w)
        block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=1.0), forcing=shaken)
        cycle = ss.stroboscopic_map(block).periodic_point([0.5, 0.0])
        t = np.linspace(0, cycle.period, 400)
        largest.append(share * np.abs(cycle.trajectory.x(t)).max())
    ax.plot(frequencies, largest, ".-", ms=4, label=f"friction / force = {share}")
ax.set(xlabel="frequency", ylabel="displacement / force", ylim=(0, 6))
ax.legend()
