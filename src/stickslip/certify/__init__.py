"""Proofs about event maps in ball arithmetic: what holds to the last digit, and what does not."""
