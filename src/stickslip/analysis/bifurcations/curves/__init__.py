"""Bifurcations and breakpoints followed in the plane of two parameters."""
