"""
A sweep that resumes
====================

Maps of a parameter plane take hours; machines do not always last so long. A sweep keeps each
tile in a store as soon as it is computed, and the same call goes on from there.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import stickslip as ss

# %%
# One description: a system, axes, observables, a store.

folder = Path(tempfile.mkdtemp())
plan = {
    "system": ss.examples.coulomb(),
    "axes": {"V": (0.0366, 0.0374, 24), "alpha": (1.198, 1.204, 16)},
    "observables": [ss.observables.LyapunovExponent(transient=300, n=300)],
    "store": folder / "plane.zarr",
    "d": -0.4676,  # on the orbit of period 4
    "chunks": {"V": 4, "alpha": 4},
}

# %%
# Let something break in the middle: here the progress report itself.


def power_cut(progress):
    if progress.done >= 5:
        raise KeyboardInterrupt


try:
    ss.sweep(**plan, progress=power_cut)
except KeyboardInterrupt:
    print("interrupted")
unfinished = ss.open_sweep(folder / "plane.zarr")
print(unfinished.attrs["done"], "of", unfinished.attrs["chunks"], "tiles are there")

# %%
# The same call again. What is there is kept (every tile carries a checksum), the rest is
# computed, and the result is the same, bit for bit, as that of a sweep that was never
# interrupted.

found = ss.sweep(**plan)
print(found)

# %%
# It is an `xarray.Dataset`: select, average, plot as usual. The slanted edge is the border
# collision of the other tutorials: the stable orbit ends there, and long transients and orbits
# follow.

fig, ax = plt.subplots(figsize=(6, 4), layout="constrained")
found.lyapunov_exponent.plot(ax=ax, x="V")

# %%
# From the command line the plan is a TOML file: ``stickslip sweep plan.toml``, ``--status`` to
# look in from elsewhere, ``--resume`` to go on. See :doc:`/sweeps` for clusters, S3 and plans of
# 10^10 points.

# %%
# How sure is this?
# -----------------
# **Proved.** Nothing.
#
# **Checked.** A sweep killed ten times ends with the same chunks as one left alone
# (``tests/sweeps/test_killed.py``); damaged chunks are found and computed again
# (``tests/sweeps/test_store.py``).
#
# **Fails, or is only evidence.** The bits are the same on machines of one kind. An exponent is
# that of one finite orbit.
