"""What doctests may take for granted, and how the libraries below NumPy run in all tests."""

import os
from importlib.util import find_spec

# Before NumPy is loaded. Matrices are small: threads of BLAS only wait, at full load, for each
# other and for the other workers.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pytest

import stickslip

# What needs a package that the environment of the tests leaves out is imported where that is.
collect_ignore = [] if find_spec("jax") else ["src/stickslip/jax.py"]


@pytest.fixture(autouse=True)
def _names_in_doctests(doctest_namespace):
    doctest_namespace["np"] = np
    doctest_namespace["ss"] = stickslip
