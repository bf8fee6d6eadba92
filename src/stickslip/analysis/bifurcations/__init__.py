"""Bifurcations over a range of a parameter: found, located and explained."""
