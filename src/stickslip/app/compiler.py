"""Kernels compiled by a process of its own: the memory that a compiler takes ends with it.

The server loads what lies in the cache then. Compiling is Python: here it would hold up all
threads.
"""

from __future__ import annotations

import hashlib
import logging
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import msgspec

from stickslip import examples
from stickslip.app import requests
from stickslip.app.jobs import CalledOffError
from stickslip.app.requests import BadRequestError, model_of
from stickslip.app.views import VIEWS
from stickslip.mechanics.friction import FrictionLaw, TabulatedFriction, UserLaw
from stickslip.mechanics.friction.values import law_values
from stickslip.mechanics.model.arguments import Model
from stickslip.mechanics.model.file import model_values
from stickslip.mechanics.model.structure import Structure
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.kernel_cache import cache_root

LOG: Final = logging.getLogger(__name__)

WINDOW: Final = (0.38, 0.39)  # of law (9), where every motion soon returns
NAMES: Final = {kind: view for view, kind in requests.REQUESTS.items()}
LONGEST: Final = 1200.0  # seconds for one process
GIVES_WAY: Final = 5  # niceness of that process: somebody waits for answers meanwhile
PATIENCE: Final = 0.1  # seconds from one look whether the kernels are wanted to the next
MOST_LOOKS: Final = 1000  # of requests, kept in mind
MOST_FORMULAS: Final = 50  # of one server: each keeps the compiler busy for some time
NUMBERS: Final = {"mu": 0.22, "gamma": 3.0}  # of typical laws; of what may be left out 0.1, or 0


class Compiler:
    """Puts the kernels that requests need into the cache before the requests are answered."""

    def __init__(self) -> None:
        self._done: set[str] = set()
        self._ready: set[str] = set()
        self._formulas: set[str] = set()
        self._queue = ThreadPoolExecutor(1, "compiler")  # one process after the other
        self._process: subprocess.Popen[bytes] | None = None

    def prepare(
        self,
        asked: Iterable[requests.Request],
        report: Callable[[int, int], None] = lambda done, of: None,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        """Compile the kernels that these requests need, unless that was done before."""
        # `report` is told how many of how many of them are ready; what `check` raises ends the
        # wait, not a process that compiles. BadRequestError for one formula too many,
        # CalledOffError where the compiler was stopped.
        looks = {_look(request): request for request in asked}
        if looks.keys() <= self._ready:  # nearly always, and somebody waits for the answer
            return
        keyed = {_key(small): small for request in looks.values() if (small := typical(request))}
        self._count(text for small in keyed.values() for text in _formulas(small))
        if not keyed.keys() <= self._done:
            self._wait_for(keyed, report, check)
        if len(self._ready) > MOST_LOOKS:
            self._ready.clear()
        self._ready |= looks.keys()

    def _wait_for(
        self,
        keyed: dict[str, requests.Request],
        report: Callable[[int, int], None],
        check: Callable[[], None],
    ) -> None:
        root = cache_root()
        marks = None if root is None else root / "explorer"
        try:
            work = self._queue.submit(self._compile, keyed, marks, report)
        except RuntimeError:  # it takes no more
            raise CalledOffError from None
        try:
            # Who waits is not told of what is cancelled.
            while not (wait([work], PATIENCE).done or work.cancelled()):
                check()
        finally:
            work.cancel()  # if it has not begun
        if work.cancelled():
            raise CalledOffError
        work.result()

    def _compile(
        self,
        keyed: dict[str, requests.Request],
        marks: Path | None,
        report: Callable[[int, int], None],
    ) -> None:
        todo = [small for key, small in keyed.items() if not (marks and (marks / key).exists())]
        if marks is None or (todo and not self._run(todo, report)):
            for small in todo:
                _answer(small)
        else:
            marks.mkdir(exist_ok=True)
            for key in keyed:
                (marks / key).touch()
        self._done |= keyed.keys()

    def _count(self, formulas: Iterable[str]) -> None:
        known = self._formulas.union(formulas)
        if known != self._formulas and len(known) > MOST_FORMULAS:
            raise BadRequestError(
                f"this server has taken {MOST_FORMULAS} formulas and takes no other, so that its "
                "compiler stays free. Start it anew.",
                "model.law",
            )
        self._formulas = known

    def _run(self, todo: list[requests.Request], report: Callable[[int, int], None]) -> bool:
        command = [sys.executable, "-m", "stickslip.app.compiler"]
        content = msgspec.json.encode([(NAMES[type(request)], request) for request in todo])
        self._process = subprocess.Popen(command, stdin=-1, stdout=-1)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        timer = threading.Timer(LONGEST, self._process.kill)
        timer.start()
        report(0, len(todo))
        with self._process:
            with suppress(BrokenPipeError), self._process.stdin as pipe:
                pipe.write(content)
            for done, _ in enumerate(self._process.stdout, 1):
                report(done, len(todo))
        timer.cancel()
        code = self._process.returncode
        if code:
            LOG.warning(
                "kernels are compiled in the server: the process for it ended with %d", code
            )
        return code == 0

    def stop(self) -> None:
        """End the process that compiles, if there is one."""
        self._queue.shutdown(wait=False, cancel_futures=True)
        if self._process is not None:
            self._process.terminate()


def _look(request: requests.Request) -> str:
    """Say of a request what its kernels depend on: whether numbers are 0, not their sizes."""
    return repr((type(request).__name__, getattr(request, "power", 1), _shape(request.model)))


def _key(small: requests.Request) -> str:
    """Hash what is compiled; of a law's and a structure's numbers it matters whether they are 0."""
    model = dict(small.model)
    for name in model.keys() if "contact" in model else {"friction"}:
        model[name] = _shape(model[name])
    asked = {**msgspec.structs.asdict(small), "model": model}
    return hashlib.sha256(msgspec.json.encode((NAMES[type(small)], asked))).hexdigest()[:16]


def _shape(value: Any) -> Any:
    """Whether numbers are 0, in tables and lists."""
    match value:
        case float():
            return bool(value)
        case list():
            return [_shape(part) for part in value]
        case dict():
            return {name: _shape(part) for name, part in value.items()}
    return value


def _formulas(small: requests.Request) -> Iterator[str]:
    laws = model_of(small).laws
    return (str(law_values(law)["law"]) for law in laws if isinstance(law, UserLaw))


def typical(request: requests.Request) -> requests.Request | None:
    """Return a small request that needs the same kernels, None if it needs none."""
    model = model_of(request)
    if isinstance(model, Structure):
        match request:
            case requests.Motion() | requests.Cycle():
                rest = (0.0,) * model.plant.n_bodies
                v = rest if model.plant.n_positions else ()
                return requests.Motion(model_values(model), x=rest, v=v, t_end=20.0)
        return None
    values = _typical_model(model)
    rest = (0.0,) * len(values.get("static", (0.0, 0.0)))
    match request:
        case requests.Motion():
            return requests.Motion(values, x=rest, v=rest, t_end=20.0)
        case requests.Cycle():
            return requests.Cycle(values, x=rest, v=rest, max_events=400)
    if isinstance(request, requests.Basins) and model.n_blocks > 2 and model.forcing is None:
        laws, static = values["friction"], [1.0, 1.3, 1.1]
        if isinstance(laws, list):
            static = (static * len(laws))[: max(3, len(laws))]
            laws = (laws * 2)[: len(static)]
        return requests.Basins({**values, "static": static, "friction": laws}, resolution=0.1)
    if model.n_blocks != 2 or model.forcing is not None:
        return None
    match request:
        case requests.EventMap():
            power = min(request.power, 2)
            return requests.EventMap(values, window=WINDOW, points=50, power=power, max_period=2)
        case requests.Cobweb():
            return requests.Cobweb(values, d=0.1, n=5)
        case requests.Basins():
            return requests.Basins(values, resolution=0.1)
        case requests.Diagram():
            ends, window = (0.0369, 0.037), (-0.1, 0.05)
            return requests.Diagram(
                values, parameter="V", range=ends, window=window, values=2, max_period=1
            )
    return None


def _typical_model(model: Model) -> dict[str, Any]:
    """Return a harmless model of the same kind and laws."""
    laws = sorted({msgspec.json.encode(law): law for law in map(_typical_law, model.laws)}.items())
    friction = [law for _, law in laws]
    if isinstance(model, TwoBlock):
        of_two = model_values(examples.coulomb(damping=0.05 if model.damping > 0 else 0.0))
        return of_two | {"friction": friction if len(friction) == 2 else friction[0]}
    blocks = max(2, len(friction))
    static = [1.0, 1.3] * (blocks // 2) + [1.0] * (blocks % 2)  # equal blocks would tie
    values: dict[str, Any] = {"kind": "chain", "static": static, "alpha": 1.2, "V": 0.0366}
    if model.forcing is not None:
        values["forcing"] = {"amplitude": 0.1, "frequency": 1.0}
    return values | {"friction": friction if len(friction) > 1 else friction[0]}


def _typical_law(law: FrictionLaw) -> dict[str, Any]:
    if isinstance(law, TabulatedFriction):
        return {"law": law.name, "speed": [0.0, 1.0, 2.0], "force": [1.0, 0.5, 0.4]}
    if isinstance(law, UserLaw):  # 0.1 for all may be no law
        return law_values(law)
    given = law.parameters.items()
    numbers = {name: NUMBERS.get(name, 0.1 if value else 0.0) for name, value in given}
    return {"law": law.name, **numbers, **law.options}


def _asked(content: bytes) -> Iterator[requests.Request]:
    for view, request in msgspec.json.decode(content, type=list[tuple[str, msgspec.Raw]]):
        yield requests.request_of(view, request)


def _answer(request: requests.Request) -> None:
    """Load the kernels that an answer needs, or compile them."""
    with suppress(ValueError):  # such as a motion without a cycle
        for _ in VIEWS[type(request)](request):
            pass


def main() -> None:
    """Answer requests: their kernels stay in the cache."""
    if hasattr(os, "nice"):
        os.nice(GIVES_WAY)
    for request in _asked(sys.stdin.buffer.read()):
        _answer(request)
        print(flush=True)  # one line for each that is ready


if __name__ == "__main__":
    main()
