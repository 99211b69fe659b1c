# `make demo` and `make test` set up all they need, then run. `make help` lists the verbs.
PYTHON ?= python3
VENV := .venv
ifeq ($(OS),Windows_NT)
BIN := $(VENV)/Scripts
else
BIN := $(VENV)/bin
endif
READY := $(VENV)/ready

.PHONY: help demo test check format bench clean

help:
	@echo "make demo    simulate the Pixel study, measure it, print truth beside measurement"
	@echo "make test    the whole test suite"
	@echo "make check   formatting, lint, types, import contracts, size budget, doctests"
	@echo "make format  format and mend what can be mended mechanically"
	@echo "make bench   benchmarks, as ratios in one run"

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[dev]"
	@touch $(READY)

demo: $(READY)
	$(BIN)/fullwell demo -o demo-out

test: $(READY)
	$(BIN)/python -m pytest -n auto

check: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/pyright
	$(BIN)/lint-imports
	$(BIN)/python tools/size_budget.py
	$(BIN)/python -m pytest --doctest-modules src/fullwell

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(READY)
	$(BIN)/python -m benchmarks

clean:
	rm -rf $(VENV) demo-out build dist
