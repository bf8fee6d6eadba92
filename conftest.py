"""What doctests may take for granted."""

from importlib.util import find_spec

import numpy as np
import pytest

import stickslip

# What needs a package that the environment of the tests leaves out is imported where that is.
collect_ignore = [] if find_spec("jax") else ["src/stickslip/jax.py"]


@pytest.fixture(autouse=True)
def _names_in_doctests(doctest_namespace):
    doctest_namespace["np"] = np
    doctest_namespace["ss"] = stickslip
