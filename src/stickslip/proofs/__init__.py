"""Proofs about event maps in ball arithmetic: what holds to the last digit, and what does not."""

from stickslip.extras import require_extra

require_extra("certify", "proofs", "flint")
