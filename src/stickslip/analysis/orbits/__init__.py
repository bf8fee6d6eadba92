"""Periodic orbits: complete lists on the line, searches in R^n, Newton's method."""
