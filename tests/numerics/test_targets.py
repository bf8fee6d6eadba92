"""Compiling, caching and binding of kernels: never a stale result, never a crash over a folder."""

import os
import shutil
import stat
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import pytest
from llvmlite.binding import get_host_cpu_features

from stickslip.numerics import kernel_cache, linking, targets, threads, translation, waiting

RETURNS_BINDING = """
    from stickslip.numerics.targets import kernel

    @kernel
    def answer(x):
        return scale(x) + 1.0
"""


def run(code: str, **environment: str | None) -> subprocess.CompletedProcess:
    """Run a script in a fresh interpreter, with some environment variables changed."""
    variables = {**os.environ, **environment}
    variables = {name: value for name, value in variables.items() if value is not None}
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env=variables,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def printed(code: str, **environment: str | None) -> str:
    done = run(code, **environment)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


# --- the cache folder --------------------------------------------------------------------------


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Every place that a cache may go to, inside one folder."""
    places = {name: tmp_path / name for name in ("own", "xdg", "home", "temporary")}
    for place in places.values():
        place.mkdir()
    monkeypatch.setenv("STICKSLIP_CACHE_DIR", str(places["own"]))
    monkeypatch.setenv("XDG_CACHE_HOME", str(places["xdg"]))
    monkeypatch.setenv("HOME", str(places["home"]))
    monkeypatch.setattr("tempfile.tempdir", str(places["temporary"]))
    return places


choose_folder = kernel_cache.cache_root.__wrapped__  # the choice itself, without its memory


def test_the_first_named_folder_is_taken(folders, monkeypatch):
    assert choose_folder() == folders["own"] / "numba" / kernel_cache.source_hash()
    monkeypatch.delenv("STICKSLIP_CACHE_DIR")
    assert choose_folder().is_relative_to(folders["xdg"] / "stickslip")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert choose_folder().is_relative_to(folders["home"] / ".cache" / "stickslip")


def test_folders_that_cannot_be_written_are_passed_over(folders, monkeypatch):
    for name in ("own", "xdg", "home"):
        folders[name].rmdir()
        folders[name].write_text("a file where a folder should be")
    root = choose_folder()
    assert root.is_relative_to(folders["temporary"])
    assert stat.S_IMODE(root.parent.stat().st_mode) & (stat.S_IWGRP | stat.S_IWOTH) == 0


def test_a_folder_that_others_can_write_is_passed_over(folders):
    shared = folders["own"] / "numba"
    shared.mkdir()
    shared.chmod(0o777)  # pickled code could be planted there
    assert choose_folder().is_relative_to(folders["xdg"])


@pytest.mark.parametrize("mode", [0o770, 0o707])
@pytest.mark.parametrize("level", ["own", "own/above", "own/above/numba"])
def test_no_level_of_the_path_may_be_written_by_others(folders, monkeypatch, level, mode):
    """Who can write a folder can put another one in the place of what lies in it."""
    base = folders["own"] / "above"
    (base / "numba").mkdir(parents=True)
    monkeypatch.setenv("STICKSLIP_CACHE_DIR", str(base))
    assert choose_folder().is_relative_to(base)
    folders["own"].parent.joinpath(level).chmod(mode)
    assert choose_folder().is_relative_to(folders["xdg"])


def test_a_shared_folder_is_no_danger_if_only_owners_can_exchange_what_is_there(folders):
    folders["own"].chmod(0o1777)  # as /tmp
    assert choose_folder().is_relative_to(folders["own"])
    (folders["own"] / "numba").chmod(0o1777)
    assert choose_folder().is_relative_to(folders["xdg"])


@pytest.mark.parametrize("level", ["own", "own/numba"])
def test_a_folder_of_another_user_is_passed_over(folders, monkeypatch, level):
    """The temporary folder is shared: whoever comes first makes what is there."""
    place = folders["own"].parent / level
    place.mkdir(exist_ok=True)
    owners = {place.stat().st_ino: os.getuid() + 1}
    real = Path.lstat

    def lstat(path):
        found = list(real(path))
        found[stat.ST_UID] = owners.get(found[stat.ST_INO], found[stat.ST_UID])
        return os.stat_result(found)

    monkeypatch.setattr(Path, "lstat", lstat)
    assert choose_folder().is_relative_to(folders["xdg"])


def test_a_link_is_followed_once_and_for_all(folders, monkeypatch, tmp_path):
    place, link = tmp_path / "place", tmp_path / "link"
    place.mkdir()
    link.symlink_to(place)
    monkeypatch.setenv("STICKSLIP_CACHE_DIR", str(link))
    assert choose_folder().is_relative_to(place)


def test_folders_are_made_for_their_owner_alone_whatever_the_umask(folders, monkeypatch):
    monkeypatch.setenv("STICKSLIP_CACHE_DIR", str(folders["own"] / "new" / "one"))
    previous = os.umask(0)
    try:
        root = choose_folder()
    finally:
        os.umask(previous)
    for made in (root, root.parent, root.parents[1], root.parents[2]):
        assert stat.S_IMODE(made.stat().st_mode) == 0o700


def test_without_any_folder_there_is_no_cache(folders, monkeypatch):
    for place in folders.values():
        place.rmdir()
        place.write_text("a file")
    assert choose_folder() is None


def test_caches_of_other_versions_go_when_nobody_used_them_for_long(folders):
    base = folders["own"] / "numba"
    old, recent = base / "old", base / "recent"
    for folder in (old, recent):
        folder.mkdir(parents=True)
    base.chmod(0o700)
    long_ago = time.time() - 2.0 * kernel_cache.OLD_CACHE_SECONDS
    os.utime(old, (long_ago, long_ago))
    root = choose_folder()
    assert root.exists()
    assert recent.exists()
    assert not old.exists()


def test_kernels_work_where_nothing_can_be_written(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    code = """
        import tempfile
        from stickslip.numerics import kernel_cache, targets
        kernel_cache._candidate_roots = lambda: iter(())  # not even a temporary folder
        text = "from stickslip.numerics.targets import kernel\\n@kernel\\ndef f(x):\\n    return 2.0 * x\\n"
        print(kernel_cache.cache_root(), targets.write_module("test", text).f(4.0))
        from stickslip.numerics.roots import safe_step
        print(safe_step(0.5, -0.5, 0.0, 0.0, 0.0, 9.0))
    """  # noqa: E501
    assert printed(code, HOME=str(blocked), TMPDIR=str(tmp_path)) == "None 8.0\n1.0"


def test_a_home_that_does_not_exist_is_no_error(tmp_path):
    code = """
        from stickslip.numerics import kernel_cache
        from stickslip.numerics.roots import safe_step
        print(kernel_cache.cache_root(), safe_step(0.5, -0.5, 0.0, 0.0, 0.0, 9.0))
    """
    nothing = {"STICKSLIP_CACHE_DIR": None, "XDG_CACHE_HOME": None}
    folder, number = printed(code, HOME="/dev/null", TMPDIR=str(tmp_path), **nothing).split()
    assert Path(folder).is_relative_to(tmp_path)
    assert number == "1.0"


# --- never a stale result ----------------------------------------------------------------------


def test_the_hash_of_the_sources_is_remembered_until_a_file_changes(folders, tmp_path, monkeypatch):
    source = tmp_path / "stickslip" / "numerics" / "kernels.py"
    source.parent.mkdir(parents=True)
    monkeypatch.setattr(kernel_cache, "PACKAGE", tmp_path / "stickslip")
    found = kernel_cache.source_hash.__wrapped__
    read = []
    reading = kernel_cache.kernel_sources
    monkeypatch.setattr(
        kernel_cache,
        "kernel_sources",
        lambda package: [read.append(package), *reading(package)][1:],
    )
    source.write_text("\n@kernel\ndef f(x):\n    return 1.0 * x\n")
    first, again = found(), found()
    assert first == again
    assert len(read) == 2  # a change within a moment would not be seen
    monkeypatch.setattr(kernel_cache.time, "time", lambda: time.time_ns() * 1e-9 + 60.0)
    assert [found(), found()] == [first, first]
    assert len(read) == 3
    before = source.stat()
    source.write_text(source.read_text().replace("1.0", "2.0"))
    os.utime(source, ns=(before.st_atime_ns, before.st_mtime_ns))  # of the same length and time
    assert found() != first
    (memory,) = (folders["own"] / "numba").glob("sources-*")
    memory.write_bytes(memory.read_bytes()[:40])
    assert found() != first
    assert len(read) == 5


@pytest.fixture
def small_package(tmp_path):
    """A package of its own with what makes our kernels, a helper, and a caller elsewhere."""
    package = tmp_path / "package" / "stickslip"
    for folder in ("numerics", "mechanics"):
        (package / folder).mkdir(parents=True)
        (package / folder / "__init__.py").touch()
    (package / "__init__.py").touch()
    for module in (kernel_cache, linking, targets, threads, waiting):
        shutil.copy(module.__file__, package / "numerics")
    shutil.copytree(translation.__path__[0], package / "numerics" / "translation")
    shutil.copy(kernel_cache.PACKAGE / "files.py", package / "files.py")
    (package / "mechanics" / "caller.py").write_text(
        textwrap.dedent("""
            from stickslip.numerics.helper import helper
            from stickslip.numerics.targets import kernel

            @kernel
            def caller(x):
                return helper(x) + 1.0
        """)
    )
    write_helper(package, "10.0 * x")
    return package


def write_helper(package: Path, expression: str) -> None:
    (package / "numerics" / "helper.py").write_text(
        "from stickslip.numerics.targets import kernel\n\n"
        f"@kernel\ndef helper(x):\n    return {expression}\n"
    )


def call(package: Path, cache: Path, **environment: str) -> list[str]:
    """Result of the caller, and whether it came from the cache on disk."""
    code = """
        from stickslip.mechanics.caller import caller
        print(caller(2.0), sum(getattr(caller, "stats").cache_hits.values()))
    """
    paths = {"PYTHONPATH": str(package.parent), "STICKSLIP_CACHE_DIR": str(cache)}
    # Python's own bytecode does not see an edit of the same length within a second.
    fixed = {"NUMBA_DISABLE_JIT": "0", "PYTHONDONTWRITEBYTECODE": "1"}
    return printed(code, **fixed, **paths, **environment).split()


def test_an_edit_of_a_helper_in_another_module_reaches_its_caller(small_package, tmp_path):
    cache = tmp_path / "cache"
    assert call(small_package, cache) == ["21.0", "0"]
    assert call(small_package, cache) == ["21.0", "1"]  # the cache is really used
    write_helper(small_package, "20.0 * x")
    assert call(small_package, cache) == ["41.0", "0"]
    write_helper(small_package, "10.0 * x")
    assert call(small_package, cache) == ["21.0", "1"]  # its old folder is still right


# --- prepared with the package ------------------------------------------------------------------


def level_of_this_processor() -> str:
    present = {name for name, has in get_host_cpu_features().items() if has}
    levels = [level for level, needs in kernel_cache.LEVELS.items() if needs <= present]
    if not levels:
        pytest.skip("no kernels are prepared for this processor")
    return levels[-1]


def prepare(package: Path, cache: Path) -> None:
    """Put into the package what hatch_build.py puts there: a cache filled at a level."""
    level = level_of_this_processor()
    call(package, cache, NUMBA_CPU_NAME=level, NUMBA_CPU_FEATURES="")
    shutil.copytree(cache / "numba", package / "prepared")


def test_prepared_kernels_serve_where_nothing_was_compiled(small_package, tmp_path):
    prepare(small_package, tmp_path / "made")
    moved = small_package.parent.rename(tmp_path / "elsewhere") / "stickslip"
    for file in moved.rglob("*.py"):
        os.utime(file, (1e9, 1e9))  # as an archive's
    assert call(moved, tmp_path / "new") == ["21.0", "1"]
    assert files_of(tmp_path / "new") == []


def test_another_processor_compiles_for_itself(small_package, tmp_path):
    prepare(small_package, tmp_path / "made")
    generic = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    assert call(small_package, tmp_path / "new", **generic) == ["21.0", "0"]


def test_prepared_kernels_of_other_sources_are_not_taken(small_package, tmp_path):
    prepare(small_package, tmp_path / "made")
    write_helper(small_package, "20.0 * x")
    assert call(small_package, tmp_path / "new") == ["41.0", "0"]


def test_a_damaged_prepared_kernel_is_compiled(small_package, tmp_path):
    prepare(small_package, tmp_path / "made")
    for file in small_package.rglob("caller-*.nbc"):
        flipped(file, file)
    assert call(small_package, tmp_path / "new") == ["21.0", "0"]
    assert call(small_package, tmp_path / "new") == ["21.0", "1"]


# --- files that were damaged -------------------------------------------------------------------

DAMAGED = """
from stickslip.numerics.targets import kernel

@kernel
def tenth(x):
    return 0.1 * x

@kernel
def answer(x):
    return tenth(x) + 0.5 * x
"""


@pytest.fixture
def small_cache(tmp_path, monkeypatch, capsys):
    """Ask a small cache: a function that begins anew, as another process would.

    It returns the answer, how many kernels came from the cache, and the lines on stderr.
    """
    monkeypatch.setattr(kernel_cache, "cache_root", lambda: tmp_path)
    monkeypatch.setattr(targets, "ANNOUNCE_AFTER_SECONDS", 1e3)

    def ask():
        kernel_cache._told.clear()
        kernel_cache._codes.clear()
        for name in [name for name in sys.modules if name.startswith("stickslip_generated_heals")]:
            del sys.modules[name]
        module = targets.write_module("heals", DAMAGED)
        answer = module.answer(3.0), module.tenth(3.0), module.tenth(3)
        hits = sum(sum(f.stats.cache_hits.values()) for f in (module.answer, module.tenth))
        return answer, hits, capsys.readouterr().err.splitlines()

    return ask


def truncated(path, other):
    path.write_bytes(path.read_bytes()[:-1])


def halved(path, other):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def flipped(path, other):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def emptied(path, other):
    path.write_bytes(b"")


def deleted(path, other):
    path.unlink()


def exchanged(path, other):
    first, second = path.read_bytes(), other.read_bytes()
    path.write_bytes(second)
    other.write_bytes(first)


DAMAGES = [truncated, halved, flipped, emptied, deleted, exchanged]


def files_of(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("parts", [False, True])
def test_whatever_happens_to_a_file_the_answer_is_right_and_the_cache_heals(
    parts, damage, small_cache, tmp_path
):
    """Parts are read where the machine code of what Python calls is lost."""
    right = (1.8, 3 * 0.1, 3 * 0.1)
    assert small_cache() == (right, 0, [])
    assert small_cache() == (right, 3, [])
    files = files_of(tmp_path)
    assert {path.suffix for path in files} == {".txt", ".code", ".nbc", ".bc"}
    of_parts = [path for path in files if path.suffix == ".bc" or "-part" in path.name]
    of_calls = [path for path in files if path.suffix == ".nbc" and path not in of_parts]
    assert len(of_calls) == 3
    assert len(of_parts) >= 6  # numba's own, too
    damaged = of_parts if parts else [path for path in files if path not in of_parts]
    told = 0
    for path, other in zip(damaged, [*damaged[1:], damaged[0]], strict=True):
        damage(path, other)
        for lost in of_calls if parts else []:
            lost.unlink()
        answer, _, lines = small_cache()
        assert answer == right
        assert len(lines) <= 1
        assert all(path.name in line or other.name in line for line in lines)
        told += len(lines)
        assert small_cache() == (right, 3, [])
    if damage is deleted:
        assert told == 0
    elif parts:  # what is typed again has another name: the code that it had is not asked for
        assert told >= 3
    else:
        assert told == len(damaged)
        assert files_of(tmp_path) == files


def test_a_cache_that_cannot_be_written_any_more_costs_a_line_and_no_answer(
    small_cache, tmp_path, monkeypatch
):
    def full(path, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    for _ in range(2):
        answer, hits, (line,) = small_cache()
        assert answer[0] == 1.8
        assert hits == 0
        assert "No space left" in line
    assert files_of(tmp_path) == []


# --- binding -----------------------------------------------------------------------------------


@pytest.fixture
def template(tmp_path, monkeypatch):
    """A template module that calls a kernel `scale` which it does not import."""
    name = f"template_{tmp_path.name.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text(textwrap.dedent(RETURNS_BINDING))
    monkeypatch.syspath_prepend(tmp_path)
    yield name
    for module in [m for m in sys.modules if m.startswith(name)]:
        del sys.modules[module]


@targets.kernel
def double(x):
    return 2.0 * x


@targets.kernel
def triple(x):
    return 3.0 * x


@pytest.mark.kernel
def test_instances_of_a_template_are_kept_apart_by_their_key(template):
    one = targets.instantiate(template, "double", scale=double)
    two = targets.instantiate(template, "triple", scale=triple)
    assert (one.answer(5.0), two.answer(5.0), one.answer(5.0)) == (11.0, 16.0, 11.0)
    assert targets.instantiate(template, "double", scale=double) is one
    assert one is not two


def test_one_key_stands_for_one_set_of_bindings(template):
    targets.instantiate(template, "one set", scale=double)
    with pytest.raises(ValueError, match="made with other bindings than"):
        targets.instantiate(template, "one set", scale=double, other=triple)


def test_a_template_that_fails_leaves_nothing_behind(tmp_path, monkeypatch):
    (tmp_path / "broken_template.py").write_text("raise RuntimeError('broken')\n")
    monkeypatch.syspath_prepend(tmp_path)
    for _ in range(2):
        with pytest.raises(RuntimeError, match="broken"):
            targets.instantiate("broken_template", "key")
    assert "broken_template[key]" not in sys.modules


SLOW_MODULE = "import time\ntime.sleep(0.2)\nready = True\n"


@pytest.mark.parametrize(
    "make",
    [
        lambda: targets.instantiate("slow_template", "key"),
        lambda: targets.write_module("slow", SLOW_MODULE),
    ],
    ids=["instance", "generated"],
)
def test_threads_never_see_a_module_that_is_half_made(tmp_path, monkeypatch, make):
    (tmp_path / "slow_template.py").write_text(SLOW_MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(kernel_cache, "cache_root", lambda: tmp_path)
    with ThreadPoolExecutor(3) as pool:
        modules = list(pool.map(lambda _: make().ready, range(3)))
    assert modules == [True] * 3


def test_an_unknown_template_is_named():
    with pytest.raises(ModuleNotFoundError, match="no_such_template"):
        targets.instantiate("no_such_template", "key")


@pytest.mark.kernel
def test_generated_text_becomes_a_module_once():
    text = "from stickslip.numerics.targets import kernel\n@kernel\ndef f(x):\n    return x + {}\n"
    one = targets.write_module("test", text.format(1.5))
    assert one.f(1.0) == 2.5
    assert targets.write_module("test", text.format(1.5)) is one
    two = targets.write_module("test", text.format(2.5))
    assert (two.f(1.0), one.f(1.0)) == (3.5, 2.5)
    file = (kernel_cache.cache_root() / "generated" / one.__file__).with_suffix(".txt")
    kept, seal = file.read_text().split("\n# sha256 ")
    assert kept == text.format(1.5)
    assert len(seal) == 65


def test_long_compilation_is_announced_on_stderr_only(tmp_path):
    code = """
        from stickslip.numerics import targets
        targets.ANNOUNCE_AFTER_SECONDS = 0.0
        from stickslip.numerics.roots import safe_step
        safe_step(1.0, -1.0, 0.0, 1.0, 1.0, 1.0)
        print("done")
    """
    cold = {"STICKSLIP_CACHE_DIR": str(tmp_path), "NUMBA_DISABLE_JIT": "0"}
    first, second = run(code, **cold), run(code, **cold)
    assert first.stdout == second.stdout == "done\n"
    assert first.stderr.count("compiling kernels") == 1
    assert second.stderr == ""


def test_a_quiet_program_says_nothing_of_its_kernels(monkeypatch, capsys):
    monkeypatch.setattr(kernel_cache, "_told", set())
    monkeypatch.setattr(waiting.WATCH, "quiet", True)
    kernel_cache.tell("compiling", "compiling kernels, some seconds")
    assert capsys.readouterr().err == ""


def test_a_long_compilation_says_how_many_kernels_are_ready(tmp_path):
    code = """
        import logging
        import time
        from stickslip.numerics import linking, waiting
        from stickslip.numerics.roots import safe_step
        logging.basicConfig(level=logging.INFO)
        waiting.PATIENCE = 0.01
        linked = linking._EntryLibrary.finalize_with
        def slow(*given):
            time.sleep(1.5)
            return linked(*given)
        linking._EntryLibrary.finalize_with = slow
        safe_step(1.0, -1.0, 0.0, 1.0, 1.0, 1.0)
    """
    first, second = (
        run(code, STICKSLIP_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT="0") for _ in range(2)
    )
    told = [line for line in first.stderr.splitlines() if "compiling kernels:" in line]
    assert told[-1].endswith("s, kernels compiled: 1")
    assert second.stderr == ""


def test_where_no_thread_starts_kernels_compile_unannounced(tmp_path):
    code = """
        import threading
        from stickslip.numerics import targets
        from stickslip.numerics.roots import safe_step
        def refuse(_):
            raise RuntimeError("can't start new thread")
        threading.Thread.start = refuse
        targets.ANNOUNCE_AFTER_SECONDS = 0.0
        print(safe_step(1.0, -1.0, 0.0, 1.0, 1.0, 1.0))
    """
    done = run(code, STICKSLIP_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT="0")
    assert (done.returncode, done.stderr) == (0, "")


def test_another_projects_compilation_is_not_announced(tmp_path):
    code = """
        import numba
        from stickslip.numerics import targets
        targets.ANNOUNCE_AFTER_SECONDS = 0.0
        numba.njit(lambda x: x + 1)(2)
    """
    assert run(code, NUMBA_DISABLE_JIT="0").stderr == ""


# --- launching ---------------------------------------------------------------------------------


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("size", [0, 1, 10, 64, 1001])
def test_tiles_cover_every_item_once(size, threads):
    counts, lock, tiles = [0] * size, threading.Lock(), []

    def task(start, stop):
        with lock:
            tiles.append((start, stop))
            for i in range(start, stop):
                counts[i] += 1

    targets.launch(task, size, threads, smallest=32)
    assert counts == [1] * size
    if size <= 32 or threads == 1:
        assert tiles == [(0, size)]
    else:
        lengths = [b - a for a, b in sorted(tiles)]
        assert min(lengths) >= 16  # no tile below half of `smallest`
        assert max(lengths) <= max(48, size / (4 * threads))
        assert lengths[-1] < 64  # whoever is last does not keep the others waiting


@pytest.mark.parametrize("fails_in_the_caller", [True, False])
def test_an_error_in_a_thread_reaches_the_caller(fails_in_the_caller):
    caller, both_began, begun = threading.get_ident(), threading.Barrier(2, timeout=10), []

    def task(start, stop):
        ident = threading.get_ident()
        if ident not in begun:
            both_began.wait()
        begun.append(ident)
        if (ident == caller) == fails_in_the_caller:
            raise ZeroDivisionError("in a tile")

    with pytest.raises(ZeroDivisionError, match="in a tile"):
        targets.launch(task, 100_000, 2, smallest=10)
    assert len(begun) < 10_000  # the others end soon


def test_the_threads_of_one_launch_serve_the_next():
    before = threading.active_count()
    for _ in range(20):
        targets.launch(lambda start, stop: None, 1000, 4, smallest=10)
    assert threading.active_count() <= before + 3


def test_an_error_is_told_when_no_thread_is_at_work_any_more():
    """Whoever catches it may reuse the arrays."""
    both_began, slow_ended = threading.Barrier(2, timeout=10), []
    caller = threading.get_ident()

    def task(start, stop):
        both_began.wait()
        if threading.get_ident() == caller:
            raise ZeroDivisionError
        time.sleep(0.05)
        slow_ended.append(stop)

    with pytest.raises(ZeroDivisionError):
        targets.launch(task, 20, 2, smallest=10)
    assert slow_ended


def test_a_launch_inside_of_launches_ends():
    """All helpers are at work outside; whoever launches does the tiles alone then."""
    counts = [0] * 1000

    def inner(start, stop):
        for i in range(start, stop):
            counts[i] += 1

    def outer(start, stop):
        targets.launch(lambda a, b: inner(start + a, start + b), stop - start, 3, smallest=10)

    targets.launch(outer, 1000, 3, smallest=100)
    assert counts == [1] * 1000


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_fork_has_threads_of_its_own():
    code = """
        import os
        from stickslip.numerics import targets
        seen = []
        def task(start, stop):
            seen.append(stop - start)
        targets.launch(task, 1000, 3, 10)
        seen.clear()
        child = os.fork()
        targets.launch(task, 1000, 3, 10)
        assert sum(seen) == 1000
        if child == 0:
            os._exit(7)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    """
    assert printed(code) == "7"


def test_at_least_one_processor_is_available():
    assert 1 <= targets.available_threads() <= (os.cpu_count() or 1)


def test_the_cache_folder_depends_on_what_kernels_are_made_of(tmp_path):
    """A helper of a helper counts; what kernels never import does not."""
    package = tmp_path / "stickslip"
    package.mkdir()
    texts = {
        "plain": "from stickslip.kernels import step\n",
        "kernels": "from stickslip.helper import (\n    half,\n)\n\n\n@kernel\ndef step(): ...\n",
        "helper": "from stickslip import status\n\ndef half(): ...\n",
        "status": "OK = 0\n",
        "engine": "from stickslip.numerics.targets import instantiate\n",
        "steps": "from stickslip.generator import step\n\nSTEPS = dict(step=written(step))\n",
        "generator": "def step(): ...\n",
    }
    for name, text in texts.items():
        (package / f"{name}.py").write_text(text)
    found = {path.stem for path in kernel_cache.kernel_sources(package)}
    assert found == {"kernels", "helper", "status", "engine", "steps", "generator"}
    inside = {
        p.relative_to(kernel_cache.PACKAGE).as_posix()
        for p in kernel_cache.kernel_sources(kernel_cache.PACKAGE)
    }
    assert {
        "status.py",
        "mechanics/flow/transitions.py",
        "analysis/interpolation/_kernels.py",
    } <= inside
    assert {
        "mechanics/flow/lanes/steps.py",
        "mechanics/friction/series.py",
        "numerics/vector.py",
    } <= inside
    assert not any(name.startswith(("plot", "study", "studies", "cli")) for name in inside)


@pytest.mark.skipif(kernel_cache.fcntl is None, reason="no locks of files")
def test_processes_that_need_the_same_kernel_compile_it_once(tmp_path):
    code = """
        import sys
        from stickslip.numerics.roots import safe_step
        print("ready", flush=True)
        sys.stdin.read()
        safe_step(0.5, -0.5, 0.0, 0.0, 0.0, 9.0)
        print(sum(safe_step.stats.cache_misses.values()))
    """
    command = [sys.executable, "-c", textwrap.dedent(code)]
    there = os.environ | {"STICKSLIP_CACHE_DIR": str(tmp_path)}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": there}
    with ExitStack() as started:
        several = [started.enter_context(subprocess.Popen(command, **pipes)) for _ in range(3)]
        for each in several:
            assert each.stdout.readline() == "ready\n"
        for each in several:
            each.stdin.close()
        assert sum(int(each.stdout.read()) for each in several) == 1
