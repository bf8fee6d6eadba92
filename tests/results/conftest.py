"""Results to try things on."""

import pytest
from tests.results.samples import Samples


@pytest.fixture(scope="session")
def samples():
    return Samples()
