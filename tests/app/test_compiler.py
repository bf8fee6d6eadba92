"""Kernels are compiled outside the server."""

import json
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from tests.app.talk import CHAIN, COULOMB

from stickslip.app import compiler
from stickslip.app.compiler import NUMBERS, Compiler, typical
from stickslip.app.explorer import Warmth
from stickslip.app.exports import KNOWN
from stickslip.app.jobs import CalledOffError, Gate, Job
from stickslip.app.requests import Motion, request_of

LAW9 = {**COULOMB, "friction": {"law": "popp-stelter", "gamma": 3.0}}
MIXED = {**COULOMB, "friction": [COULOMB["friction"], LAW9["friction"]]}
FORMULA = {"law": "mu + (1 - mu) * exp(-s / v)", "mu": 0.3, "v": 0.1}
FORCED = {**CHAIN, "forcing": {"amplitude": 0.3, "frequency": 2.0}}
TABLE = {**CHAIN, "friction": {"law": "tabulated", "speed": [0, 2], "force": [1, 0.3]}}


def asked(view, model=COULOMB, **request):
    return request_of(view, json.dumps({"model": model, **request}).encode(), KNOWN)


def without_friction(model):
    """With `mu` and `gamma` 0: motions that hardly return would be followed for the kernels."""
    laws = model["friction"]
    if isinstance(laws, list):
        none = [without_friction({"friction": law})["friction"] for law in laws]
    else:
        none = laws | {name: 0.0 for name in laws if name in NUMBERS}
    return {**model, "friction": none}


@pytest.mark.parametrize("model", [COULOMB, LAW9, MIXED, CHAIN, FORCED, TABLE])
@pytest.mark.parametrize("view", ["event_map", "basins", "motion", "cycle", "portrait"])
def test_numbers_do_not_matter_for_what_is_compiled(view, model):
    first = typical(asked(view, model))
    assert typical(asked(view, {**model, "V": 0.2})) == first
    assert typical(asked(view, without_friction(model))) == first
    none = view == "event_map" or (view == "basins" and "forcing" in model)
    assert (first is None) == (model["kind"] == "chain" and none)
    if first is not None:
        assert typical(first) == first


def test_kinds_of_model_do():
    small = [typical(asked("motion", model)).model for model in (COULOMB, LAW9, MIXED, CHAIN)]
    small.append(typical(asked("motion", {**COULOMB, "damping": 0.3})).model)
    assert all(one != other for k, one in enumerate(small) for other in small[:k])
    assert typical(asked("law")) is None


def test_a_process_compiles_once(tmp_path, monkeypatch):
    monkeypatch.setattr(compiler, "cache_root", lambda: tmp_path)  # of the marks alone
    told = []
    Compiler().prepare(
        [asked("motion", d=0.1), asked("law")], lambda done, of: told.append((done, of))
    )
    assert told == [(0, 1), (1, 1)]
    (mark,) = (tmp_path / "explorer").iterdir()
    monkeypatch.setattr(compiler.sys, "executable", "/nonexistent")
    Compiler().prepare([asked("motion", d=0.2)])
    mark.unlink()
    with pytest.raises(FileNotFoundError):
        Compiler().prepare([asked("motion", d=0.2)])


@pytest.mark.parametrize("kept", [True, False])
def test_the_server_compiles_where_no_process_can_do_it_for_it(kept, tmp_path, monkeypatch):
    answered = []
    monkeypatch.setattr(compiler, "cache_root", lambda: tmp_path if kept else None)
    monkeypatch.setattr(Compiler, "_run", lambda self, todo, report: False)
    monkeypatch.setitem(compiler.VIEWS, Motion, lambda small: answered.append(small) or ())
    ours = Compiler()
    for d in (0.1, 0.2):
        ours.prepare([asked("motion", d=d)])
    assert answered == [typical(asked("motion", d=0.1))]
    assert not list(tmp_path.rglob("*"))


def test_what_is_asked_of_a_compiler_that_has_ended_is_called_off(tmp_path, monkeypatch):
    """The thread that compiles in advance ended with a traceback where a server was stopped."""
    monkeypatch.setattr(compiler, "cache_root", lambda: tmp_path)
    ended = Compiler()
    ended.stop()
    with pytest.raises(CalledOffError):
        ended.prepare([asked("motion", d=0.1)])
    warmth = Warmth(Gate(1), ended)
    warmth._warm_up()
    assert not warmth.is_complete


def test_what_waits_for_a_compiler_is_called_off_when_that_ends(tmp_path, monkeypatch):
    """It waited for ever."""
    monkeypatch.setattr(compiler, "cache_root", lambda: tmp_path)
    made, end, begun = Compiler(), threading.Event(), threading.Event()
    made._queue.submit(lambda: (begun.set(), end.wait(20)))
    assert begun.wait(20)
    threading.Timer(0.05, made.stop).start()
    waits = iter(range(10))
    try:
        with pytest.raises(CalledOffError):
            made.prepare([asked("motion", d=0.1)], check=lambda: next(waits))
    finally:
        end.set()


def test_who_is_called_off_waits_no_longer_for_the_compiler(tmp_path, monkeypatch):
    """Several do, while one process compiles; what has not begun is not begun for them."""
    ran, go_on = [], threading.Event()

    def run(self, todo, report):
        ran.append(todo)
        return go_on.wait(60)

    monkeypatch.setattr(compiler, "cache_root", lambda: tmp_path)
    monkeypatch.setattr(Compiler, "_run", run)
    (tmp_path / "explorer").mkdir()
    ours, job = Compiler(), Job(Gate(1), "user", 1.0)
    laws = [{"law": f"1 - {k}*s"} for k in range(1, 4)]
    calls = [asked("motion", {**COULOMB, "friction": law}, d=0.1) for law in laws]
    with ThreadPoolExecutor(3) as pool:
        waits = [pool.submit(ours.prepare, [call], check=job.check_wanted) for call in calls]
        while not ran:
            time.sleep(0.01)
        job.call_off()
        for waiting in waits:
            with pytest.raises(CalledOffError):
                waiting.result(timeout=60)
        go_on.set()
    ours.stop()
    assert len(ran) == 1


def test_requests_alike_but_for_numbers_are_looked_at_once(tmp_path, monkeypatch):
    looked_at = []
    monkeypatch.setattr(compiler, "cache_root", lambda: tmp_path)
    monkeypatch.setattr(Compiler, "_run", lambda self, todo, report: True)
    monkeypatch.setattr(compiler, "typical", lambda it: looked_at.append(it) or typical(it))
    ours = Compiler()
    for V in (0.1, 0.2, 0.3):
        ours.prepare([asked("motion", {**COULOMB, "V": V}, d=0.1)])
    assert len(looked_at) == 1
    for other in ({**COULOMB, "damping": 0.1}, {**COULOMB, "friction": LAW9["friction"]}):
        ours.prepare([asked("motion", other, d=0.1)])
    ours.prepare([asked("cycle", COULOMB, d=0.1)])
    assert len(looked_at) == 4


def test_the_numbers_of_a_formula_ask_for_no_other_kernels(tmp_path, monkeypatch):
    ran = []
    monkeypatch.setattr(compiler, "cache_root", lambda: tmp_path)
    monkeypatch.setattr(compiler, "MOST_FORMULAS", 2)
    monkeypatch.setattr(Compiler, "_run", lambda self, todo, report: ran.append(todo) or True)
    ours = Compiler()

    def prepare(law):
        ours.prepare([asked("motion", {**COULOMB, "friction": law}, d=0.1)])

    for law in (FORMULA, {**FORMULA, "mu": 0.2}, {**FORMULA, "mu": 0.0}, {"law": "1 - s"}):
        prepare(law)
    assert len(ran) == 3  # a number that is 0 may
    with pytest.raises(compiler.BadRequestError, match="has taken 2 formulas") as error:
        prepare({"law": "1 - 2*s"})
    assert error.value.field == "model.law"
    prepare(FORMULA)
    prepare(LAW9["friction"])
    assert len(ran) == 4
