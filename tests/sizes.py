"""Samples of two sizes: the small one in every run, the large one in `make evidence`."""

import pytest


def sizes(few, many):
    """Arguments of a test, or tuples of them, for a small and a large sample: that one is slow."""
    large = many if isinstance(many, tuple) else (many,)
    return [few, pytest.param(*large, marks=pytest.mark.slow)]
