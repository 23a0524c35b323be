# make demo | test | lint | docs | notebooks | bench | clean.  Needs Python 3.11 or newer and make; nothing else.
#
# Everything is installed into a virtual environment of its own. Where the checkout lies on a
# slow or shared file system, put the environment on a local disk:
#     make test VENV=$HOME/.cache/pitchopt-venv
# Another interpreter: make test PYTHON=/path/to/python3.12

VENV   ?= .venv
OUT    ?= demo-output
JOBS   ?= 2
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && { echo $$p; break; }; done)

PY     := $(VENV)/bin/python
PIP    := $(PY) -m pip --disable-pip-version-check install --quiet
MARK   := $(VENV)/.installed

# One thread per process for linear algebra: the matrices are small and tests run in parallel.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo test test-slow lint format docs notebooks bench clean check-python

help:
	@echo "make demo       install and run the main job on the built-in case; tables and plots in $(OUT)/"
	@echo "make test       install with test tools and run the tests, but for slow ones"
	@echo "make test-slow  the slow ones, more than about three seconds each; CI runs both"
	@echo "make lint       ruff, mypy, import contracts"
	@echo "make format     let ruff mend what it can"
	@echo "make docs       the site with gallery and API in docs/_build/html; warnings are errors"
	@echo "make notebooks  run the teaching notebooks from top to bottom into notebooks/build/"
	@echo "make bench      timings beside other solvers, one JSON line each"
	@echo "make clean      remove environment, build products and demo output"

demo: $(MARK)-core
	$(VENV)/bin/pitchopt tradeoff --case biegel2011 --out $(OUT)

test: $(MARK)-test
	$(PY) -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder -m "not slow" $(PYTEST_ARGS)

test-slow: $(MARK)-test
	$(PY) -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder -m slow $(PYTEST_ARGS)

lint: $(MARK)-test
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	$(VENV)/bin/lint-imports

format: $(MARK)-test
	$(PY) -m ruff check --fix .
	$(PY) -m ruff format .

notebooks: $(MARK)-notebooks
	$(PY) tools/notebooks.py --jobs $(JOBS) $(NOTEBOOK_ARGS)

docs: $(MARK)-docs
	MPLBACKEND=Agg $(PY) -m sphinx -b html -W --keep-going -q docs docs/_build/html
	@echo "docs/_build/html/index.html"

bench: $(MARK)-bench
	@set -e; found=; for script in benchmarks/[a-z]*.py; do \
		test -f "$$script" || continue; found=1; $(PY) "$$script" --out "benchmarks/results/$$(basename "$$script" .py).json"; done; \
	test -n "$$found" || { echo "no scripts in benchmarks/" >&2; exit 1; }

clean:
	rm -rf $(VENV) build dist notebooks/build $(OUT) docs/_build docs/auto_gallery docs/generated .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find ilc pitchopt windfield tests -name __pycache__ -type d -prune -exec rm -rf {} +

check-python:
	@test -n "$(PYTHON)" || { \
		echo "pitchopt needs Python 3.11 or newer; none was found on PATH." >&2; \
		echo "Install one, or name it: make $(MAKECMDGOALS) PYTHON=/path/to/python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; v = sys.version_info; v >= (3, 11) or sys.exit("pitchopt needs Python 3.11 or newer; %s is %d.%d" % (sys.executable, v.major, v.minor))'

# The environment itself, then one stamp per set of packages; made again when pyproject.toml changes.
$(PY): | check-python
	@echo "making the virtual environment $(VENV) with $(PYTHON)"
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
		echo "python -m venv failed; on Debian and Ubuntu: apt install python3-venv" >&2; exit 1; }

$(MARK)-core: pyproject.toml | $(PY)
	@echo "installing pitchopt into $(VENV) (a few minutes the first time)"
	@$(PIP) --editable .
	@touch $@

$(MARK)-test $(MARK)-bench $(MARK)-notebooks $(MARK)-docs: $(MARK)-%: pyproject.toml | $(PY)
	@echo "installing pitchopt and its $* tools into $(VENV) (a few minutes the first time)"
	@$(PIP) --editable '.[$*]'
	@touch $@ $(MARK)-core
