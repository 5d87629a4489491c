# The two commands of the README are `make demo` and `make test`; CI runs `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

RUST := $(shell find rust benches -name '*.rs') $(wildcard tests/rust/*.rs) Cargo.toml Cargo.lock rustfmt.toml
PACKAGE := $(shell find python -name '*.py' -o -name '*.pyi' -o -name py.typed) pyproject.toml README.md

.PHONY: demo papers test lint format settings rust-test python-test instructions docs bench clean

## Simulates an MPU6050 walk, tracks it, and leaves the results in demo/
demo: $(VENV)/installed
	$(BIN)/footnav demo --out demo

## Repeats the experiments of the four papers; the figures are left in target/papers.json
papers: $(VENV)/installed
	$(BIN)/python benches/papers.py --json target/papers.json

## Everything that CI runs
test: lint rust-test python-test instructions docs

lint: $(VENV)/tools $(VENV)/installed
	cargo fmt --check
	cargo clippy --all-targets -- -D warnings
	cargo clippy --features python -- -D warnings
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest footnav._core

rust-test:
	cargo test

python-test: $(VENV)/tools $(VENV)/installed
	$(BIN)/python -m pytest

## Compares the instructions of one fixed walk with those of benches/instructions.toml; skips where valgrind is missing
instructions: $(VENV)/installed
	$(BIN)/python benches/instructions.py

docs: $(VENV)/tools
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps
	$(BIN)/numpydoc lint $$(find python -name '*.py')

bench:
	cargo bench

## Rewrites the sources in the project's format
format: $(VENV)/tools
	cargo fmt
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

## Rewrites the Python settings and their reference page from the declarations in the Rust core
settings: $(VENV)/installed
	$(BIN)/python tools/generate_settings.py

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"

$(VENV)/installed: $(VENV)/bin/python $(RUST) $(PACKAGE)
	$(BIN)/python -m pip install --quiet "maturin>=1.9,<2"
	rm -rf dist
	$(BIN)/maturin build --release --out dist
	$(BIN)/python -m pip install --quiet --force-reinstall --no-deps dist/*.whl
	$(BIN)/python -m pip install --quiet "footnav[plot]"
	touch $@

$(VENV)/tools: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --group test --group lint
	touch $@

clean:
	rm -rf $(VENV) target dist demo .mypy_cache .ruff_cache .pytest_cache .hypothesis
