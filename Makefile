# Everything is set up by the targets themselves, in .venv, from Python 3.11 or newer.
# Another interpreter: make PYTHON=/path/to/python3.12 test

VENV  := .venv
BIN   := $(VENV)/bin
STAMP := $(VENV)/.installed
OUT   ?= out
REPRODUCTION ?= reproduction

# All on which machine code depends, as in src/vtank/compiled.py: the folders of compiled laws
LAWS := $(wildcard $(addsuffix *.py,$(sort $(dir $(shell grep -rl --include='*.py' 'compiled import' src/vtank)))))
COMPILED := $(VENV)/.compiled

NEW_ENOUGH := import sys; sys.exit(sys.version_info < (3, 11))
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python; do \
            $$p -c '$(NEW_ENOUGH)' 2>/dev/null && echo $$p && break; done)

.PHONY: venv check format test test-all fuzz soak demo reproduce bench wheel wheel-test test-deps test-oldest test-newest clean

venv: $(STAMP)

$(STAMP): pyproject.toml
	@test -n "$(PYTHON)" || { echo "vtank needs Python 3.11 or newer: none found; give one with make PYTHON=..." >&2; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

check: $(STAMP)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

format: $(STAMP)
	$(BIN)/ruff format
	$(BIN)/ruff check --fix

test: check  # without the tests that are marked slow
	$(BIN)/pytest -n 2 --dist loadfile -m "not slow"

test-all: check  # what CI runs
	$(BIN)/pytest -n 2 --dist loadfile

fuzz: $(STAMP)  # ten times the cases of make test-all: more than 20,000 spoilt files and 250 kills
	VTANK_FUZZ=10 $(BIN)/pytest -n 2 tests/test_fuzz.py tests/test_kills.py

soak: $(STAMP)  # twenty times the length of make test-all: a million seconds on the surge model, 50,000 in the tank
	VTANK_SOAK=20 $(BIN)/pytest -s tests/test_soak.py

demo: $(COMPILED)
	$(BIN)/vtank demo --out $(OUT)

$(COMPILED): $(STAMP) $(LAWS)  # by a first telling that nobody sees; for the demo alone
	@echo "Compiling the equations of motion for the demo, once: two minutes or three"
	@$(BIN)/vtank demo --out $(VENV)/untold > $(VENV)/untold.txt 2>&1 || { cat $(VENV)/untold.txt >&2; exit 1; }
	@rm -rf $(VENV)/untold $(VENV)/untold.txt
	@touch $@

reproduce: $(STAMP)
	$(BIN)/vtank reproduce --out $(REPRODUCTION)

bench: $(STAMP)
	$(BIN)/pytest benchmarks

# The quick tests with the oldest versions that pyproject.toml allows and with the newest, each in an environment of its
# own; with another Python: make PYTHON=python3.13 test-newest
test-deps: test-oldest test-newest

test-oldest test-newest: test-%:
	$(PYTHON) -m venv --clear .venv-$*
	$(PYTHON) tests/bounds.py $* > .venv-$*/constraints.txt
	.venv-$*/bin/python -m pip install --quiet --disable-pip-version-check --constraint .venv-$*/constraints.txt \
	  --editable '.[test,cluster,film,gym,h5,logs]'
	.venv-$*/bin/pytest -n 2 --dist loadfile -m "not slow"

wheel-test: $(STAMP)  # wheel and source package, each in an empty environment, outside of the checkout, without a network
	rm -rf dist
	$(BIN)/hatchling build -d dist
	$(BIN)/python tests/installed.py dist/*

wheel: $(STAMP)
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .

clean:
	rm -rf $(VENV) $(VENV)-* $(OUT) $(REPRODUCTION) build dist .pytest_cache .ruff_cache .mypy_cache .benchmarks .hypothesis
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +
