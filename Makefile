# Everything a user or CI needs, on a machine with Python 3.11 and make only.
PYTHON ?= python3.11
VENV   := .venv
STAMP  := $(VENV)/.installed
RUN    := $(VENV)/bin/

export MPLBACKEND = Agg
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: demo example test test-all fuzz lint types bench models lock clean help
.DEFAULT_GOAL := help

help:
	@echo "make demo      the whole loop on a simulated KR 500, results in reports/demo"
	@echo "make example   the page, report and scene of the demo that are kept in reports/example"
	@echo "make test      the tests (about 13 minutes on two cores)"
	@echo "make test-all  the tests and the slow studies"
	@echo "make fuzz      20,000 spoilt inputs, what came of them in docs/robustness.md (a quarter of an hour)"
	@echo "make lint types bench models lock clean"

$(STAMP): pyproject.toml requirements.lock
	$(PYTHON) -m venv $(VENV)
	$(RUN)python -m pip install --quiet --disable-pip-version-check uv
	$(RUN)uv pip install --quiet --python $(RUN)python --require-hashes -r requirements.lock
	$(RUN)uv pip install --quiet --python $(RUN)python --no-deps --no-build-isolation -e .
	@touch $(STAMP)

demo: $(STAMP)
	$(RUN)workbench demo

# Without the closed loop's own page and the first campaign's, whose scenes are as large again, and without links to them.
example: demo
	mkdir -p reports/example
	cp $(addprefix reports/demo/,report.pdf scene.html result.json residuals.csv model.toml) reports/example
	cp -r reports/demo/urdf reports/example
	sed -e 's|<a href="path/verify.html">\(.*\)</a>|\1|' -e '/href="first\/index.html"/d' \
		reports/demo/index.html > reports/example/index.html

test: $(STAMP)
	$(RUN)python -m pytest -n 2 --dist loadfile -m "not slow" $(PYTEST_ARGS)

test-all: $(STAMP)
	$(RUN)python -m pytest -n 2 $(PYTEST_ARGS)

fuzz: $(STAMP)
	$(RUN)python tests/robustness/fuzz.py

lint: $(STAMP)
	$(RUN)ruff check .
	$(RUN)ruff format --check .

types: $(STAMP)
	$(RUN)mypy

bench: $(STAMP)
	$(RUN)python benchmarks/arm.py
	$(RUN)python benchmarks/w1.py --quick
	$(RUN)python benchmarks/compensate.py
	$(RUN)python benchmarks/closed_loop.py

models: $(STAMP)
	$(RUN)python models/make_models.py

lock: $(STAMP)
	$(RUN)uv pip compile --quiet pyproject.toml --extra dev --extra robots --generate-hashes --no-emit-index-url \
		--no-header --no-annotate --python-version 3.11 -o requirements.lock

clean:
	find reports -mindepth 1 -maxdepth 1 ! -name README.md ! -name example -exec rm -rf {} +
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache
