# Every target makes its own virtual environment with what it needs; nothing has to be installed by hand.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= out/demo
SITE ?= out/docs
# The versions that are tested together; `make test LOCK=` takes the newest that pyproject.toml allows.
LOCK ?= requirements.lock
PIP := $(BIN)/pip install --quiet $(if $(LOCK),--constraint $(LOCK))

# Where a shell or an image sets it, each process that the tests start would compile the sources for itself.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help demo test check census first-run wheel mutants docs lock bench clean

help:  ## what there is to make
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 8

$(VENV)/.base: pyproject.toml $(LOCK)
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --upgrade pip
	$(PIP) --editable .
	@touch $@

$(VENV)/.%: $(VENV)/.base
	$(PIP) --editable ".[$*]"
	@touch $@

demo: $(VENV)/.base  ## plan the bundled part on a bundled machine and name the report to open
	$(BIN)/toolpace demo --out $(OUT)

test: $(VENV)/.base $(VENV)/.test  ## all tests a person waits for; with CI=true the long sweeps too
	$(BIN)/python -m pytest -n 2 --dist worksteal $(PYTEST)

check: $(VENV)/.base $(VENV)/.check  ## lint, types (Linux, Windows; make types-darwin for macOS), import contracts
	$(BIN)/ruff check .
	$(MAKE) --no-print-directory -j 2 types-linux types-win32
	$(BIN)/lint-imports
	$(BIN)/python tools/census.py --strict

types-%: $(VENV)/.base $(VENV)/.check
	$(BIN)/mypy --platform $* --cache-dir .mypy_cache/$*

docs: $(VENV)/.base $(VENV)/.docs  ## the documentation as a site, with the pictures of the examples; any warning fails
	$(BIN)/sphinx-build -E -W --keep-going -n -q -b html docs $(SITE)
	@echo "open $(SITE)/index.html"

census:  ## count modules, circles, long functions; CENSUS=--strict fails where a rule of the house is broken
	$(PYTHON) tools/census.py $(CENSUS)

first-run: $(VENV)/.base  ## compile all from an empty cache: kernels, specialisations, seconds
	$(BIN)/python tools/first_run.py

wheel: $(VENV)/.base  ## a wheel for this platform with compiled kernels, in dist: the first run compiles nothing
	$(BIN)/python tools/wheel.py dist

MUTANTS ?= 300
mutants: $(VENV)/.base $(VENV)/.test $(VENV)/.mutants  ## small changes of the code, each tried on the tests that run its line; takes hours
	test -e out/mutants/coverage || $(BIN)/python -m tools.mutants map tests
	$(BIN)/python -m tools.mutants try --count $(MUTANTS)
	$(BIN)/python -m tools.mutants table

lock: $(VENV)/.base  ## write requirements.lock anew, from the newest versions that pyproject.toml allows
	$(BIN)/pip install --quiet --upgrade --upgrade-strategy eager --editable ".[png,app,cluster,bench,test,mutants,docs,check]"
	$(BIN)/python tools/lock.py

bench: $(VENV)/.base $(VENV)/.bench  ## the benchmarks, against peers
	$(BIN)/python -m benchmarks.default
	$(BIN)/python -m benchmarks
	$(BIN)/python -m benchmarks.second_order
	$(BIN)/python -m benchmarks.scaling
	$(BIN)/python -m benchmarks.tolerances
	$(BIN)/python -m benchmarks.efforts
	$(BIN)/python -m benchmarks.reading
	$(BIN)/python -m benchmarks.first_minutes

clean:  ## remove what was made
	rm -rf $(VENV) out docs/gallery $(filter-out docs/benchmarks/index.md,$(wildcard docs/benchmarks/*.md)) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
