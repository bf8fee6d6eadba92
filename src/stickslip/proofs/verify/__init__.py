"""A second program that checks certificates again: small, and with nothing of the first in it.

It follows positions and velocities, halves time steps, takes derivatives by power series in d and
finds jumps by bisecting the itinerary; the certifier has relative velocities, the longest safe
step, jets and Newton's method. All in flint's ball arithmetic.
"""
