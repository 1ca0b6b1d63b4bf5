# `make demo` and `make test` set up all they need in .venv (Python 3.11 or later, a package index).
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test check package docs pictures viewer constraints clean

demo: .venv/library  ## match a generated animal's fragment with the whole; needs no files
	$(BIN)/sherd demo -o out/demo

# There is a process for each core, so each takes one thread; what a module's
# tests share is made once.
test: check  ## format, lint, types, then all tests on all cores
	NUMBA_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist loadscope

check: .venv/development
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

package: .venv/development  ## build wheel and archive, install the wheel alone in a fresh environment, run its demo
	$(BIN)/python packaging/check_package.py

docs: .venv/documentation  ## build the pages into docs/_build; warnings are errors
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build
	@echo "open docs/_build/index.html"

pictures: .venv/development  ## draw docs/images anew from the generated animal
	$(BIN)/python docs/pictures.py

viewer:  ## rebuild the page's script from viewer/ (needs Node.js)
	cd viewer && npm ci && npm run build

constraints:  ## pin anew, to the newest versions, what a full installation needs; then `make test`
	rm -rf build/constraints
	$(PYTHON) -m venv build/constraints
	build/constraints/bin/python -m pip install --quiet --disable-pip-version-check ".[plots,witness,development,docs]"
	{ grep '^#' constraints.txt; build/constraints/bin/python -m pip freeze --exclude sherd; } > build/constraints.txt
	mv build/constraints.txt constraints.txt
	rm -rf build/constraints

clean:
	rm -rf .venv out build dist

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit("sherd needs Python 3.11 or later; set PYTHON=") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv .venv

.venv/library: pyproject.toml constraints.txt | .venv/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	$(BIN)/python -m compileall -q src  # pip does so for what it copies; a start takes 0.1 s less
	touch $@

.venv/development: .venv/library
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[plots,witness,development]"
	touch $@

.venv/documentation: .venv/library
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[docs]"
	touch $@
