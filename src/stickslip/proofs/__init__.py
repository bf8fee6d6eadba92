"""Proofs about event maps in ball arithmetic: what holds to the last digit, and what does not."""

from importlib.util import find_spec

if find_spec("flint") is None:
    raise ModuleNotFoundError(
        'proofs need python-flint: pip install "stickslip[certify]"', name="flint"
    )
