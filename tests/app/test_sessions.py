"""What a page may do to the server, and what it cannot do to others."""

import json
import threading
import time
from contextlib import ExitStack

import numpy as np
import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect
from tests.app.talk import CHAIN, COULOMB, opened, unpack

import stickslip as ss
from stickslip.app import explorer, requests, session
from stickslip.app.compiler import Compiler
from stickslip.app.jobs import CREDIT, CalledOffError, Gate, Job, TimeIsUpError, checkpoint
from stickslip.app.pictures import DRAW
from stickslip.app.requests import Part
from stickslip.app.server import application
from stickslip.app.session import BURST, PAUSE, SHARE, SLOTS, Limits, Workers
from stickslip.app.views import VIEWS
from stickslip.app.views.model import naming
from stickslip.mechanics.model.file import model_values
from stickslip.numerics.waiting import WATCH


@pytest.fixture
def endless(monkeypatch):
    """Let the view "locus" work until it is called off; counts how many have begun."""
    begun = threading.Semaphore(0)

    def work(_):
        yield Part("begun")
        begun.release()
        while True:
            checkpoint()
            time.sleep(0.001)

    monkeypatch.setitem(VIEWS, requests.Locus, work)
    return begun


RANGE = {"parameter": "V", "range": [0.03, 0.04]}
FORCED = {"forcing": {"amplitude": 0.1, "frequency": 1e12}}
LAW = COULOMB["friction"]
FOOT = {
    **{"kind": "structure", "mass": [1.0], "stiffness": [[1.0]]},
    "contact": [{"at": 0, "stiffness": 0.0, "friction": LAW}],
}
BAD = {
    "too many points": ("event_map", {"points": 4001}, "points"),
    "no whole number": ("event_map", {"power": 1.5}, "power"),
    "unknown field": ("event_map", {"code": "1"}, ""),
    "window elsewhere": ("event_map", {"window": [5, 6]}, "window"),
    "window upside down": ("event_map", {"window": [0.2, 0.1]}, "window"),
    "parameter out of range": ("law", {"model": {**COULOMB, "alpha": -1}}, "model.alpha"),
    "law out of range": (
        "law",
        {"model": {**COULOMB, "friction": {"law": "coulomb", "mu": 2}}},
        "model.mu",
    ),
    "law as text": ("law", {"model": {**COULOMB, "friction": "lambda s: s"}}, "model.law"),
    "no such law": ("law", {"model": {**COULOMB, "friction": {"law": "exec"}}}, "model.law"),
    "model without kind": ("law", {"model": {}}, "model"),
    "too many blocks": ("law", {"model": {"kind": "chain", "static": [1] * 21}}, "model.static"),
    "no start": ("motion", {}, "d"),
    "start outside": ("motion", {"d": 3.0}, "d"),
    "two starts": ("motion", {"d": 0.1, "x": [0, 0], "v": [0, 0]}, "d"),
    "endless motion": ("motion", {"d": 0.1, "t_end": 1e9}, "t_end"),
    "no such parameter": ("diagram", {"parameter": "W", "range": [1, 2]}, "parameter"),
    "range upside down": ("diagram", {"parameter": "V", "range": [2, 1]}, "range"),
    "no such view": ("nothing", {}, "view"),
    "stiff model": ("event_map", {"model": {**COULOMB, "alpha": 1e308}}, "model.alpha"),
    "stiff damper": ("diagram", {**RANGE, "model": {**COULOMB, "damping": 50.0}}, "model.damping"),
    "light blocks": ("motion", {"model": {**CHAIN, "mass": 1e-9}}, "model.mass"),
    "hard force": ("motion", {"model": {**CHAIN, **FORCED}}, "model.frequency"),
    "strong block": ("motion", {"model": {**CHAIN, "static": [1, 1, 1e9]}}, "model.static_3"),
    "one of two laws": (
        "law",
        {"model": {**COULOMB, "friction": [LAW, {**LAW, "mu": 2}]}},
        "model.mu_2",
    ),
    "foot without a spring": ("law", {"model": FOOT}, "model.contact_stiffness_1"),
    "range far away": ("diagram", {"parameter": "V", "range": [0.03, 1e300]}, "range[1]"),
    "start far away": ("motion", {"x": [0, 1e300], "v": [0, 0]}, "x[1]"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_request_is_answered_with_the_field_at_fault(page, name):
    view, request, field = BAD[name]
    error = page.error(view, **request)
    assert error["field"] == field
    assert error["message"]
    assert "Traceback" not in error["message"]


@pytest.mark.parametrize(
    ("view", "request_", "told"),
    [
        (
            "motion",
            {"d": 0.1, "t_end": 1e6},
            "t_end = 1000000.0 is not allowed: t_end must be a finite number, 0 < t_end <= 5000. "
            "Give t_end a value in that range.",
        ),
        (
            "motion",
            {"x": [0, 5000], "v": [0, 0]},
            "x_2 = 5000 is not allowed: x_2 must be a finite number, -1000 <= x_2 <= 1000. "
            "Give x_2 a value in that range.",
        ),
        (
            "event_map",
            {"power": 9},
            "power = 9 is not allowed: power must be a whole number from 1 to 8.",
        ),
        ("event_map", {"power": 1.5}, "power must be a whole number, got `float`"),
    ],
)
def test_what_is_wrong_with_a_field_is_told_in_words(page, view, request_, told):
    assert page.error(view, **request_)["message"] == told


FORMULA = {"law": "mu + (1 - mu) * exp(-s / v)", "mu": 0.3, "v": 0.1}


def test_a_formula_is_a_law(page):
    law = page.parts("law", model={**COULOMB, "friction": FORMULA}, range=2.0, points=5)["law"]
    same = ss.friction_law(lambda s: 0.3 + 0.7 * np.exp(-s / 0.1))
    np.testing.assert_array_equal(law.arrays["force"][:, 0], same.force(law.arrays["s"]))


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ({**FORMULA, "law": "mu + exp(-s / v"}, "the formula 'mu + exp(-s / v' ends where ) is"),
        ({**FORMULA, "law": "mu^2"}, "powers are written **"),
        ({"law": "2 - s"}, "F(0) = 2.0 of the friction law '2 - s'"),
        ({"law": "__import__('os')"}, "calls '__import__' at character 1, which is no function"),
        ({"law": "+".join(f"exp(-s*{k}.5)/99" for k in range(20))}, "takes at most 40"),
    ],
)
def test_a_formula_that_is_none_is_told_at_its_field(page, law, message):
    error = page.error("law", model={**COULOMB, "friction": law})
    assert error["field"] == "model.law"
    assert message in error["message"]


def test_a_motion_that_comes_to_no_cycle_is_no_fault_of_a_field(page):
    model = {**CHAIN, "damping": 5.0}
    start = {"x": [0.1] + [0.0] * (len(CHAIN["static"]) - 1), "v": [0.0] * len(CHAIN["static"])}
    parts = page.answer(page.ask("cycle", model=model, **start))
    (why,) = (part.data["why"] for part in parts if "why" in part.data)
    assert why.startswith("no cycle was found")


def test_an_impossible_model_is_told_with_value_and_range(page):
    message = page.error("law", model={**COULOMB, "alpha": 1e100})["message"]
    assert "alpha = 1e+100" in message
    assert "0 <= alpha <= 30" in message


def test_messages_stay_short(page):
    message = page.error("law", **{"x" * 20_000: 1})["message"]
    assert len(message) < 1100


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"id": -1}', '{"ids": 1}', "[" * 60_000])
def test_what_is_no_message_is_answered_and_the_page_goes_on(page, text):
    page.socket.send_text(text)
    received = page.read()
    assert received.header["error"]["message"]
    assert "law" in page.parts("law")


def test_bytes_are_read_as_text(page):
    page.socket.send_bytes(json.dumps({"id": 7, "view": "nothing"}).encode())
    assert page.read().header["error"]["field"] == "view"


def test_numbers_that_are_not_finite_stay_out(page):
    whole = json.dumps({"id": 1, "view": "cobweb", "request": {"model": COULOMB, "d": "D"}})
    for number in ("1e999", "NaN", "-Infinity"):
        page.socket.send_text(whole.replace('"D"', number))
        assert page.read().header["error"]["message"]


def test_the_latest_request_of_a_slot_wins(page, endless):
    first = page.ask("locus")
    assert page.read().name == "begun"
    waiting = page.ask("locus")
    last = page.ask("locus", slot="locus")
    ended = {}
    while len(ended) < 2:
        received = page.read()
        if received.header.get("cancelled"):
            ended[received.header["id"]] = received.header["last"]
    assert ended == {first: True, waiting: True}
    page.socket.send_text('{"cancel": "locus"}')
    assert page.answer(last)[-1].header["cancelled"]


def test_while_something_is_asked_the_server_tells_that_it_is_there(client, endless, monkeypatch):
    """A page cannot tell otherwise a long answer from a line that is dead."""
    monkeypatch.setattr(session, "BEAT", 0.01)
    with opened(client) as page:
        page.ask("locus")
        assert page.read().name == "begun"
        assert unpack(page.socket.receive_bytes()).header["view"] == "beat"
        page.socket.send_text('{"cancel": "locus"}')
        assert page.read().header["cancelled"]
        time.sleep(0.05)  # a word of what is not asked any more is on its way at most
        page.socket.send_text("")
        beats = iter(lambda: "error" in unpack(page.socket.receive_bytes()).header, True)
        assert len(list(beats)) <= 1


def test_another_slot_goes_on(page, endless):
    page.ask("locus", slot="one")
    assert page.read().name == "begun"
    assert "law" in page.parts("law", slot="two")
    page.socket.send_text('{"cancel": "one"}')
    assert page.read().header["slot"] == "one"


def test_slots_are_bounded(page):
    for k in range(SLOTS):
        page.parts("law", slot=f"slot {k}", points=2)
    assert page.error("law", slot="one more")["field"] == "slot"


def test_a_busy_page_does_not_starve_another(client, endless):
    with opened(client) as greedy, opened(client) as modest:
        for k in range(SLOTS):
            greedy.ask("locus", slot=f"slot {k}")
        assert greedy.read().name == "begun"
        modest.parts("cobweb", d=0.1, n=10)  # compiled, if it has to be
        for _ in range(5):  # without an end, if they had to wait
            assert "orbit" in modest.parts("cobweb", d=0.1, n=10)


def test_work_ends_when_its_page_is_closed(client, endless):
    with opened(client) as page:
        page.ask("locus")
        assert endless.acquire(timeout=10)
    with opened(client) as page:
        assert "law" in page.parts("law")
    end = time.monotonic() + 10
    while client.get("/healthz").json()["pages"]:
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_request_has_a_time_limit(endless):
    limits = Limits(seconds=0.05)
    with (
        TestClient(application(host="testserver", warm=False, limits=limits)) as client,
        opened(client) as page,
    ):
        assert "took too long" in page.error("locus")["message"]


def test_the_compiler_is_waited_for_before_an_answer_is_timed(monkeypatch):
    compiled, view = threading.Event(), VIEWS[requests.Locus]

    def needs_the_compiler(request):
        assert compiled.wait(10)
        checkpoint()
        yield from view(request)

    def compiling(_):
        assert compiled.wait(10)
        return iter(())

    monkeypatch.setitem(VIEWS, requests.Locus, needs_the_compiler)
    monkeypatch.setattr(explorer, "_asked_first", compiling)
    with (
        TestClient(application(host="testserver", limits=Limits(seconds=0.2))) as client,
        opened(client) as page,
    ):
        number = page.ask("locus")
        time.sleep(0.5)
        compiled.set()
        assert "error" not in page.answer(number)[-1].header


def test_kernels_of_the_model_that_the_page_begins_with_come_first():
    values = model_values(ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.3)))
    first, second, *_ = explorer._asked_first(values)
    assert [request.model for request in first] == [values]
    assert second[0].model["kind"] == "two_block"
    assert next(explorer._asked_first(None))[0].model == second[0].model


def test_a_crash_is_logged_and_others_go_on(client, page, monkeypatch, caplog):
    def crash(_):
        raise RuntimeError("a secret")
        yield

    monkeypatch.setitem(VIEWS, requests.Locus, crash)
    error = page.error("locus")
    assert "secret" not in error["message"]
    assert "a secret" in caplog.text
    assert "law" in page.parts("law")


def broken():
    list(zip([1], [1, 2], strict=True))


def numpys():
    np.zeros(3) + np.zeros(4)


def at_the_end_of_nothing():
    [][0]


@pytest.mark.parametrize("fault", [broken, numpys, at_the_end_of_nothing])
def test_what_python_and_numpy_say_is_logged_and_not_shown(
    client, page, monkeypatch, caplog, fault
):
    def view(_):
        with naming("window"):
            fault()
        yield

    monkeypatch.setitem(VIEWS, requests.Locus, view)
    monkeypatch.setitem(DRAW, requests.Locus, lambda _: fault())
    with pytest.raises((ValueError, IndexError)) as inside:
        fault()
    for kind in ("json", "svg"):
        body = {"view": "locus", "request": {"model": COULOMB}, "format": kind}
        reply = client.post("/export", json=body)
        assert reply.status_code == 500
        assert "a fault of the program" in reply.json()["error"]["message"]
    error = page.error("locus")
    assert "a fault of the program" in error["message"]
    assert str(inside.value) not in error["message"]
    assert str(inside.value) in caplog.text


def test_what_the_library_says_of_a_value_is_shown(page, monkeypatch):
    def view(_):
        ss.examples.coulomb(V=-1.0)
        yield

    monkeypatch.setitem(VIEWS, requests.Locus, view)
    assert "V = -1.0" in page.error("locus")["message"]


def test_messages_of_one_client_are_heard_so_often():
    workers = Workers(1, Limits())
    pauses = [workers.pause("greedy") for _ in range(300)]
    assert pauses[:50] == [PAUSE] * 50
    assert pauses[-1] > 200 * SHARE - BURST
    assert workers.pause("modest") == PAUSE


def test_pages_are_bounded():
    limits = Limits(connections=1)
    with (
        TestClient(application(host="testserver", warm=False, limits=limits)) as client,
        opened(client),
        client.websocket_connect("/ws") as second,
        pytest.raises(WebSocketDisconnect) as refused,
    ):
        second.receive_bytes()
    assert refused.value.code == 1013


def test_one_client_does_not_lock_out_another():
    limits = Limits(connections=4)
    app = application(host="testserver", warm=False, limits=limits)
    with TestClient(app, client=("greedy", 1)) as client, ExitStack() as stack:
        pages = [stack.enter_context(opened(client)) for _ in range(4)]
        pages[0].parts("law", points=2)  # so that the second has been idle for longest
        client._transport.client = ("modest", 1)
        modest = stack.enter_context(opened(client))
        with pytest.raises(WebSocketDisconnect) as displaced:
            pages[1].read()
        assert displaced.value.code == 1013
        for page in (modest, pages[0], pages[2], pages[3]):
            assert "law" in page.parts("law", points=2)
        client._transport.client = ("greedy", 1)
        with client.websocket_connect("/ws") as again, pytest.raises(WebSocketDisconnect):
            again.receive_bytes()


def test_other_sites_are_refused(client):
    with pytest.raises(WebSocketDisconnect) as refused:
        client.websocket_connect("/ws", headers={"origin": "http://evil.example"}).__enter__()
    assert refused.value.code == 1008
    assert client.get("/", headers={"host": "evil.example"}).status_code == 403
    post = client.post("/export", headers={"origin": "http://evil.example"}, content="{}")
    assert post.status_code == 403
    with client.websocket_connect("/ws", headers={"origin": "http://testserver"}) as socket:
        assert unpack(socket.receive_bytes()).name == "hello"


def test_every_answer_has_safe_headers(client):
    for path in ("/", "/static/shipped/limits.json", "/nowhere"):
        headers = client.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        policy = headers["content-security-policy"]
        assert "default-src 'self'" in policy
        assert policy.endswith("frame-ancestors 'self'")
        assert "unsafe" not in policy


def test_static_files_stay_in_their_folder(client):
    for path in ("/static/../server.py", "/static/%2e%2e/server.py", "/static//etc/passwd"):
        assert client.get(path).status_code == 404


# --- turns ------------------------------------------------------------------------------------


def spin(job, seconds):
    """Work for so long, in turns."""
    with job.running():
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            checkpoint()


def test_turns_are_shared_by_user_and_not_by_job():
    gate, done = Gate(1), []

    def work(user):
        left = 0.25
        with Job(gate, user, 10.0).running():
            while left > 0:
                started = time.monotonic()
                time.sleep(0.002)
                left -= time.monotonic() - started
                checkpoint()
        done.append(user)

    threads = [threading.Thread(target=work, args=(user,)) for user in ["greedy"] * 6 + ["modest"]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert done.index("modest") <= 3  # in fair turns second or so; job by job the last


def test_turns_are_shared_by_client_and_not_by_page():
    gate, done = Gate(1), []

    def work(client, page):
        left = 0.25
        with Job(gate, page, 10.0, client=client).running():
            while left > 0:
                started = time.monotonic()
                time.sleep(0.002)
                left -= time.monotonic() - started
                checkpoint()
        done.append(client)

    pages = [("greedy", page) for page in range(6)] + [("modest", 0)]
    threads = [threading.Thread(target=work, args=page) for page in pages]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert done.index("modest") <= 3


def test_work_without_checkpoints_does_not_keep_others_out():
    gate, ends, order = Gate(1), threading.Event(), []

    def stubborn():
        with Job(gate, "page", 10.0, client="greedy").running():
            order.append("stubborn begins")
            assert ends.wait(20)
            order.append("stubborn ends")

    def work(client):
        with Job(gate, "another page", 10.0, client=client).running():
            checkpoint()
            order.append(client)

    first = threading.Thread(target=stubborn)
    first.start()
    while not order:
        time.sleep(0.001)
    others = [threading.Thread(target=work, args=(client,)) for client in ("greedy", "modest")]
    for thread in others:
        thread.start()
    others[1].join(10)
    assert order == ["stubborn begins", "modest"]
    ends.set()
    for thread in (first, *others):
        thread.join(10)
    assert order == ["stubborn begins", "modest", "stubborn ends", "greedy"]
    spin(Job(gate, "c", 10.0), 0.0)  # there is one slot again, and no more
    assert gate._free == 1


@pytest.mark.parametrize("end", [CalledOffError, TimeIsUpError])
def test_a_search_takes_the_end_of_its_job_for_no_fault_to_go_on_after(end, monkeypatch, caplog):
    along = {"parameter": "V", "range": (0.03695, 0.037), "values": 5, "max_period": 1}
    request = requests.Diagram({**COULOMB}, **along)
    job = Job(Gate(1), "a", 60.0)

    def stop():
        raise end

    def answer():
        with job.running():
            for part in VIEWS[requests.Diagram](request):
                if part.name == "branches":  # the search for bifurcations follows
                    monkeypatch.setattr(job, "check", stop)

    with pytest.raises(end):
        answer()
    assert not caplog.records


def test_a_search_for_a_cycle_asks_whether_it_may_go_on(monkeypatch):
    """Of a chain without a cycle it went on for 20 seconds, and no other page got an answer."""
    law = {"law": "popp-stelter", "gamma": 3.0}
    block = {"kind": "oscillator", "V": 0.2, "damping": 0.05, "friction": law}
    job, asked = Job(Gate(1), "a", 60.0), []
    monkeypatch.setattr(job, "check", lambda: asked.append(True))
    with job.running():
        (part,) = VIEWS[requests.Cycle](requests.Cycle(block, x=(0.1,), v=(0.0,)))
    assert part.data["stable"]
    assert len(asked) >= len(part.data["events"])


@pytest.mark.parametrize("model", [COULOMB, {**CHAIN, "damping": 0.1}], ids=["exact", "blocks"])
def test_a_motion_asks_whether_it_may_go_on(model, monkeypatch):
    """One that grows without bound takes ever smaller steps: no other page got an answer."""
    job, asked = Job(Gate(1), "a", 60.0), []
    monkeypatch.setattr(job, "check", lambda: asked.append(True))
    with job.running():
        still = (0.0,) * len(model.get("static", "12"))
        (part,) = VIEWS[requests.Motion](requests.Motion(model, x=still, v=still))
    assert len(asked) >= len(part.data["events"]) > 1


def test_a_job_ends_when_called_off_while_it_waits():
    gate = Gate(1)
    holder, waiting = Job(gate, "a", 10.0), Job(gate, "b", 10.0)
    ended = []

    def wait():
        try:
            spin(waiting, 1.0)
        except CalledOffError:
            ended.append("called off")

    with holder.running():
        thread = threading.Thread(target=wait)
        thread.start()
        while not gate.is_crowded:
            time.sleep(0.001)
        waiting.call_off()
        thread.join(10)
    assert ended == ["called off"]
    spin(Job(gate, "c", 10.0), 0.0)  # the slot is free again


def test_a_job_out_of_time_gives_its_slot_back():
    gate = Gate(1)
    with pytest.raises(TimeIsUpError):
        spin(Job(gate, "a", 0.01), 5.0)
    spin(Job(gate, "a", 10.0), 0.0)


def test_a_launch_begins_with_one_point_however_many_make_a_tile():
    """125 points of a chain, a second each, were one piece: no other page got an answer."""
    job, pieces = Job(Gate(1), "a", 60.0), []
    with job.running():
        job.launch(lambda start, stop: pieces.append(stop - start), 10_000, 4000)
        assert pieces[0] == 1
        assert sum(pieces) == 10_000
    assert len(pieces) < 20  # quick ones soon are large


def test_time_in_which_a_kernel_was_compiled_is_none_of_a_job(monkeypatch):
    job = Job(Gate(1), "a", 0.05)
    with job.running():
        time.sleep(0.1)
        monkeypatch.setattr(WATCH, "compiled", WATCH.compiled + 1)
        job.check()
        time.sleep(0.1)
        with pytest.raises(TimeIsUpError):
            job.check()


def test_who_waits_for_the_compiler_is_told(client, page, monkeypatch):
    def prepare(_, asked, report=None, check=lambda: None):
        for _ in range(12):
            time.sleep(0.1)
            check()

    monkeypatch.setattr(Compiler, "prepare", prepare)
    parts = page.answer(page.ask("locus", model=COULOMB))
    assert [part.data["compiling"] for part in parts if "compiling" in part.data] == [1]


def test_who_waits_for_the_turn_of_slow_answers_is_told(client, page, monkeypatch):
    ready = threading.Event()
    monkeypatch.setattr(Compiler, "prepare", lambda *_, **__: ready.wait(20))
    monkeypatch.setitem(VIEWS, requests.Cycle, lambda _: iter(()))
    start = {"x": [0.1, 0.0], "v": [0.0, 0.0]}
    for slot in ("one", "two", "three"):
        page.ask("cycle", slot=slot, **start)
    told = page.read().header
    ready.set()
    assert told["slot"] == "three"
    assert told["data"]["waiting"]


@pytest.mark.parametrize(
    ("client", "user", "patient"),
    [("greedy", "a", True), ("modest", "b", True), ("modest", "b", False)],
    ids=["its user", "a client served less", "a client served much less"],
)
def test_a_job_waits_while_another_has_a_quick_one(client, user, patient):
    gate, order = Gate(2), []

    def waits():
        with Job(gate, "a", 10.0, client="greedy", patient=patient).running():
            while "quick ends" not in order:
                checkpoint()
                order.append("the other works")

    thread = threading.Thread(target=waits)
    thread.start()
    while not order:
        time.sleep(0.001)
    with Job(gate, user, 10.0, client=client).running():
        time.sleep(0.05)  # for the other to reach a checkpoint
        order.append("quick begins")
        time.sleep(0.05)
        order.append("quick ends")
    thread.join(10)
    begins, ends = order.index("quick begins"), order.index("quick ends")
    assert ends == begins + 1


def test_a_client_is_no_newcomer_again_after_a_moment():
    gate, used = Gate(2), []
    with Job(gate, "a", 10.0, client="other").running():
        for _ in range(2):
            spin(Job(gate, "b", 10.0, client="greedy"), 0.05)
            used.append(gate._parted["greedy",])
    assert used[1] >= used[0] + 0.05


def test_newcomers_are_not_ahead_of_each_other():
    gate = Gate(4)
    with ExitStack() as jobs:
        for client in range(4):
            jobs.enter_context(Job(gate, "a", 10.0, client=client).running())
        used = [gate._used[client,] for client in range(4)]
    assert max(used) - min(used) <= CREDIT
