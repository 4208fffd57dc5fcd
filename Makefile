# make demo   plan, carry out and film the paper's manipulation case study
# make test   run every test
# make lint   check style and types
# make paper  do the paper's examples, case studies and table again, on one page
# make docs   build the tutorial and the reference into build/docs
# make setup  what the others call first: a virtual environment in .venv

PYTHON ?= python3
BIN := .venv/bin
READY := .venv/ready

.PHONY: setup demo test lint paper docs clean

setup: $(READY)
	@echo "Ready. Try: make demo, make test, or $(BIN)/prefplan --help"

$(READY): pyproject.toml .ci/setup
	PYTHON="$(PYTHON)" .ci/setup
	@touch $@

demo: $(READY)
	$(BIN)/python experiments/case_study_3.py

test: $(READY)
	$(BIN)/python -m pytest -n auto

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

paper: $(READY)
	$(BIN)/python experiments/reproduce_paper.py

docs: $(READY)
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs build/docs
	@echo "Open build/docs/index.html"

clean:
	rm -rf .venv out build *.egg-info .pytest_cache .ruff_cache .mypy_cache
