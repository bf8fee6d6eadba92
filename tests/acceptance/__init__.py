"""The product held against the oracles: fixed samples as tests, large ones as evidence.

    python -m tests.acceptance.evidence coulomb --n 100000

The rule is the design's "Right and wrong"; `tests/reference/settle.py` is that rule.
"""
