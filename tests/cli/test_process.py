"""Ctrl-C at any moment: code 130, one line on stderr, nothing half-written.

`python -m tests.acceptance.interrupts` does it at hundreds of random moments of ten commands.
"""

import os
import signal
import subprocess
import sys
import textwrap

import pytest
from tests.sizes import slow

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX systems")

AS_PROCESS = """
import ctypes, hashlib, os, pathlib, signal, sys, threading, time
from stickslip.cli.process import all_or_none, run_as_process
from stickslip.files import whole_file

def interrupt():
    os.kill(os.getpid(), signal.{name})

def endless():
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # no Python runs meanwhile

def wait():
    while True:
        time.sleep(0.01)

def work():
{body}
    return 0

run_as_process(work)
"""


def ended(script, folder, name="SIGINT"):
    """Run a script whose body sends itself a signal; SIGINT must not be ignored, as in CI."""
    text = AS_PROCESS.format(name=name, body=textwrap.indent(textwrap.dedent(script), "    "))
    return subprocess.run(
        [sys.executable, "-c", text],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


MOMENTS = {
    "plainly": "interrupt()\nwait()",
    "just before the end": "interrupt()",
    "in a callback from C": """
        ctypes.CFUNCTYPE(None)(interrupt)()
        wait()
    """,
    "in a finalizer": """
        class Thing:
            def __del__(self):
                interrupt()
                time.sleep(0)
        Thing()
        wait()
    """,
    "where all errors are passed over": """
        try:
            interrupt()
            wait()
        except:
            pass
        wait()
    """,
    "as it becomes another error": """
        try:
            interrupt()
            wait()
        except BaseException:
            raise ImportError("half of a module") from None
    """,
    "while no Python runs": """
        threading.Timer(0.05, interrupt).start()
        endless()
    """,
    "while a thread is at work": """
        threading.Thread(target=endless).start()
        interrupt()
    """,
    "while it cleans up after one": """
        try:
            interrupt()
            wait()
        finally:
            interrupt()
            endless()
    """,
    "as the interpreter ends": """
        import atexit
        atexit.register(interrupt)
    """,
}


@pytest.mark.parametrize("script", MOMENTS.values(), ids=MOMENTS)
def test_no_moment_swallows_an_interrupt(script, tmp_path):
    done = ended(script, tmp_path)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "stickslip: interrupted\n"


def test_a_termination_is_an_interrupt(tmp_path):
    done = ended(MOMENTS["while no Python runs"], tmp_path, name="SIGTERM")
    assert (done.returncode, done.stderr) == (130, "stickslip: interrupted\n")


@pytest.mark.parametrize("moment", ["plainly", "while no Python runs", "in a finalizer"])
def test_nothing_half_written_is_left(moment, tmp_path):
    body = textwrap.indent(textwrap.dedent(MOMENTS[moment]), "    ")
    script = f"""
with whole_file(pathlib.Path("result.csv")) as path:
    path.write_text("half of a")
    assert list(pathlib.Path().iterdir())
{body}
"""
    assert ended(script, tmp_path).returncode == 130
    assert list(tmp_path.iterdir()) == []


def test_cleaning_up_after_an_interrupt_is_not_interrupted(tmp_path):
    script = """
        from stickslip.cli import process
        process.AGAIN, process.PATIENCE = 0.001, 60.0
        try:
            interrupt()
        finally:
            for _ in range(30):
                time.sleep(0.002)
            pathlib.Path("clean").touch()
    """
    assert ended(script, tmp_path).returncode == 130
    assert (tmp_path / "clean").exists()


def test_files_that_appear_together_are_not_divided(tmp_path):
    script = """
        from stickslip.cli.output import new_files
        paths = [pathlib.Path("a"), pathlib.Path("b")]
        replace = pathlib.Path.replace
        def interrupted(self, target):
            interrupt()
            return replace(self, target)
        pathlib.Path.replace = interrupted
        with new_files(paths, force=False) as places:
            for place in places:
                place.write_text("whole")
        wait()
    """
    done = ended(script, tmp_path)
    assert (done.returncode, done.stderr) == (130, "stickslip: interrupted\n")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]


def test_a_job_in_the_background_ignores_what_its_shell_ignores(tmp_path):
    ignored = "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
    text = AS_PROCESS.format(name="SIGINT", body="    interrupt()").replace(
        "run_as_process(work)", f"{ignored}run_as_process(work)"
    )
    assert subprocess.run([sys.executable, "-c", text], check=False).returncode == 0


# --- a command --------------------------------------------------------------------------------

COUNTED = """
import os, signal, sys
left = {calls}
def count(frame, event, argument):
    global left
    left -= 1
    if left == 0:
        sys.setprofile(None)
        os.kill(os.getpid(), signal.SIGINT)
from stickslip.cli import main
sys.argv = ["stickslip", *"{command}".split()]
from stickslip.cli import process
begin = process._begin
def counted():
    begin()
    sys.setprofile(count)
process._begin = counted
main()
"""


@pytest.mark.parametrize(
    "calls",
    [1, 10_000, 400_000, 1_200_000]
    + [pytest.param(n, marks=pytest.mark.slow) for n in (100_000, 900_000)],
)
def test_a_command_is_interrupted_at_some_call_of_a_function(calls, tmp_path):
    """As it imports, parses, loads kernels, computes: there are some 1,450,000."""
    command = "map --preset coulomb --grid 50 --out map.csv"
    done = subprocess.run(
        [sys.executable, "-c", COUNTED.format(calls=calls, command=command)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert done.returncode == 130
    assert done.stderr.splitlines()[-1] == "stickslip: interrupted"
    assert "Traceback" not in done.stderr
    assert "ignored" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_sweep_says_how_to_go_on(tmp_path):
    pytest.importorskip("zarr")
    (tmp_path / "plan.toml").write_text(
        """
store = "map.zarr"
observables = [{name = "attractor", transient = 40, n = 64}]
[model]
kind = "two_block"
alpha = 1.2
beta = 1.3
V = 0.0366
friction = {law = "coulomb", mu = 0.22}
[axes]
V = {from = 0.03, to = 0.05, n = 6}
[chunks]
V = 1
"""
    )
    script = """
import os, signal, sys
from stickslip.sweeps import store
write, marks = store.Store.write, []
def interrupted(self, *given):
    write(self, *given)
    marks.append(1)
    if len(marks) == 3:
        os.kill(os.getpid(), signal.SIGINT)
store.Store.write = interrupted
sys.argv = ["stickslip", "sweep", "plan.toml"]
from stickslip.cli import main
main()
"""
    ways = {"cwd": tmp_path, "capture_output": True, "text": True, "check": False}
    done = subprocess.run(
        [sys.executable, "-c", script],
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        timeout=300,
        **ways,
    )
    assert done.returncode == 130
    assert "--resume goes on with it" in done.stderr.splitlines()[-1]
    again = [sys.executable, "-m", "stickslip.cli", "sweep", "plan.toml"]
    status = subprocess.run([*again, "--status"], **ways)
    assert status.stdout.startswith("map.zarr: 3 of 6 chunks done; not verified: ")
    assert subprocess.run([*again, "--resume"], **ways).returncode == 0
    assert not list(tmp_path.rglob("*.partial"))


# --- streams that are closed ------------------------------------------------------------------

SHELL = pytest.mark.skipif(not os.path.exists("/bin/sh"), reason="needs a shell")
DOCTOR = f"{sys.executable} -m stickslip.cli"


def in_shell(command):
    return subprocess.run(
        ["/bin/sh", "-c", command], capture_output=True, text=True, timeout=120, check=False
    )


@SHELL
@pytest.mark.parametrize("command", ["map --help", "study", *slow("doctor", "--version")])
@pytest.mark.parametrize("place", [">&-", ">/dev/full"])
def test_a_result_that_cannot_be_written_is_an_error(command, place):
    if "full" in place and not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full")
    done = in_shell(f"{DOCTOR} {command} {place}")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("stickslip")
    silent = in_shell(f"{DOCTOR} {command} {place} 2>&-")
    assert (silent.returncode, silent.stderr) == (2, "")


@SHELL
@pytest.mark.parametrize("place", ["2>&-", "2>/dev/full"])
def test_messages_that_nobody_reads_stop_no_work(place):
    done = in_shell(f"{DOCTOR} --version {place}")
    assert done.returncode == 0
    assert done.stdout
    assert in_shell(f"{DOCTOR} map --alhpa 1 {place}").returncode == 2


@SHELL
def test_letters_that_the_standard_output_has_not_are_escaped(tmp_path):
    command = f"{DOCTOR} map --preset coulomb -d 0.1 --out {tmp_path}/\N{SNOWMAN}.csv"
    done = in_shell(f"PYTHONIOENCODING=ascii {command}")
    assert (done.returncode, done.stdout) == (0, f"{tmp_path}/\\u2603.csv\n")
    assert (tmp_path / "\N{SNOWMAN}.csv").exists()


@SHELL
def test_errors_as_json_on_a_closed_stdout_are_told_on_stderr():
    done = in_shell(f"{DOCTOR} map --alhpa 1 --json >&-")
    assert done.returncode == 2
    assert "--alpha" in done.stderr
    assert "Traceback" not in done.stderr
