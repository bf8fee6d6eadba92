"""Branches of a map of the line: breakpoints, laps, and the table of monotone pieces."""
