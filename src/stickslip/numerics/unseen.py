"""How much a random search has not seen yet."""

from __future__ import annotations

from collections.abc import Iterable


def unseen_share(hits: Iterable[int]) -> float:
    """Estimate the probability that the next random start finds something new.

    Good–Turing: the share of finds that were made just once (1 where nothing was found).
    I. J. Good, Biometrika 40, 237 (1953).
    """
    counts = [count for count in hits if count > 0]
    return sum(count == 1 for count in counts) / sum(counts) if counts else 1.0
