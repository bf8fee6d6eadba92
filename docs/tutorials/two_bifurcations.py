"""
The paper's two bifurcations, step by step
==========================================

Galvanetto (2001) follows two blocks on a belt and finds two bifurcations that smooth theory does
not know: an orbit dies because a motion behind it *grazes*, and an attractor becomes chaotic
where a slope is infinite. Here is the first of them, found once by hand and once by one call.
"""

# %%
# The system
# ----------
# Two blocks of equal mass, springs to the wall, a coupling spring `alpha` times as stiff, static
# limits 1 and `beta`, kinetic friction `mu` times the static limit, a belt of speed `V`.

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22))
f = ss.event_map(model)
print(f)

# %%
# The event map
# -------------
# Whenever both blocks ride, their distance ``d`` fixes what follows. The map ``d -> f(d)`` goes
# from one such phase to the next; it has branches, one for each itinerary, and it jumps between
# them.

fig, ax = plt.subplots(figsize=(5, 5), layout="constrained")
ss.branches(f).plot(ax=ax)

# %%
# Why does it jump? Each breakpoint knows: a block that only just touches the belt's velocity on one
# side of it, and sticks or slips on, on the other.

for point in ss.breakpoints(f):
    print(f"{point.d:+.10f}  {point.kind:6}  {point.mechanism}")

# %%
# Fixed points are the simplest motions: S1 is stable, the others are not.

orbits = ss.periodic_orbits(f, max_period=4)
print(orbits)

# %%
# Moving the belt faster
# ----------------------
# As `V` grows, one point of the stable period-4 orbit wanders towards a breakpoint.

edges = np.array([point.d for point in ss.breakpoints(f)])
for V in (0.0366, 0.0368, 0.0369, 0.03697):
    g = ss.event_map(model.replace(V=V))
    breaks = np.array([point.d for point in ss.breakpoints(g)])
    (orbit,) = [o for o in ss.periodic_orbits(g, period=4) if o.stable]
    distance = np.min(np.abs(orbit.points[:, None] - breaks))
    print(
        f"V = {V:.5f}: nearest breakpoint {distance:.2e} away, multiplier {orbit.multiplier:+.4f}"
    )

# %%
# The multiplier stays far from -1 and 1: nothing in the orbit's own stability announces its end.
# One call finds the end, and says why:

(collision,) = ss.bifurcations(model, "V", (0.0366, 0.0372))
print(f"{collision.kind} at V = {collision.value:.12f} (+- {collision.error:.0e})")
print(collision.mechanism)

# %%
# What comes after
# ----------------
# The paper saw a cloud of points and called the new attractor non-periodic. It is periodic, with a
# long period; the first hundreds of iterates do not show it.

for V in (0.0370, 0.0371, 0.0372):
    g = ss.event_map(model.replace(V=V))
    print(V, [(a.kind, a.period) for a in ss.attractors(g, rng=1)])

# %%
# The picture of it all, the paper's figure 4: attractors, unstable orbits, and the point where the
# stable one ends.

diagram = ss.bifurcation_diagram(model, "V", np.linspace(0.0366, 0.0372, 60))
fig, ax = plt.subplots(figsize=(7, 5), layout="constrained")
diagram.plot(ax=ax)

# %%
# The second: an infinite slope
# -----------------------------
# With a friction law that falls with speed the event map is continuous, but its slope can be
# infinite: a *cusp*, where a block lands at the very end of its stick interval. Watch the second
# iterate.

law9 = ss.examples.law9(alpha=1.20915)
g = ss.event_map(law9)
d = np.linspace(0.379, 0.390, 2001)
fig, ax = plt.subplots(figsize=(5, 5), layout="constrained")
ax.plot(d, g(g(d)), lw=1)
ax.plot(d, d, "k:", lw=0.8)
ax.set(xlabel="$d$", ylabel="$f^2(d)$")

# %%
# ``ss.bifurcations(law9, "alpha", (1.208, 1.21865), window=(0.379, 0.390))`` lists the five of the
# paper and the cascades that it passed over; ``stickslip reproduce`` writes them beside the printed
# numbers, with a verdict on each of the paper's claims.

# %%
# How sure is this?
# -----------------
# **Proved.** That S4 reaches the jump at `V*` and crosses it, that the fixed points of the
# Coulomb map are these three, that the motions of period 83, 63 and 55 exist and are stable: by
# interval arithmetic, :doc:`/theorems`.
#
# **Checked.** Orbits, multipliers and jumps (to 1e-14) against references of 30 digits and
# against the paper's printed numbers, in ``tests/studies`` and ``tests/mechanics/eventmap``.
#
# **Fails, or is only evidence.** `attractors` searches from starting points and may miss one; the
# list of orbits is complete only above a resolution. :doc:`/evidence` has the whole account.
