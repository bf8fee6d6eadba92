"""The page's side of the WebSocket, for tests: messages sent, answers unpacked."""

import itertools
import json
import struct
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

COULOMB = {
    "kind": "two_block",
    "alpha": 1.2,
    "beta": 1.3,
    "V": 0.0366,
    "friction": {"law": "coulomb", "mu": 0.22},
}
CHAIN = {
    "kind": "chain",
    "static": [1.0, 1.3, 1.1],
    "alpha": 1.2,
    "V": 0.0366,
    "friction": {"law": "coulomb", "mu": 0.22},
}


@dataclass
class Received:
    """One message of the server."""

    header: dict
    arrays: dict

    @property
    def name(self):
        return self.header["data"]["part_name"]

    @property
    def data(self):
        return self.header["data"]


def unpacked(content):
    """Take messages apart: length, header, arrays that start at multiples of eight bytes."""
    at = 0
    while at < len(content):
        (length,) = struct.unpack_from("<I", content, at)
        header = json.loads(content[at + 4 : at + 4 + length])
        at, arrays = -(-(at + 4 + length) // 8) * 8, {}
        for item in header["arrays"]:
            dtype = np.dtype("<" + item["dtype"])
            count = int(np.prod(item["shape"]))
            array = np.frombuffer(content, dtype, count, at)
            arrays[item["name"]] = array.reshape(item["shape"])
            at += -(-array.nbytes // 8) * 8
        yield Received(header, arrays)
    assert at == len(content)


def unpack(content):
    """Take one message apart."""
    (received,) = unpacked(content)
    return received


class Page:
    """A connection that asks and reads."""

    def __init__(self, socket):
        self.socket = socket
        self.ids = itertools.count(1)

    def ask(self, view, *, slot="", **request):
        number = next(self.ids)
        request = {"model": COULOMB, **request}
        self.socket.send_text(
            json.dumps({"id": number, "view": view, "slot": slot, "request": request})
        )
        return number

    def read(self):
        """Read what is no mere sign that the server is at work."""
        received = unpack(self.socket.receive_bytes())
        return self.read() if received.header["view"] == "beat" else received

    def answer(self, number):
        """Read the parts of one answer up to its last message, that one included."""
        parts = []
        while not parts or not parts[-1].header["last"]:
            received = self.read()
            if received.header["id"] == number:
                parts.append(received)
        return parts

    def parts(self, view, **request):
        """Ask, and return the parts by name."""
        received = self.answer(self.ask(view, **request))
        assert "error" not in received[-1].header, received[-1].header["error"]
        return {part.name: part for part in received}

    def error(self, view, **request):
        return self.answer(self.ask(view, **request))[-1].header["error"]


@contextmanager
def opened(client):
    """Open a page and read its greeting."""
    with client.websocket_connect("/ws") as socket:
        page = Page(socket)
        assert page.read().name == "hello"
        yield page
