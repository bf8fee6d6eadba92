"""A notebook without a window: what its cells show."""

import json
import os
import subprocess
import sys

import pytest

pytest.importorskip("IPython", reason="cells are run by IPython, of the extra dev")

CELLS = (
    "import stickslip as ss; model = ss.examples.coulomb(); ss.periodic_orbits(model, 2)",
    "ss.periodic_orbits(model).plot()",
    "ss.attractors(model)",
    "ss.basins(model)",
    "ss.basins(model).plot()",
    "ss.breakpoints(model).table()",
    "ss.branches(model)",
    "motion = ss.simulate(model, d=0.1, t_end=60); motion",
    "motion.plot()",
    "ss.event_map(model).evaluate([0.1, 0.2])",
)
RUN = """
import json, sys
from IPython.core.interactiveshell import InteractiveShell
shell = InteractiveShell.instance()
shown = []
for cell in json.load(sys.stdin):
    done = shell.run_cell("%%capture captured\\n" + cell)
    done.raise_error()
    shown.append([list(output.data) for output in shell.user_ns["captured"].outputs])
print(json.dumps(shown), file=sys.stderr)
"""


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    home = str(tmp_path_factory.mktemp("ipython"))
    environment = os.environ | {
        "MPLBACKEND": "module://matplotlib_inline.backend_inline",  # as a kernel of Jupyter sets it
        "IPYTHONDIR": home,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }
    done = subprocess.run(
        [sys.executable, "-c", RUN],
        input=json.dumps(CELLS),
        env=environment,
        cwd=home,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr + done.stdout
    return json.loads(done.stderr.strip().splitlines()[-1])


@pytest.mark.parametrize("number", range(len(CELLS)))
def test_every_cell_shows_a_table_or_a_picture(shown, number):
    kinds = {kind for output in shown[number] for kind in output}
    assert ("image/png" if ".plot(" in CELLS[number] else "text/html") in kinds


def test_plots_are_shown_once(shown):
    for cell, outputs in zip(CELLS, shown, strict=True):
        assert sum("image/png" in output for output in outputs) == (".plot(" in cell)
