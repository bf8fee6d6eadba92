"""The explorer under load: users who move sliders for a minute, over real WebSockets.

Run it as a program; it starts a server of its own, prints percentiles of the time from a request
to each part of its answer, and how much the server's memory grew:

    python benchmarks/bench_explorer.py --users 20 --seconds 60 --rate 1
    python benchmarks/bench_explorer.py --users 100 --seconds 60 --rate 0.1
    python benchmarks/bench_explorer.py --users 4 --seconds 60 --rate 0.5 --hostile 16

A user moves the slider of V so many times a second and waits for the whole answer each time:
event map with its branches and orbits up to period 2, cobweb and motion. With --users 1 --rate 5
it is what a single user's server needs. With --hostile the minute has turns of ten seconds: in
every other one a client of another address holds so many pages, each of which asks for diagrams,
basins and maps of new models in all its slots, ten times a second.
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import json
import random
import struct
import subprocess
import sys
import time
from collections import defaultdict
from urllib.request import urlopen

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

COULOMB = {
    "kind": "two_block",
    "alpha": 1.2,
    "beta": 1.3,
    "friction": {"law": "coulomb", "mu": 0.22},
}
OTHER = "127.0.0.2"  # address of the hostile client
TURN = 10.0  # seconds with and without it
LAW9 = {
    "kind": "two_block",
    "beta": 1.301,
    "V": 0.295,
    "friction": {"law": "popp-stelter", "gamma": 3.0},
}


def header_of(content: bytes) -> dict:
    (length,) = struct.unpack_from("<I", content)
    return json.loads(content[4 : 4 + length])


def asked(rng: random.Random, law: str) -> list[tuple[str, dict]]:
    """Return what a page asks after a slider has moved."""
    if law == "coulomb":
        model = {**COULOMB, "V": rng.uniform(0.03, 0.045)}
        window = None
    else:
        model = {**LAW9, "alpha": rng.uniform(1.208, 1.218)}
        window = [0.379, 0.39]
    return [
        ("event_map", {"model": model, "window": window, "points": 801, "max_period": 2}),
        ("cobweb", {"model": model, "d": 0.1, "n": 160}),
        ("motion", {"model": model, "d": 0.1, "t_end": 200.0, "samples": 4000}),
    ]


async def user(
    number: int, url: str, args: argparse.Namespace, end: float, times: dict, errors: list
) -> None:
    rng = random.Random(number)
    async with connect(url, max_size=None, compression=None) as socket:
        await socket.recv()
        identity = 0
        while time.monotonic() < end:
            begun = time.monotonic()
            open_ids = {}
            for view, request in asked(rng, args.law):
                identity += 1
                open_ids[identity] = view
                await socket.send(json.dumps({"id": identity, "view": view, "request": request}))
            while open_ids:
                header = header_of(await socket.recv())
                view = open_ids.get(header["id"], header["view"])
                if "error" in header:
                    errors.append(header["error"])
                elif not header["last"]:
                    name = f"{view}: {header['data']['part_name']}"
                    times[name].append(time.monotonic() - begun)
                if header["last"]:
                    open_ids.pop(header["id"], None)
            await asyncio.sleep(max(0.0, 1.0 / args.rate - (time.monotonic() - begun)))


async def hostile(number: int, url: str, end: float) -> None:
    """Ask for what takes long, in all slots, and read whatever comes."""
    rng = random.Random(-number)
    asks = ("diagram", "basins", "event_map")
    async with connect(url, max_size=None, compression=None, local_addr=(OTHER, 0)) as socket:
        reading = asyncio.create_task(read_all(socket))
        for identity in itertools.count():
            if time.monotonic() > end:
                break
            view = asks[identity % len(asks)]
            request = {"model": {**COULOMB, "V": rng.uniform(0.03, 0.045)}}
            if view == "diagram":
                low = rng.uniform(1.1, 1.2)
                request |= {"parameter": "alpha", "range": [low, low + 0.2], "max_period": 4}
            message = {"id": identity, "view": view, "slot": f"{identity % 16}", "request": request}
            await socket.send(json.dumps(message))
            await asyncio.sleep(0.1 / 16)
        reading.cancel()


async def read_all(socket: ClientConnection) -> None:
    async for _ in socket:
        pass


def memory(pid: int) -> float:
    """Resident size of a process in MB."""
    with open(f"/proc/{pid}/statm") as file:
        return int(file.read().split()[1]) * 4096 / 1e6


def processor(pid: int) -> float:
    """Seconds of processor time that a process has used."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def started(process: subprocess.Popen) -> str:
    """Wait until the server is warm; return its address."""
    page = process.stdout.readline().strip()
    while not json.load(urlopen(page + "healthz"))["complete"]:
        time.sleep(0.2)
    return page


async def load(page: str, args: argparse.Namespace) -> tuple[dict, list]:
    times: dict[str, list[float]] = defaultdict(list)
    errors: list = []
    url = page.replace("http", "ws", 1) + "ws"
    end = time.monotonic() + args.seconds
    users = (user(number, url, args, end, times, errors) for number in range(args.users))
    others = (hostile(number, url, end) for number in range(args.hostile))
    await asyncio.gather(*users, *others)
    return times, errors


def beside_a_hostile_client(page: str, args: argparse.Namespace) -> None:
    """Print what the users' waiting becomes while another client asks for all it can."""
    both: list[dict[str, list[float]]] = [defaultdict(list), defaultdict(list)]
    for turn in range(2 * round(args.seconds / 2 / TURN)):
        pages = args.hostile * (turn % 2)
        given = {**vars(args), "seconds": TURN, "hostile": pages}
        times, errors = asyncio.run(load(page, argparse.Namespace(**given)))
        assert not errors, errors[:3]
        for name, values in times.items():
            both[turn % 2][name] += values
    print(f"{'part':24} {'alone':>8} {'beside':>8} {'ratio':>8}   medians, ms")
    for name in both[0]:
        alone, beside = (1e3 * float(np.median(times[name])) for times in both)
        print(f"{name:24} {alone:8.0f} {beside:8.0f} {beside / alone:8.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--users", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=1.0, help="moves of a slider per second")
    parser.add_argument("--hostile", type=int, default=0, help="pages of a client that floods")
    parser.add_argument("--law", choices=["coulomb", "law9"], default="coulomb")
    args = parser.parse_args()
    command = [sys.executable, "-m", "stickslip.cli", "explore", "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            page = started(process)
            first = {**vars(args), "seconds": 3.0, "hostile": 0}
            asyncio.run(load(page, argparse.Namespace(**first)))
            if args.hostile:
                return beside_a_hostile_client(page, args)
            before, used = memory(process.pid), processor(process.pid)
            times, errors = asyncio.run(load(page, args))
            used = processor(process.pid) - used
            print(f"{args.users} users, {args.seconds:g} s, {args.rate:g} moves a second each")
            print(f"errors: {len(errors)} {errors[:3]}")
            print(f"memory: {before:.0f} MB, then {memory(process.pid):.0f} MB")
            moves = len(times["event_map: samples"])
            print(f"answered moves: {moves}, {1e3 * used / moves:.1f} ms of processor time each")
            print(f"{'part':24} {'median':>8} {'95 %':>8} {'99 %':>8}   ms")
            for name, values in times.items():
                shares = 1e3 * np.percentile(values, [50, 95, 99])
                print(f"{name:24} " + " ".join(f"{value:8.0f}" for value in shares))
        finally:
            process.terminate()


if __name__ == "__main__":
    main()
