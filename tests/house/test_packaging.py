"""What the repository promises about itself: locks, names, make targets."""

import ast
import importlib.metadata
import json
import re
import subprocess
import tomllib
from pathlib import Path

import pytest
import trove_classifiers
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from tests.acceptance import packaging, release

import stickslip

ROOT = Path(__file__).resolve().parents[2]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
LOCKS = sorted(ROOT.glob("requirements*.lock"))
HOME = "https://example.org/stickslip"


def pinned(lock):
    """Versions by (name, marker) that a lock asks for."""
    line = r"^([\w.-]+)(?:\[.*?\])?==(\S+)(?: ; (.*?))? \\$"
    pins = re.findall(line, lock.read_text(), re.MULTILINE)
    return {(name, marker): version for name, version, marker in pins}


def test_there_is_a_lock_for_each_environment_of_the_makefile():
    assert [lock.name for lock in LOCKS] == [
        "requirements-bench.lock",
        "requirements-dev.lock",
        "requirements-docs.lock",
        "requirements.lock",
    ]


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.name)
def test_a_lock_names_no_place_to_download_from(lock):
    text = lock.read_text()
    assert "://" not in text
    assert "--index" not in text
    assert "--find-links" not in text


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.name)
def test_every_pin_has_hashes(lock):
    entries = re.split(r"\n(?=\S)", lock.read_text().strip())
    assert entries
    for entry in entries:
        assert "--hash=sha256:" in entry, entry.splitlines()[0]


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.name)
def test_locks_agree_with_the_core(lock):
    core, others = pinned(ROOT / "requirements.lock"), pinned(lock)
    assert core
    assert {key: others[key] for key in core.keys() & others} == {
        key: core[key] for key in core.keys() & others
    }
    # What the other programs come with is added to the tests' environment, not one of its own.
    assert lock.name == "requirements-bench.lock" or core.keys() <= others.keys()


def test_a_lock_pins_extras_as_they_are_asked_for():
    # pip before 23.3 takes the newest release of `name[extra]` where the lock pins `name` alone,
    # and refuses it for want of a hash: no environment from the day of that release on.
    pins = re.findall(r"^([\w.-]+)\[(.*?)\]==", (ROOT / "requirements-dev.lock").read_text(), re.M)
    extras = {name: set(extra.split(",")) for name, extra in pins}
    locked = {name for name, _ in pinned(ROOT / "requirements-dev.lock")}
    for name in sorted(locked):
        try:
            wanted = importlib.metadata.requires(name) or []
        except importlib.metadata.PackageNotFoundError:  # another platform's
            continue
        for requirement in map(Requirement, wanted):
            if requirement.extras and (not requirement.marker or requirement.marker.evaluate()):
                assert requirement.extras <= extras.get(canonicalize_name(requirement.name), set())


def test_the_core_lock_covers_the_dependencies_and_what_builds_the_project():
    locked = {name for name, _ in pinned(ROOT / "requirements.lock")}
    wanted = PYPROJECT["project"]["dependencies"] + PYPROJECT["dependency-groups"]["build"]
    names = {re.split(r"[<>=\[]", line)[0].replace("_", "-") for line in wanted}
    assert names <= locked


def test_the_core_leaves_out_what_is_large_and_optional():
    locked = {name for name, _ in pinned(ROOT / "requirements.lock")}
    assert locked.isdisjoint({"xarray", "zarr", "dask", "numba-cuda", "sphinx", "pytest"})


def test_versions_agree():
    version = PYPROJECT["project"]["version"]
    assert stickslip.__version__ == version
    assert re.search(rf"^version: {re.escape(version)}$", (ROOT / "CITATION.cff").read_text(), re.M)
    assert f"\n## {version}" in (ROOT / "CHANGELOG.md").read_text()
    for name in ("codemeta.json", ".zenodo.json"):
        assert json.loads((ROOT / name).read_text())["version"] == version


def test_papers_about_the_program_agree():
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    codemeta = json.loads((ROOT / "codemeta.json").read_text())
    zenodo = json.loads((ROOT / ".zenodo.json").read_text())
    project = PYPROJECT["project"]
    assert cff["title"] == zenodo["title"]
    assert cff["keywords"] == codemeta["keywords"] == zenodo["keywords"] == project["keywords"]
    assert cff["license"] == zenodo["license"] == project["license"]
    assert codemeta["license"].endswith(project["license"])
    assert cff["abstract"] == codemeta["description"] == zenodo["description"]
    bibliography = (ROOT / "docs" / "bibliography.md").read_text()
    for reference in cff["references"]:
        assert reference.get("doi", "") in bibliography


def test_classifiers_exist():
    assert set(PYPROJECT["project"]["classifiers"]) <= trove_classifiers.classifiers


def test_the_notice_of_borrowed_numbers_is_shipped():
    assert "NOTICE" in PYPROJECT["project"]["license-files"]
    notice = (ROOT / "NOTICE").read_text()
    for named in re.findall(r"^(src/\S+)", notice, re.MULTILINE):
        assert "fdlibm" in (ROOT / named).read_text()
    assert "provided that this notice" in notice


def test_the_release_tries_every_python_that_is_promised():
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / "release.yml").read_text())["jobs"]
    named = re.findall(r"Python :: (3\.\d+)", "\n".join(PYPROJECT["project"]["classifiers"]))
    assert jobs["try"]["strategy"]["matrix"]["python"] == named
    assert jobs["ends"]["strategy"]["matrix"]["python"] == named
    assert jobs["publish"]["needs"] == ["try", "ends"]
    assert jobs["publish"]["environment"] == "release"
    commands = [step["run"] for step in jobs["try"]["steps"] if "run" in step]
    ours = [line.removeprefix("stickslip ") for line in commands if line.startswith("stickslip ")]
    assert len(ours) >= 4


def test_a_release_is_refused_until_a_person_has_filled_in_what_only_a_person_can(tmp_path):
    gaps = release.missing()
    assert [gap.partition(":")[0] for gap in gaps] == [
        *["pyproject.toml"] * 4,
        "codemeta.json",
        "CITATION.cff",
        "README.md",
        "authors",
    ]
    urls = "\n".join(f'{name} = "{HOME}"' for name in release.URLS)
    edits = {
        "pyproject.toml": ("[project.scripts]", f"[project.urls]\n{urls}\n[project.scripts]"),
        "codemeta.json": ('"name"', f'"codeRepository": "{HOME}",\n  "name"'),
        "CITATION.cff": ("title:", f'repository-code: "{HOME}"\ntitle:'),
        "README.md": ("](", f"]({HOME}/"),
        ".zenodo.json": ("", ""),
    }
    for name, (old, new) in edits.items():
        text = (ROOT / name).read_text().replace(old, new).replace("stickslip developers", "A. B.")
        (tmp_path / name).write_text(text)
    assert release.missing(tmp_path) == []
    steps = yaml.safe_load((ROOT / ".github" / "workflows" / "release.yml").read_text())["jobs"]
    assert "tests.acceptance.release" in str(steps["build"]["steps"])


@pytest.mark.parametrize(
    "form", sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml")), ids=str
)
def test_an_issue_form_is_complete(form):
    form = yaml.safe_load(form.read_text())
    assert {"name", "description", "labels", "body"} == set(form)
    assert any(field.get("validations", {}).get("required") for field in form["body"])


def test_the_conda_recipe_asks_for_what_the_project_asks_for():
    recipe = (ROOT / "conda" / "meta.yaml").read_text()
    run = re.search(r"^  run:\n((?:    - .*\n)+)", recipe, re.MULTILINE)
    listed = {line.strip("- \n").replace(" ", "") for line in run[1].splitlines()}
    renamed = {"matplotlib>": "matplotlib-base>"}  # without a screen
    wanted = {f"python{PYPROJECT['project']['requires-python']}"}
    for name in PYPROJECT["project"]["dependencies"]:
        wanted.add(next((name.replace(*pair) for pair in renamed.items() if pair[0] in name), name))
    assert listed == wanted
    assert f'version: "{PYPROJECT["project"]["version"]}"' in recipe


@pytest.mark.parametrize(
    "target",
    [
        *("reproduce", "test", "quick", "check", "docs", "benchmark", "packaging", "clean"),
        *("lint", "types"),
    ],
)
def test_make_knows_the_target(target):
    done = subprocess.run(
        ["make", "--dry-run", target], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_what_make_quick_runs_is_there():
    lines = (ROOT / "tests" / "quick.txt").read_text().splitlines()
    named = [ROOT / name for line in lines if not line.startswith("#") for name in line.split()]
    assert named
    assert [path for path in named if not path.exists()] == []


def test_make_says_what_to_do_without_a_new_enough_python(tmp_path):
    old = tmp_path / "python3"
    old.write_text("#!/bin/sh\necho 'Python 3.9.2'\nexit 1\n")
    old.chmod(0o755)
    done = subprocess.run(
        ["make", "env", f"PYTHON={old}", f"VENV={tmp_path / 'venv'}"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode != 0
    assert "needs Python 3.11 or newer" in done.stderr
    assert "Python 3.9.2" in done.stderr


def test_make_says_what_to_do_without_venv(tmp_path):
    bare = tmp_path / "python3"
    bare.write_text('#!/bin/sh\n[ "$1" = -m ] && exit 1\nexit 0\n')
    bare.chmod(0o755)
    done = subprocess.run(
        ["make", "env", f"PYTHON={bare}", f"VENV={tmp_path / 'venv'}"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode != 0
    assert "apt install python3-venv" in done.stderr
    assert not (tmp_path / "venv").exists()


def test_ci_runs_check():
    script = ROOT / ".ci" / "run"
    assert script.stat().st_mode & 0o111
    assert "make check" in script.read_text()


def _tracked():
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    names = [name for name in listed.stdout.split("\0") if name]
    return [ROOT / name for name in names if (ROOT / name).is_file()]


def test_no_tracked_file_names_a_package_registry():
    registry = re.compile(rb"--(?:extra-)?index-url|https?://[^ ]*/(?:simple|packages)/")
    this = Path(__file__)
    for path in _tracked():
        if path != this:
            assert not registry.search(path.read_bytes()), path


def test_public_names_are_listed_once_and_all_load():
    stub = ast.parse((ROOT / "src/stickslip/__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    names = [alias.asname for node in imports for alias in node.names]
    assert None not in names  # `as` re-exports, which type checkers ask for
    assert sorted(names) == sorted(set(names))
    assert set(names) == set(stickslip.__all__)
    for name in names:
        assert getattr(stickslip, name) is not None


def test_public_names_are_documented():
    page = (ROOT / "docs/api.md").read_text()
    listed = re.findall(r"^   (\w+)$", page, re.MULTILINE)
    assert sorted(listed) == sorted(stickslip.__all__)


def test_every_kernel_file_stands_under_the_contract():
    contracts = PYPROJECT["tool"]["importlinter"]["contracts"]
    (sources,) = (c["source_modules"] for c in contracts if c["name"].startswith("kernels"))
    for path in (ROOT / "src").rglob("*_kernels.py"):
        module = ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
        assert path.name == "_kernels.py" or module in sources


def test_every_extra_is_installed_alone_by_make_packaging():
    ours = {"dev", "bench-peers"}  # the environment of the tests; programs to compare with
    assert set(packaging.EXTRAS) - {""} == set(PYPROJECT["project"]["optional-dependencies"]) - ours
    for extra in packaging.EXTRAS:
        if extra != packaging.RESOLVED_ONLY:
            compile(packaging.use_of(extra), extra, "exec")


def test_make_packaging_tries_every_python_that_is_promised(tmp_path):
    for name in ("stickslip.whl", "stickslip.tar.gz"):
        (tmp_path / name).touch()
    classifiers = PYPROJECT["project"]["classifiers"]
    promised = [line.rpartition(" ")[2] for line in classifiers if "Python :: 3." in line]
    assert list(packaging.PYTHONS) == promised
    cases = packaging.cases(tmp_path, list(packaging.PYTHONS), list(packaging.EXTRAS))
    assert len({str(case) for case in cases}) == len(cases)
    assert len(cases) == len(promised) * 2 * len(packaging.EXTRAS) + 1
    assert str(cases[-1]) == f"{promised[0]:5} newest  core     sdist"


def test_the_lock_of_other_programs_agrees_with_the_tests():
    tests, others = pinned(ROOT / "requirements-dev.lock"), pinned(ROOT / "requirements-bench.lock")
    assert all(tests[key] == others[key] for key in tests.keys() & others)
