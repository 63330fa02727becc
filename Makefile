# make quickstart   generate data, train two methods, evaluate them, print the table, save the plot
# make test         the whole test suite
# make lint         format, lint and type checks
# make docs         the documentation as a site, in build/site
# make dist         a source distribution, and a wheel made from it, in dist
PYTHON ?= python3
BIN := .venv/bin
WORK ?= runs/quickstart
METHODS := gcivl hjb-gcivl
TRAININGS := $(METHODS:%=$(WORK)/%)

.PHONY: quickstart test lint docs dist $(TRAININGS)
.DEFAULT_GOAL := quickstart

.venv/installed: requirements.txt pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps -r requirements.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --editable .
	touch $@

quickstart: .venv/installed
	$(BIN)/pigbench generate cube-single --out $(WORK)/data --episodes 200 --validation-episodes 1
	$(MAKE) --jobs 2 $(TRAININGS)
	$(BIN)/pigbench table $(TRAININGS) --show methods milestones | tee $(WORK)/table.md
	$(BIN)/pigbench plot $(TRAININGS) --out $(WORK)/curves.png
	@echo "data, runs, table and plot are in $(WORK)"

# Two processes of one thread each use two cores better than one of two.
$(TRAININGS) test: export NPROC = 1
$(TRAININGS): $(WORK)/%:
	$(BIN)/pigbench train $* --data $(WORK)/data --out $@ --preset cpu --goals cubes \
	  --steps 16000 --evaluate-every 4000 --evaluation.episodes 10

test: .venv/installed
	$(BIN)/pytest --numprocesses logical --dist loadfile

lint: .venv/installed
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	rm -rf build
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --target build/installed .
	cp pyproject.toml build/installed
	$(BIN)/pyright --project build/installed --pythonpath $(BIN)/python

docs: .venv/installed
	$(BIN)/mkdocs build --quiet

dist: .venv/installed
	rm -rf dist
	$(BIN)/python -c "from setuptools import build_meta; build_meta.build_sdist('dist')"
	$(BIN)/pip wheel --quiet --disable-pip-version-check --no-index --no-deps --no-build-isolation \
	  --wheel-dir dist dist/pigbench-*.tar.gz
