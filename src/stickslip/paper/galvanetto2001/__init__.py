"""Galvanetto (2001), Some discontinuous bifurcations in a two-block stick-slip system.

One module per figure, ``figNN.py``, found by its name.

A figure module offers ``TITLE``, ``COLUMNS``, ``HEIGHT`` (inches), ``compute()``
(all numbers, as a frozen dataclass), ``draw(data, figure)`` and ``caption(data)``,
which states every parameter that the paper does not print.
"""
