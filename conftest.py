"""What doctests may take for granted."""

import numpy as np
import pytest

import stickslip


@pytest.fixture(autouse=True)
def _names_in_doctests(doctest_namespace):
    doctest_namespace["np"] = np
    doctest_namespace["ss"] = stickslip
