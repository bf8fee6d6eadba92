"""Orbits followed along a parameter, to where they end."""
