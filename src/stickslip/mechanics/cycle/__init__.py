"""Steady sliding and limit cycles in continuous time, of any model."""
