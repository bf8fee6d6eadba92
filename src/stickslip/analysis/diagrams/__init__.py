"""Bifurcation diagrams: orbits at every value of a parameter."""
