# Needs python3 (3.11 or later), python3-venv and make; everything else is fetched into .venv.
# `make` alone lists the targets.

PYTHON ?= python3
VENV   ?= .venv
OUT    ?= firstcontact-study
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check

# The real impacts: their folder, or one that has it in it; a copy beside the checkout is found.
FIRSTCONTACT_DATA ?= ../shared/data

.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

.PHONY: help
help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1|/' | \
		awk -F'|' '{printf "%-22s %s\n", $$1, $$2}'

# --- what is installed -------------------------------------------------------------------------
# Stamps: installing is repeated only when what is asked for has changed. The build tool is
# installed first, so that pip builds with the pinned one instead of fetching its own.

$(BIN)/pip:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.build-tool: constraints.txt | $(BIN)/pip
	$(PIP) install --quiet --constraint constraints.txt setuptools
	@touch $@

$(VENV)/.study: pyproject.toml constraints.txt $(VENV)/.build-tool
	$(PIP) install --quiet --no-build-isolation --constraint constraints.txt --editable '.[study]'
	@touch $@

$(VENV)/.dev: pyproject.toml constraints.txt $(VENV)/.build-tool
	$(PIP) install --quiet --no-build-isolation --constraint constraints.txt --editable '.[dev]'
	@touch $(VENV)/.study $(VENV)/.live $@

$(VENV)/.live: pyproject.toml constraints.txt $(VENV)/.build-tool
	$(PIP) install --quiet --no-build-isolation --constraint constraints.txt --editable '.[twin,live]'
	@touch $@

.PHONY: install constraints
install: $(VENV)/.dev ## everything for development into .venv

constraints: $(VENV)/.dev ## pin what is in .venv now; what is not in it stays as it was
	( sed -n '/^#/p' constraints.txt; \
	  ( $(PIP) freeze --all --exclude-editable --exclude pip | sed -E 's/\+[a-z0-9.]+$$//'; \
	    cat constraints.txt ) | grep -v '^#' | sort --ignore-case --stable --unique -t= -k1,1 \
	) > constraints.new
	mv constraints.new constraints.txt

# --- studies -----------------------------------------------------------------------------------

.PHONY: study quick grasp quick-grasp real
study: $(VENV)/.study ## the full study at paper size: firstcontact-study/report.html
	$(BIN)/firstcontact study --out $(OUT)

quick: $(VENV)/.study ## the same study, small (a minute): firstcontact-study/quick/report.html
	$(BIN)/firstcontact study --quick --out $(OUT)/quick

grasp: $(VENV)/.study ## policies against one another on the twin (5 minutes): firstcontact-study/grasp/report.html
	@# Seed 0 was looked at while the rule was set: the numbers in the docs are another's.
	$(BIN)/firstcontact grasp-study --seed 1 --out $(OUT)/grasp

quick-grasp: $(VENV)/.study ## the same, small (half a minute): firstcontact-study/quick-grasp/report.html
	$(BIN)/firstcontact grasp-study --quick --out $(OUT)/quick-grasp

real: $(VENV)/.study ## the study of real impacts (FIRSTCONTACT_DATA): firstcontact-study/real/report.html
	@# The labels are those of a trigger, which comes up to 4 ms after the hit.
	@for place in "$(FIRSTCONTACT_DATA)" "$(FIRSTCONTACT_DATA)/impact_hardness"; do \
		if [ -f "$$place/labels.csv" ]; then \
			exec $(BIN)/firstcontact study --recordings "$$place" --early-ms 4 --out $(OUT)/real; \
		fi; \
	done; \
	{ echo "make real: no labels.csv in FIRSTCONTACT_DATA=$(FIRSTCONTACT_DATA)"; \
	echo "Get the recordings (MIT licence) from github.com/Kev-HL/acoustic-hardness-classifier,"; \
	echo "converted to WAV as docs/how-to/real-impacts.md says, and name their folder:"; \
	echo "    make real FIRSTCONTACT_DATA=/path/to/impact_hardness"; } >&2; exit 2

# --- live --------------------------------------------------------------------------------------

.PHONY: live
live: $(VENV)/.live ## the live page, with the simulated hand: opens on http://127.0.0.1:8765/
	$(BIN)/firstcontact live --device twin --page

# --- checks ------------------------------------------------------------------------------------

.PHONY: test test-slow lint format types layers docs bench
test: $(VENV)/.dev ## the tests
	$(BIN)/python -m pytest

test-slow: $(VENV)/.dev ## the long tests: paper size, soak, installed wheel, slow commands in the docs
	$(BIN)/python -m pytest -m slow --timeout 3600

lint: $(VENV)/.dev ## ruff: rules and format
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format: $(VENV)/.dev ## let ruff rewrite what it can
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types: $(VENV)/.dev ## mypy --strict
	$(BIN)/mypy

layers: $(VENV)/.dev ## rooms import downwards only
	$(BIN)/lint-imports

docs: $(VENV)/.dev ## the documentation into site/
	$(BIN)/mkdocs build --strict

bench: $(VENV)/.dev ## what is timed: benchmarks/
	for file in benchmarks/*.py; do OMP_NUM_THREADS=1 $(BIN)/python $$file || exit 1; done

# --- numbers in the docs -----------------------------------------------------------------------

.PHONY: readme-numbers
readme-numbers: $(VENV)/.study ## copy the numbers of all studies into docs/results and the tables
	$(BIN)/python docs/write_tables.py --study $(OUT)/results.json \
		--real $(OUT)/real/results.json --grasp $(OUT)/grasp/results.json

.PHONY: clean
clean: ## remove what was built (studies and .venv stay)
	rm -rf build dist site .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests docs benchmarks examples -name __pycache__ -type d -prune -exec rm -rf {} +
	rm -rf src/*.egg-info
