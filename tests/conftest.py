"""Settings of the whole suite."""

import os
import sys

import pytest
from hypothesis import HealthCheck, settings

# First calls compile, so that no single example may be held to a deadline.
settings.register_profile(
    "local", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
# CI tries the same examples in every run: red means that the change broke something.
settings.register_profile("ci", settings.get_profile("local"), derandomize=True, database=None)
settings.load_profile("ci" if os.environ.get("CI") else "local")


@pytest.fixture(autouse=True)
def _no_figure_stays_open():
    """Results drawn without axes leave a figure of pyplot behind."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
