# make quickstart   generate data, train two methods, evaluate them, print the table, save the plot
# make test         the whole test suite
# make lint         format, lint and type checks
PYTHON ?= python3
BIN := .venv/bin
WORK ?= runs/quickstart
ENVIRONMENT := cube-single
METHODS := gcivl hjb-gcivl
RUNS := $(METHODS:%=$(WORK)/%)
STEPS := 12000

.PHONY: quickstart test lint
.DEFAULT_GOAL := quickstart

.venv/installed: requirements.txt pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check -r requirements.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --editable .
	touch $@

quickstart: .venv/installed
	$(BIN)/pigbench generate $(ENVIRONMENT) --out $(WORK)/data --episodes 200 --validation-episodes 10
	for method in $(METHODS); do \
	  $(BIN)/pigbench train $$method --data $(WORK)/data --out $(WORK)/$$method \
	    --preset cpu --steps $(STEPS) --evaluate-every 3000 || exit; \
	done
	$(BIN)/pigbench table $(RUNS)
	$(BIN)/pigbench plot $(RUNS) --out $(WORK)/curves.png
	@echo "data, runs and plot lie in $(WORK)"

test: .venv/installed
	$(BIN)/pytest

lint: .venv/installed
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	rm -rf build
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --target build/installed .
	cp pyproject.toml build/installed
	$(BIN)/pyright --project build/installed --pythonpath $(BIN)/python
