"""Breakpoints and branches followed along a parameter."""
