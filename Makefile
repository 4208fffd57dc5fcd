# make demo   plan the paper's manipulation case study, carry it out and make videos
# make test   run every test
# make lint   check style, types and imports
# make paper  compute the paper's examples, case studies and table again, on one page
# make docs   build the tutorial, the guide and the reference into build/docs
# make setup  make the virtual environment .venv, with all tools; the other targets make what they need of it

PYTHON ?= python3
BIN := .venv/bin
READY := .venv/ready
TOOLS := .venv/tools

# What is imported is compiled to bytecode once, not again in each process that imports it.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup demo test lint paper docs clean

setup: $(TOOLS)
	@echo "Ready. Try: make demo, make test, or $(BIN)/prefplan --help"

$(READY): pyproject.toml .ci/setup
	PYTHON="$(PYTHON)" .ci/setup run
	@touch $@

$(TOOLS): $(READY)
	.ci/setup dev
	@touch $@

demo: $(READY)
	$(BIN)/python experiments/case_study_3.py

# Each worker takes neighbouring tests, so that few of the fixtures of a file are made twice. There is one more than
# cores: tests that drive a browser or other processes wait for them.
test: $(TOOLS)
	@echo "Running every test: 6 to 8 minutes on 2 cores"
	$(BIN)/python -m pytest -n $$(expr $$(nproc) + 1) --dist worksteal

lint: $(TOOLS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

paper: $(READY)
	$(BIN)/python experiments/reproduce_paper.py

docs: $(TOOLS)
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs build/docs
	@echo "Open build/docs/index.html"

clean:
	rm -rf .venv out build *.egg-info .pytest_cache .ruff_cache .mypy_cache
