"""The server on a real port: in a thread for notebooks, in a process for the command line."""

import json
import signal
import socket
import subprocess
import sys
from functools import partial
from urllib.parse import unquote
from urllib.request import urlopen

import pytest
from tests.app.talk import COULOMB, unpack
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

import stickslip as ss
from stickslip.app import widget
from stickslip.app.server import listening_socket


@pytest.fixture(scope="module")
def explorer():
    explorer = ss.explore(ss.examples.law9(), height=500)
    yield explorer
    widget._server().stop()
    widget._server.cache_clear()


def address(explorer):
    return explorer.url.partition("#")[0].replace("http", "ws") + "ws"


def test_a_notebook_shows_a_frame_with_the_model(explorer):
    page, _, fragment = explorer.url.partition("#")
    assert page.startswith("http://127.0.0.1:")
    assert json.loads(unquote(fragment.removeprefix("model=")))["alpha"] == 1.208
    frame = explorer._repr_html_()
    assert frame.startswith("<iframe")
    assert 'height="500"' in frame
    assert "<script" not in frame
    headers = urlopen(page).headers
    assert "http://localhost:*" in headers["content-security-policy"]


def test_all_of_a_process_share_one_server(explorer):
    other = ss.explore()
    assert other.url == explorer.url.partition("#")[0]


def test_a_law_that_is_python_is_no_address():
    model = ss.examples.coulomb(friction=ss.friction_law(lambda s: 1 / (1 + s)))
    with pytest.raises(ValueError, match="Python function"):
        ss.explore(model)
    with pytest.raises(ValueError, match="height"):
        ss.explore(height=0)


def test_no_part_of_an_answer_waits_for_word_of_the_one_before():
    with (
        listening_socket("127.0.0.1", 0) as listener,
        socket.create_connection(listener.getsockname()),
        listener.accept()[0] as accepted,
    ):
        assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_messages_are_bounded(explorer):
    with connect(address(explorer)) as page:
        page.send("[" * 70_000)
        with pytest.raises(ConnectionClosed) as closed:
            list(page)  # what was told before: that kernels are ready, perhaps
    assert closed.value.rcvd.code == 1009


def test_views_are_answered_over_the_wire(explorer):
    with connect(address(explorer)) as page:
        unpack(page.recv())
        page.send(json.dumps({"id": 1, "view": "locus", "request": {"model": COULOMB}}))
        received = unpack(page.recv())
        while received.header["view"] in ("hello", "beat"):  # kernels were not ready at first
            received = unpack(page.recv())
        assert received.name == "locus"


def test_the_command_serves_until_it_is_interrupted():
    command = [sys.executable, "-m", "stickslip.cli", "explore", "--no-browser", "--port", "0"]
    with subprocess.Popen(
        [*command, "--preset", "law9"],
        stdout=-1,
        stderr=-1,
        text=True,
        # A shell has its background jobs ignore this signal, and they hand that down.
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    ) as run:
        url = run.stdout.readline().strip()
        assert url.endswith("#preset=law9")
        page, _, _ = url.partition("#")
        assert json.load(urlopen(page + "healthz"))["status"] == "ok"
        run.send_signal(signal.SIGINT)
        _, told = run.communicate(timeout=30)
    assert run.returncode == 130
    assert "Traceback" not in told


def test_the_command_says_what_is_wrong(capsys):
    from stickslip.cli.program import run

    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        cases = {
            ("--port", port): f"port {port}",
            ("--port", "70000"): "0 to 65535",
            ("--preset", "nothing"): "choose one of coulomb",
            ("--host", "256.0.0.1"): "cannot serve at 256.0.0.1",
        }
        for options, message in cases.items():
            assert run(["explore", "--no-browser", *options]) == 2
            assert message in capsys.readouterr().err


def test_the_command_names_the_extra(monkeypatch, capsys):
    from stickslip.cli.program import run

    for name in [name for name in sys.modules if name.startswith("stickslip.app")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    assert run(["explore"]) == 2
    assert "stickslip[app]" in capsys.readouterr().err
