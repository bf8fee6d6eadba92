# Needs only `python3` (3.11 or newer, with venv), `make` and, for the first run, a network.
# Every target makes the environment it needs from the lock files; nothing has to be activated.
#
#   make reproduce    the paper's figures and table of values in out/
#   make test         the tests, but for most of those of half a second and more
#   make quick        a choice of it from every package, half a minute: for the inner loop
#   make evidence     the large samples and long proofs, an hour or two
#   make check        lint, types, the page, import contracts, budgets, then `make test`: what CI runs
#   make test-all     the tests that take long, too: three quarters of an hour, before a release
#   make docs         the documentation in docs/_build/html, from local files alone
#   make packaging    wheel and sdist in empty environments, oldest and newest dependencies
#   make benchmark    the timings, competitors included
#   make clean        remove what the targets above made, the environment too

PYTHON ?= python3
VENV ?= .venv
JOBS ?= 2

PY := $(VENV)/bin/python
PIP_INSTALL := $(PY) -m pip install --quiet --disable-pip-version-check
TESTS := $(PY) -m pytest -n $(JOBS) --dist worksteal -q
STAMPS := $(VENV)/.stickslip
COMPILE := $(PY) -m uv pip compile --quiet --universal --python-version 3.11 \
	--generate-hashes --no-strip-extras --no-emit-index-url --no-emit-find-links --no-header

# Whatever the caller's settings: rewriting the assertions of all tests anew takes ten seconds in
# every worker, compiling the package a third of the start of every program that a test runs.
unexport PYTHONDONTWRITEBYTECODE

.DELETE_ON_ERROR:
.PHONY: help reproduce test test-all quick check docs benchmark evidence packaging wheel clean lint format types page contracts budgets \
	test-compiled test-kernels lock env env-dev env-docs

help:
	@sed -n '/^#   make/s/^#   //p' Makefile

# ---------------------------------------------------------------- what users run

reproduce: $(STAMPS)/core
	$(PY) -m stickslip.cli reproduce --out out

# The kernels once as plain Python (real tracebacks, coverage; some seconds), then the tests that take
# less than half a second or guard the front door, compiled. `$(MAKE)` one after the other, also under `make -j`: the summary comes last.
test: $(STAMPS)/dev
	@$(MAKE) --no-print-directory test-kernels
	@$(MAKE) --no-print-directory test-compiled

test-all: $(STAMPS)/dev
	@$(MAKE) --no-print-directory test-kernels
	$(TESTS) -m "not slow"

# Files, not a marker: to collect all tests takes seven seconds and more in every worker.
quick: $(STAMPS)/dev
	$(TESTS) $$(grep -v '^#' tests/quick.txt) -m "not slow and not long"

# Side by side what takes one core each, the longest first.
check: $(STAMPS)/dev
	@$(MAKE) --no-print-directory -j $(JOBS) types test-kernels page budgets lint contracts
	@$(MAKE) --no-print-directory test-compiled

# What takes too long for every change: tests marked slow, the others with many random examples, then
# random systems against the oracles.
# Counts are added to docs/evidence.csv; every run takes other systems.
evidence: $(STAMPS)/dev
	$(TESTS) -m "slow or hypothesis" --hypothesis-profile many
	$(PY) -m tests.acceptance.evidence coulomb --n 20000 --jobs $(JOBS)
	$(PY) -m tests.acceptance.evidence steppers --n 2000 --jobs $(JOBS)
	$(PY) -m tests.acceptance.evidence grazing --kind coulomb --n 200 --breakpoints 2 \
		--share 0.02 --max-events 400 --jobs $(JOBS)
	$(PY) -m tests.acceptance.evidence grazing --kind law9 --n 20 --breakpoints 2 \
		--share 0 --max-events 400 --jobs $(JOBS)
	$(PY) -m tests.acceptance.drivers coulomb --systems 10000 --points 1000 --jobs $(JOBS)
	$(PY) -m tests.acceptance.drivers law9 --systems 100000 --points 100 --jobs $(JOBS)
	$(PY) -m tests.acceptance.structures own shared elastic --n 35000 --jobs $(JOBS)
	$(PY) -m tests.acceptance.structures near maps returns --n 1000 --jobs $(JOBS)
	$(PY) -m tests.acceptance.interrupts --n 500
	$(PY) -m tests.acceptance.mutants
	$(PY) -m tests.acceptance.covered --jobs $(JOBS)

docs: $(STAMPS)/docs
	$(PY) -m sphinx -b html -W --keep-going --quiet -d docs/_build/doctrees docs docs/_build/html
	@echo "docs/_build/html/index.html"

# Half an hour on an idle machine and a network; needs uv (pip install uv) and the Pythons to try.
packaging: $(STAMPS)/core
	$(PY) -m tests.acceptance.packaging

# With kernels compiled for these levels of processors, each of which this machine must have.
LEVELS ?= x86-64-v3,x86-64-v4
wheel: $(STAMPS)/core
	STICKSLIP_PREPARE=$(LEVELS) $(PY) -m pip wheel --no-build-isolation --no-deps --wheel-dir dist .

benchmark: $(STAMPS)/bench
	$(PY) -m pytest benchmarks -p no:xdist -o python_files='bench_*.py' -o python_functions='bench_*' \
		--benchmark-only --benchmark-sort=name
	$(PY) -m benchmarks.pictures
	$(PY) -m benchmarks.guard

clean:
	rm -rf out build dist docs/_build docs/generated docs/api/generated benchmarks/results \
		.pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache $(VENV)
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# ---------------------------------------------------------------- what `check` is made of

test-compiled: $(STAMPS)/dev
	$(TESTS) -m "not slow and not long"

test-kernels: $(STAMPS)/dev
	NUMBA_DISABLE_JIT=1 $(PY) -m pytest $$(grep -rl 'mark\.kernel' tests --include='*.py') -m "kernel and not slow" -q

lint: $(STAMPS)/dev
	$(PY) -m ruff format --check .
	$(PY) -m ruff check .

format: $(STAMPS)/dev
	$(PY) -m ruff check --fix .
	$(PY) -m ruff format .

types: $(STAMPS)/dev
	$(PY) -m mypy
	$(PY) -m mypy tests/house/program.py

# The explorer's JavaScript; needs node and npm, and is told as skipped without.
page: $(STAMPS)/dev
	$(PY) -m tests.house.page.checker

contracts: $(STAMPS)/dev
	$(VENV)/bin/lint-imports

budgets: $(STAMPS)/dev
	$(PY) -m tests.house.budgets

# ---------------------------------------------------------------- environment
# One environment grows: core, then the tools for tests, then those for docs. All locks agree with
# the core's, so the order does not matter. A stamp is renewed when its lock or pyproject changes.

env: $(STAMPS)/core
env-dev: $(STAMPS)/dev
env-docs: $(STAMPS)/docs

$(STAMPS)/venv:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "stickslip needs Python 3.11 or newer; \`$(PYTHON)\` is" \
			"$$($(PYTHON) --version 2>&1 || echo missing). Name another: make PYTHON=python3.12" >&2; \
		exit 1; }
	@$(PYTHON) -m venv --clear $(VENV) || { \
		rm -rf $(VENV); \
		echo "\`$(PYTHON) -m venv\` failed. On Debian or Ubuntu: apt install python3-venv" >&2; \
		exit 1; }
	@mkdir -p $(STAMPS) && touch $@

$(STAMPS)/core: $(STAMPS)/venv requirements.lock pyproject.toml
	@echo "installing the core into $(VENV) (once per requirements.lock; half a minute)" >&2
	$(PIP_INSTALL) --require-hashes -r requirements.lock
	$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

$(STAMPS)/dev: $(STAMPS)/core requirements-dev.lock
	$(PIP_INSTALL) --require-hashes -r requirements-dev.lock
	@touch $@

# Other people's solvers have no wheels for some machines: what is missing is then not compared.
$(STAMPS)/bench: $(STAMPS)/dev requirements-bench.lock
	@$(PIP_INSTALL) --require-hashes --only-binary :all: -r requirements-bench.lock || \
		echo "some of the programs to compare with cannot be installed here; without them" >&2
	@touch $@

$(STAMPS)/docs: $(STAMPS)/core requirements-docs.lock
	$(PIP_INSTALL) --require-hashes -r requirements-docs.lock
	@touch $@

# The locks: hashes, no URL, every platform and every supported Python. Needs uv (pip install uv).
# The largest comes first: what its packages allow holds for the core too.
lock:
	$(COMPILE) pyproject.toml --group build --extra dev -o requirements-dev.lock
	$(COMPILE) pyproject.toml --group build -c requirements-dev.lock -o requirements.lock
	$(COMPILE) pyproject.toml --group build --extra docs -c requirements.lock -o requirements-docs.lock
	$(COMPILE) pyproject.toml --extra bench-peers -c requirements-dev.lock -o requirements-bench.lock
	@! grep -n '://' requirements*.lock
