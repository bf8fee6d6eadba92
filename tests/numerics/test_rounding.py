"""What a kernel computes does not depend on which others were compiled or loaded before it."""

from __future__ import annotations

import os
import subprocess
import sys

CONTACTS = """
import hashlib
import numpy as np
from stickslip.numerics.polynomial import first_contact
from stickslip.numerics.targets import kernel

@kernel
def contacts(c, found):
    for i in range(c.shape[0]):
        found[i] = first_contact(c[i], 1.0, False, 1e-15)

rng = np.random.default_rng(1)
c = rng.normal(size=(100_000, 19)) * 0.6 ** np.arange(19)
c[:, 0] = np.abs(c[:, 0])
found = np.zeros(len(c))
contacts(c, found)
print(hashlib.sha256(found.tobytes()).hexdigest())
"""


def test_a_process_that_compiles_computes_what_one_with_a_cache_does(tmp_path):
    """The first loads the search by itself, the second only the copy of it in its caller."""
    script = tmp_path / "contacts.py"
    script.write_text(CONTACTS, encoding="utf-8")
    environment = {**os.environ, "STICKSLIP_CACHE_DIR": str(tmp_path / "cache")}
    environment.pop("NUMBA_DISABLE_JIT", None)
    runs = [
        subprocess.run(
            [sys.executable, str(script)],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(2)
    ]
    assert runs[0] == runs[1]
