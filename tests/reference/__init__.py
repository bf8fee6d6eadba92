"""Slow, obvious, independent oracles in higher precision.

Written from the equations of Galvanetto (2001) in positions and velocities, with python-flint's
multi-precision numbers. Nothing here imports the package that it judges.
"""
