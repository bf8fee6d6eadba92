"""Piecewise-smooth maps: branches, orbits, attractors, basins. Has never heard of a block."""
