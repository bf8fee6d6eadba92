"""Bifurcations of orbits and attractors of maps of R^n along a parameter."""
