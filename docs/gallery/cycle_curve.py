"""
A cycle along a parameter
=========================

The period of a stick-slip cycle as the damping grows, up to where its slip no longer reaches the
belt.
"""

import stickslip as ss

block = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=0.1)
cycle = ss.find_cycle(block, [0.0], [0.0])
curve = ss.follow(cycle, "damping", (0.0, 1.5))
print(curve)
curve.plot()
