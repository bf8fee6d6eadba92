"""Attractors, their basins, exponents and densities."""
