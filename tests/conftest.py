"""Settings of the whole suite."""

import gc
import os
import sys
from contextlib import contextmanager

import pytest
from hypothesis import HealthCheck, settings
from tests.house.long import bare, named

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

LONG_TESTS = named()

# The cores are the suite's own workers': tests/numerics/test_processes.py starts processes itself.
os.environ.setdefault("LOKY_MAX_CPU_COUNT", "1")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collect without the collector of cycles: no test is garbage, and it reads them all."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


@pytest.hookimpl(trylast=True)  # what is deselected has gone
def pytest_collection_modifyitems(config, items):
    """Have the second of two workers begin with plants of any kind.

    The first one begins with maps of two blocks: they would compile the same kernels at once.
    """
    plants = config.rootpath / "tests/mechanics"
    own = [item for item in items if plants in item.path.parents]
    others = [item for item in items if plants not in item.path.parents]
    half = len(items) // 2
    items[:] = others[:half] + own + others[half:]


@pytest.hookimpl(tryfirst=True)  # before what is deselected goes
def pytest_itemcollected(item):
    """Mark what takes long."""
    if bare(item.nodeid) in LONG_TESTS:
        item.add_marker("long")


@pytest.fixture(autouse=True)
def _no_figure_stays_open():
    """Results drawn without axes leave a figure of pyplot behind."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture(scope="session")
def two_processes():
    """Tasks go to two processes, whatever this machine has, and from the first task on."""
    from stickslip.numerics.processes import PROCESSES

    @contextmanager
    def started():
        with pytest.MonkeyPatch.context() as patched:
            for name, value in {"count": 2, "start": True, "are_up": True}.items():
                patched.setattr(PROCESSES, name, value, raising=False)
            yield PROCESSES

    yield started
    if PROCESSES.are_up:
        PROCESSES.end()
