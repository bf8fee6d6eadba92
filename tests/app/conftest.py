import pytest
from starlette.testclient import TestClient
from tests.app.talk import opened

from stickslip.app.server import application


@pytest.fixture(scope="module")
def client():
    with TestClient(application(host="testserver", warm=False)) as client:
        yield client


@pytest.fixture
def page(client):
    with opened(client) as page:
        yield page
