# make setup | report | test | lint | types | bench | guard | fuzz | docs | pictures | wheel | clean
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: help setup report test lint types bench guard fuzz docs pictures wheel clean

help:
	@echo "make setup    a virtual environment in $(VENV) with everything that tests and reports need"
	@echo "make report   set up, run the quick tables and leave report.html"
	@echo "make test     set up and run the tests (LODBENCH_DATA=folder adds those on real models)"
	@echo "make lint     ruff, on code and formatting"
	@echo "make types    pyright"
	@echo "make bench    all tables at full size, into results/"
	@echo "make guard    a short run against the recorded ones: what got slower, relative to numpy and to copying"
	@echo "make fuzz     10,000 inputs of every system and reader, killed runs, full disks: hours (INPUTS=100 for less)"
	@echo "make docs     the user guide and the interface as pages, in docs/_build/html"
	@echo "make pictures the guide's pictures anew, by the commands beside them"
	@echo "make wheel    build the wheel and the source distribution"

setup: $(READY)

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[report,datasets,dev,gl]"
	@touch $@
	@echo "ready: '. $(VENV)/bin/activate' puts lodbench on the path"

report: $(READY)
	$(BIN)/lodbench reproduce --quick
	@cp "$$(ls -t results/*/*/report.html | head -n 1)" report.html && echo "report: report.html"

test: $(READY)
	$(BIN)/python -m pytest -n logical --maxprocesses 4 --dist worksteal

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/pyright

bench: $(READY)
	$(BIN)/lodbench reproduce

guard: $(READY)
	$(BIN)/lodbench guard

INPUTS ?= 10000
STOPS ?= 100
fuzz: $(READY)
	$(BIN)/python -m tests.fuzz --inputs $(INPUTS) --stops $(STOPS)

docs: $(READY)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[docs]"
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html && echo "docs: docs/_build/html/index.html"

pictures: $(READY)
	$(BIN)/python docs/pictures.py

wheel: $(READY) clean
	$(BIN)/python -m build

clean:
	rm -rf build dist *.egg-info
