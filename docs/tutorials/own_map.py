"""
A map of your own
=================

Everything that is asked of the event map can be asked of any piecewise-smooth map of an interval:
orbits, breakpoints, basins, bifurcations with border collisions and crises. Given as formulas,
one for each branch, its lists of orbits can also be *proven*
(``pip install "stickslip[certify]"``).
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss
from stickslip.proofs.verify.check import check_text

f = ss.PiecewiseMap(
    ["a - 1.1*x - 0.35*x**2", "0.55*x - 0.62"],  # left of 0.2; at 0.2 and right of it
    (-1.5, 1.5),
    parameters={"a": 0.45},
    breakpoints=[0.2],  # or formulas of the parameters: ["b"]
)
print(ss.periodic_orbits(f, max_period=4))

# %%
# A formula knows numbers, ``x``, parameters, ``+ - * / **``, exp, expm1, log, log1p, sqrt, sin,
# cos, tan, sinh, cosh, tanh, atan and asinh. For ``abs``, ``min`` or ``%`` write a formula on
# either side of a breakpoint; digits stand for ``pi``, and a proof is about these.
#
# The search found one orbit. Is it the only one? This proves it, and says so in a sentence:

proof = ss.certify_orbits(f, max_period=4)
print(proof)

# %%
# ``proof.save("orbits.json")`` writes the certificate, and ``stickslip verify orbits.json`` proves
# every word of its statement once more, by a second program that shares only the ball arithmetic.
# Here the same from Python; a certificate that does not hold would raise ``Refused``.

print("holds:", check_text(proof.text()).statement() == proof.statement)

# %%
# What the proof is about: the numbers as they are written, 0.35 is 35/100; and all orbits whose
# points stay in the closed domain. What no ball can decide, an orbit exactly on a breakpoint or on
# an end of the domain, or one at its fold, stays *undecided*: the statement names the interval, and
# so does ``proof.undecided``, empty where the list is complete. Where orbits fill an interval, or
# hardly move apart in it, as beside a flip, nothing is proven of the list: a smaller ``max_period``
# may go. Where a formula has no value, begin the domain later, or put a breakpoint.
# More digits: ``digits=100``. One orbit alone: ``ss.certify(orbit, f)``. :doc:`/theory/proofs` has
# the argument.
#
# **Which domain?** The map need not send the domain into itself: an orbit that leaves is none of
# the map's, and a start that leaves belongs to no basin. Take an interval that holds all that you
# care about. Where the formulas go on beyond it, let its ends be no periodic points: the list of
# ``r*x*(1 - x)`` leaves the fixed point 0 undecided on (0, 1), and proves it on (-0.1, 1.1).
#
# What happens to the map as ``a`` varies:

listed = ss.bifurcations(f, "a", (0.2, 0.9), max_period=4)
print(listed)  # its last lines say what stays open, and where longer cycles or chaos attract
for found in listed:
    print(repr(found))

# %%
# ``print(repr(found))`` tells everything: what becomes of the orbits and of the attractors (at the
# two values where they were looked at; chaos "of period 2" has two bands), and what the normal
# form predicts. ``found.mechanism`` names an event of the motion behind an event
# map, such as a graze; for a map of your own it is empty, and the breakpoint is all there is to
# name. Here the unstable fixed point reaches the jump at 0.2. For larger ``a`` the jump, filled
# in, spans the diagonal, so that an infinitely unstable fixed point takes its place:

print(ss.periodic_orbits(f, infinitely_unstable=True))

# %%
# A map with a square-root edge, as grazing oscillators have it (Nordmark 1991): smooth on one side
# of zero, steep beyond.

f = ss.PiecewiseMap(
    ["a*x + mu", "mu - b*sqrt(x)"],
    (-1.0, 0.5),
    parameters={"a": 0.4, "b": 1.0, "mu": 0.05},
    breakpoints=[0.0],
)
fig, ax = plt.subplots(figsize=(4.5, 4.5), layout="constrained")
ss.branches(f).plot(ax=ax)

# %%
# As ``mu`` passes zero the stable fixed point hits the edge.

for found in ss.bifurcations(f, "mu", (-0.05, 0.15), max_period=3):
    print(f"mu = {found.value:+.10f}  {found.kind}: {found.outcome.text if found.outcome else ''}")

# %%
# What lives beyond: period adding.

diagram = ss.bifurcation_diagram(f, "mu", np.linspace(-0.02, 0.15, 80), max_period=3)
fig, ax = plt.subplots(figsize=(7, 4), layout="constrained")
diagram.plot(ax=ax)

# %%
# A map that no formula gives is a Python function of arrays, or of single numbers. Derivatives are
# then differences where you give none, and nothing about it can be proven.

table = np.linspace(-1, 1, 9)
g = ss.PiecewiseMap(lambda x, c: c - np.interp(x, table, table**2), (-1, 1), parameters={"c": 0.4})
print(ss.periodic_orbits(g, 2))

# %%
# How sure is this?
# -----------------
# **Proved.** Orbits and lists of orbits of maps by formulas, where a certificate says so: exactly
# these, up to the intervals that it names. What two finite slopes at a corner lead to, in the
# normal form (:doc:`/theory/bifurcations`). For an infinite slope, as here, the rule is quoted
# (Nordmark 1997).
#
# **Checked.** Proven lists of random pieces against closed forms, by both programs, in
# ``tests/proofs``. Orbits of maps with a square root against closed forms, in ``tests/analysis``;
# predictions against what is seen, for random slopes.
#
# **Fails, or is only evidence.** Lists by the search, ``periodic_orbits`` and ``bifurcations``,
# are complete above a width that they tell, and evidence, not proof. A Python function is known by
# samples: a jump below 1e-7 of its range, or a branch narrower than the cells, is not noticed.
# Naming ``breakpoints`` helps. Bifurcations of a map of one's own are not proven. See
# :doc:`/theory/maps`.
