"""Settings of the whole suite."""

import os
import sys

import pytest
from hypothesis import HealthCheck, settings

# First calls compile, so that no single example may be held to a deadline.
# Examples are few in every run, as samples are (tests/sizes.py), many in `make evidence`.
settings.register_profile(
    "local",
    deadline=None,
    max_examples=30,
    suppress_health_check=[HealthCheck.too_slow],
    print_blob=True,
)
settings.register_profile("many", settings.get_profile("local"), max_examples=150)
# CI tries the same examples in every run: red means that the change broke something.
settings.register_profile("ci", settings.get_profile("local"), derandomize=True, database=None)
settings.load_profile("ci" if os.environ.get("CI") else "local")


@pytest.fixture(autouse=True)
def _no_figure_stays_open():
    """Results drawn without axes leave a figure of pyplot behind."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
