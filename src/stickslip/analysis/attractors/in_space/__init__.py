"""Attractors and basins of maps of R^n: recurrences and features of long orbits."""
