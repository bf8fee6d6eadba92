"""Kernels as WebAssembly: run by Node where it is installed, and everywhere read as a module."""

import json
import shutil
import subprocess

import numpy as np
import pytest
from numba.core import config

from stickslip.numerics.webassembly import FIRST, web_module

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")

RUN = """
const code = new WebAssembly.Module(require("fs").readFileSync(process.argv[2]));
const text = new TextDecoder().decode(WebAssembly.Module.customSections(code, "stickslip")[0]);
const { places, end, filled } = JSON.parse(text);
const memory = new WebAssembly.Memory({ initial: Math.ceil(end / 65536) });
for (const [at, hex] of filled) new Uint8Array(memory.buffer, at).set(Buffer.from(hex, "hex"));
const pointer = new WebAssembly.Global({ value: "i32", mutable: true }, 1 << 19);
const table = new WebAssembly.Table({ initial: 16, element: "anyfunc" });
const env = { __linear_memory: memory, __stack_pointer: pointer, __indirect_function_table: table };
const entries = new WebAssembly.Instance(code, { env }).exports;
entries.move();
entries.total();
const read = (name) => [...new Float64Array(memory.buffer, places[name][0], places[name][2][0])];
console.log(JSON.stringify({ both: read("move.pair.1"), sum: read("total.out") }));
"""


@pytest.fixture(scope="module")
def module():
    from tests.numerics.web_kernels import move, total

    whole = np.arange(6.0)
    entries = {
        "move": (move, {"by": 0.5, "pair": (whole[:3], whole[3:]), "steps": 2}),
        "total": (total, {"of": whole, "out": np.zeros(1)}),
    }
    return web_module(entries)


def test_it_is_a_module_with_its_entries_and_places(module):
    assert module.startswith(b"\0asm\1\0\0\0")
    described = json.loads(module[module.index(b'{"places"') :])
    places = described["places"]
    assert places["move.by"][1:] == ["f8", []]
    assert places["total.of"] == [FIRST + 16, "f8", [6]]
    # Parts of one array stay parts of it.
    assert places["move.pair.0"][0] == places["total.of"][0]
    assert places["move.pair.1"][0] == places["total.of"][0] + 24


@pytest.mark.skipif(shutil.which("node") is None, reason="Node is not installed")
def test_entries_change_the_memory_that_they_share(module, tmp_path):
    (tmp_path / "module.wasm").write_bytes(module)
    (tmp_path / "run.cjs").write_text(RUN)
    command = ["node", str(tmp_path / "run.cjs"), str(tmp_path / "module.wasm")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    first, second = np.arange(3.0), np.arange(3.0, 6.0)
    for _ in range(2):
        first, second = second + 0.5, first
    assert json.loads(done.stdout) == {"both": second.tolist(), "sum": [(first + second).sum()]}
