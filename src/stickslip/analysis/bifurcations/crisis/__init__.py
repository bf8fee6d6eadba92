"""Crises: attractors that meet unstable orbits."""
