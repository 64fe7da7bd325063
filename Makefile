# SPDX-License-Identifier: Apache-2.0
# Every target sets up what it needs first; a second time that takes a moment.
#   make mission SCENARIO=config/scenarios/other.yaml    another mission
#   make test ARGS='test/geo -k area'                    some of the tests
#   make test ARGS='-n 0 --pdb test/geo'                 in one process, to look into a failure
#   make setup PYTHON=python3.11                         another Python than the first that fits

SCENARIO ?= config/scenarios/derailment.yaml
ARGS ?=
# Tests are not annotated: their types are those of the code they call.
TYPED := src tools $(wildcard benchmarks)
.DEFAULT_GOAL := help
# Empty unless the user names one.
export PYTHON

.PHONY: help
help: ## show this list
	@sed -n 's/^\([a-z-]*\):.*## /  make \1|/p' $(MAKEFILE_LIST) | awk -F'|' '{ printf "%-16s %s\n", $$1, $$2 }'

.PHONY: setup
setup: ## make the workspace ready: environment, ROS 2, build, commands
	@sh tools/setup.sh

.PHONY: mission
mission: ## set up and fly the derailment mission
	@sh tools/setup.sh
	@.venv/bin/rocsafe run $(SCENARIO)

# What the three tiers of tests leave out; the marks are explained in pyproject.toml.
# Compiled files are kept also where the environment forbids it: without them, each worker and
# each process of a test compiles all that it imports, and every test file.
PYTEST = . ./env.sh && TMPDIR="$$PWD/.cache/tmp" PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 \
    PYTHONDONTWRITEBYTECODE= \
    python -m pytest -p xdist -p pytest_timeout -p pytest_rerunfailures \
    -p _hypothesis_pytestplugin

.PHONY: test
test: ## set up and pass the tests
	@sh tools/setup.sh --dev
	@$(PYTEST) -n 3 --dist loadscope -m 'not all' $(ARGS)

.PHONY: test-fast
test-fast: ## set up and pass the tests that need no node and no process: under a minute
	@sh tools/setup.sh --dev
	@$(PYTEST) -n 2 --dist loadscope -m 'not process and not slow and not all' --hypothesis-profile=fast $(ARGS)

.PHONY: test-all
test-all: ## set up and pass all tests: also those with browsers and autopilots, where there are any
	@sh tools/setup.sh --dev
	@$(PYTEST) -n 3 --dist loadscope $(ARGS)

.PHONY: coverage
coverage: ## set up and measure which lines the tests of make test-fast run
	@sh tools/setup.sh --dev
	@. ./env.sh && python -m coverage run --source=src --omit='*/setup.py' -m pytest \
	    -m 'not process and not slow and not all' --hypothesis-profile=fast -q -n 0 $(ARGS) \
	    && python -m coverage report --skip-covered --sort=cover

.PHONY: check
check: ## set up and check style and types
	@sh tools/setup.sh --dev
	@. ./env.sh && ruff check && ruff format --check && mypy $(TYPED)

.PHONY: bench
bench: ## set up and measure a mission: speed, start-up, memory, size of the fleet
	@sh tools/setup.sh --dev
	@. ./env.sh && python benchmarks/mission.py $(ARGS)

.PHONY: docs
docs: ## write the tables of docs/interfaces.md and the console's catalogue of texts from the code
	@sh tools/setup.sh
	@. ./env.sh && python tools/interface_tables.py && python tools/console_texts.py

.PHONY: wheels
wheels: ## set up and make wheels of all packages and libraries in dist/, for machines without a compiler
	@sh tools/setup.sh
	@. ./env.sh && PYTHONPATH="tools:$$PYTHONPATH" python -m distribution.command

.PHONY: site
site: ## set up and build the documentation site in site/; warnings are errors
	@sh tools/setup.sh --dev
	@. ./env.sh && NO_MKDOCS_2_WARNING=1 python -m mkdocs build --strict $(ARGS)

.PHONY: clean
clean: ## remove all that set-up, checks and tests made; runs/ stays
	@sh tools/setup.sh --clean
