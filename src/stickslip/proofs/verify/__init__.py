"""A second program that checks certificates again: small, and with nothing of the first in it.

It follows positions and velocities (the certifier: relative velocities and needed forces), finds
first events by halving time steps (the certifier: by the longest safe step), takes derivatives by
power series in d (the certifier: by jets), and finds a jump by bisecting the itinerary (the
certifier: by Newton's method for the condition of the event). All in flint's ball arithmetic.
"""
