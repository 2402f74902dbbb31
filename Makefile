# Needs python3 (3.11 or later) with python3-venv and python3-dev, make, gcc and libc6-dev; everything
# else is fetched into .venv.
# `make` alone lists the targets.

PYTHON ?= python3
VENV   ?= .venv
OUT    ?= firstcontact-study
# Delays of live estimates: benchmarks/live.py --out writes another.
DELAYS ?= docs/results/live.json
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check

# The real sets: a folder that has them in it, or one of them; a copy beside the checkout is found.
FIRSTCONTACT_DATA ?= ../shared/data

.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

.PHONY: help
help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1|/' | \
		awk -F'|' '{printf "%-22s %s\n", $$1, $$2}'

# --- what is installed -------------------------------------------------------------------------
# Only what requirements/ names, at its version and with one of its hashes; pip chooses nothing.
# The files are layers: requirements/write.py tells of what. Stamps: installing is repeated only
# when what is asked for has changed. Three quarters of the modules are never imported: Python
# compiles the others at their first import, and keeps them.
export PYTHONDONTWRITEBYTECODE =

layers = $(foreach layer,$(1),--requirement requirements/$(layer).txt)
fetch  = $(PIP) install --quiet --no-compile --no-deps --only-binary :all: --require-hashes $(call layers,$(1))
# The package itself, built with what is there already.
itself = $(PIP) install --quiet --no-deps --no-build-isolation --editable .
# With estimators of another package, which studies and tests treat as those of this one.
plugin = $(itself) --editable examples/plugin_estimators
# Built for CPUs only (1.6 GB in all), if its index can be reached. Else that of PyPI, with CUDA (5 GB).
CPU_TORCH ?= https://download.pytorch.org/whl/cpu
torch  = $(call fetch,cpu) --extra-index-url $(CPU_TORCH) --timeout 10 --retries 1 2>/dev/null || $(call fetch,cuda)
# Beside the others: it is as large as they are together. Neither outlives a failure or Ctrl-C.
both   = $(call fetch,$(1)) & others=$$!; trap wait EXIT; trap "kill $$others; exit 130" INT TERM; { $(torch); } && wait $$others
PINS  := setup.py pyproject.toml examples/plugin_estimators/pyproject.toml $(wildcard requirements/*.txt) $(wildcard src/firstcontact/twin/c/*) $(wildcard src/firstcontact/device/c/*) $(wildcard src/firstcontact/chain/c/*) $(wildcard src/firstcontact/c/*/*)

$(BIN)/pip:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.study: $(PINS) | $(BIN)/pip
	$(call both,base study)
	$(plugin)
	@touch $@

$(VENV)/.dev: $(PINS) | $(BIN)/pip
	$(call both,base study live dev)
	$(plugin)
	@touch $(VENV)/.study $(VENV)/.live $@

$(VENV)/.live: $(PINS) | $(BIN)/pip
	$(call fetch,base live)
	$(itself)
	@touch $@

.PHONY: install constraints
install: $(VENV)/.dev ## everything for development into .venv

WHEELS ?=
constraints: $(VENV)/.dev ## add what constraints.txt lacks, and write requirements/ with the hashes
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python requirements/write.py --wheels $(WHEELS)

# --- studies -----------------------------------------------------------------------------------

.PHONY: all study quick generalise grasp quick-grasp real
all: study generalise grasp real ## all studies, one after the other

study: $(VENV)/.study ## the full study at paper size: firstcontact-study/report.html
	$(BIN)/firstcontact study --delays $(DELAYS) --out $(OUT)

quick: $(VENV)/.study ## the same study, small (a minute or two): firstcontact-study/quick/report.html
	$(BIN)/firstcontact study --quick --delays $(DELAYS) --out $(OUT)/quick

generalise: $(VENV)/.study ## estimators on six rigs off the training blocks, and on rigs of another structure: firstcontact-study/generalise/report.html
	$(BIN)/firstcontact study --parts generalise structure --out $(OUT)/generalise

grasp: $(VENV)/.study ## what stiffness is worth to a hand, on the twin (4 minutes): firstcontact-study/grasp/report.html
	@# Other seeds were looked at while rules were set: the numbers in the docs are of this one.
	$(BIN)/firstcontact grasp-study --seed 1 --out $(OUT)/grasp

quick-grasp: $(VENV)/.study ## the same, small (half a minute): firstcontact-study/quick-grasp/report.html
	$(BIN)/firstcontact grasp-study --quick --out $(OUT)/quick-grasp

.PHONY: continuum
continuum: $(VENV)/.study ## touches of the twin against finite elements (3 minutes): firstcontact-study/continuum/report.html
	$(BIN)/firstcontact study --parts continuum --out $(OUT)/continuum

# CMSIS names the unpacked sources of the package cmsisdsp, whose machine is then counted, too.
CMSIS ?=
.PHONY: embedded quick-embedded
embedded: $(VENV)/.study ## models in C on the emulated Cortex-M7: parity, instructions, accuracy
	$(BIN)/python firmware/measure/measure.py --out $(OUT)/embedded $(if $(CMSIS),--cmsis $(CMSIS))

quick-embedded: $(VENV)/.study ## the same, small (a minute)
	$(BIN)/python firmware/measure/measure.py --quick --out $(OUT)/quick-embedded

real: $(VENV)/.study ## the real sets in FIRSTCONTACT_DATA on one page: firstcontact-study/real/report.html
	@sh examples/real.sh "$(FIRSTCONTACT_DATA)" "$(OUT)" "$(BIN)"

# Python with the CAD kernel: 1 GB, so beside .venv.
CAD ?= hardware/.venv/bin/python
.PHONY: hardware mount
mount: ## mount, mould and jig of the fingertip: make, check and draw them (needs build123d)
	@if $(CAD) -c 'import build123d' 2>/dev/null; then $(CAD) hardware/mount.py; else \
		echo 'hardware/mount stays as it is, since build123d is missing: install it (1 GB) with' \
		'python3 -m venv hardware/.venv && hardware/.venv/bin/pip install -r hardware/requirements-mount.txt'; fi

hardware: $(VENV)/.dev mount ## circuit simulated (needs ngspice), boards written, checked and made ready for the fab (needs KiCad 9)
	$(BIN)/python hardware/write_page.py --measure
	$(BIN)/python hardware/build_boards.py

# --- live --------------------------------------------------------------------------------------

.PHONY: live
live: $(VENV)/.live ## the live page, with a simulated hand to close and open: http://127.0.0.1:8765/
	$(BIN)/firstcontact live --device twin --hand twin --page

.PHONY: twin-model
twin-model: $(VENV)/.live ## the model that ships for the simulated hand, anew (half a minute)
	rm -rf $(OUT)/twin-model
	$(BIN)/firstcontact simulate --out $(OUT)/twin-model/pinches --pinches-per-block 60 --pinches-per-object 0
	$(BIN)/firstcontact train $(OUT)/twin-model/pinches --out $(OUT)/twin-model/model
	cp $(OUT)/twin-model/model/* src/firstcontact/twin/pretrained/

# --- checks ------------------------------------------------------------------------------------

.PHONY: test test-install wheel test-oldest test-slow mutation fuzz soak lint format types layers docs bench
# Tests of devices and of the page wait a third of their time: more processes than cores.
TESTERS ?= $(shell expr 3 \* $$(getconf _NPROCESSORS_ONLN) / 2 + 1)
# Hundreds of processes import the package: compiled once, it takes each 0.4 s less.
test: $(VENV)/.dev ## the tests, side by side on all cores
	@# Compiled beforehand: else each process does so.
	[ -d tests/__pycache__ ] || $(BIN)/python -m pytest --collect-only -qq >/dev/null
	$(BIN)/python -m pytest --numprocesses $(TESTERS) --dist worksteal

test-install: $(VENV)/.dev ## wheel and sdist, built and installed into empty environments
	$(BIN)/python -m pytest -m slow tests/cli/test_install.py

wheel: ## sdist and abi3 wheel of the last commit into dist/, tested in an empty environment
	.ci/wheel dist

# EXTRAS without cnn leaves out 5 GB of PyTorch. Warnings of new packages about old ones are no
# faults, and the test that is left out expects the package of this checkout.
EXTRAS ?= plot,train,live,parquet,files,audio,hand,cluster,cnn
OLDEST ?= tests/core tests/recording tests/signal tests/contact tests/models tests/twin tests/streaming
test-oldest: $(VENV)/.dev ## some tests (OLDEST) with the oldest packages that pyproject.toml allows
	folder=$$(mktemp -d) && trap "rm -rf $$folder" EXIT && \
	$(BIN)/uv build --quiet --sdist --out-dir $$folder . && \
	tar -xzf $$folder/*.tar.gz -C $$folder --strip-components 1 && \
	$(BIN)/uv venv --quiet --seed --python $(BIN)/python $$folder/.venv && \
	$(BIN)/uv pip install --quiet --python $$folder/.venv --resolution lowest-direct \
		--editable "$$folder[$(EXTRAS)]" \
		$$(grep -E '^(pytest|pytest-timeout|hypothesis|selenium|jinja2|setuptools)==' constraints.txt) && \
	PATH="$$folder/.venv/bin:$$PATH" python -m pytest -W ignore::DeprecationWarning $(OLDEST) \
		--deselect tests/core/test_core_installation.py::test_install_command_names_the_path_of_a_clone

test-slow: $(VENV)/.dev ## the long tests: paper size, soak, installed wheel, slow commands in the docs, all variants
	$(BIN)/python -m pytest -m slow --timeout 3600

COUNT ?= 100000
SEED  ?= 1
fuzz: $(VENV)/.dev ## damaged inputs (COUNT, SEED) through every way in: findings in fuzz.jsonl
	$(BIN)/python tests/fuzz/fuzz.py --count $(COUNT) --seed $(SEED) --findings fuzz.jsonl

mutation: $(VENV)/.dev ## faults one at a time, each to be found by the fast tests of its room
	$(BIN)/python tests/mutation/mutation.py

MINUTES ?= 60
soak: $(VENV)/.dev ## all live sources at once (MINUTES, SEED) with faults: exact counts in soak.json
	$(BIN)/python tests/soak/soak.py --minutes $(MINUTES) --seed $(SEED) --out soak.json

lint: $(VENV)/.dev ## ruff: rules and format; codespell: misspelt words
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell docs src tests examples firmware benchmarks hardware *.md

format: $(VENV)/.dev ## let ruff rewrite what it can
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types: $(VENV)/.dev ## mypy --strict
	$(BIN)/mypy

layers: $(VENV)/.dev ## rooms import downwards only
	$(BIN)/lint-imports

docs: $(VENV)/.dev ## the documentation into site/; `python -m http.server -d site` serves it with search
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

bench: $(VENV)/.dev ## what is timed: benchmarks/, with what became slower (5 minutes)
	$(BIN)/python benchmarks/run.py $(if $(BENCHMARKS),--out $(BENCHMARKS))

# --- numbers in the docs -----------------------------------------------------------------------

.PHONY: readme-numbers
readme-numbers: $(VENV)/.study ## copy the numbers of all studies into docs/results and the tables
	$(BIN)/python docs/write_tables.py --study $(OUT)/results.json --generalise $(OUT)/generalise/results.json \
		--real $(OUT)/real/impact_hardness/results.json \
		--strikes $(OUT)/real/piezo_strikes/results.json --sets $(OUT)/real/results.json --grasp $(OUT)/grasp/results.json
	$(BIN)/python docs/draw_beyond_blocks.py

.PHONY: clean
clean: ## remove what was built (studies and .venv stay)
	rm -rf build dist site .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find src tests docs benchmarks examples -name __pycache__ -type d -prune -exec rm -rf {} +
	rm -rf src/*.egg-info examples/*/*.egg-info src/firstcontact/twin/_compiled*.so src/firstcontact/device/_compiled*.so src/firstcontact/chain/_compiled*.so
