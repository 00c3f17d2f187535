# Every target sets up .venv by itself, or .venv-libraries. It needs Python 3.11 or newer, pip, make and git.
PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin/python
STAMP := $(VENV)/.ready
DOCS_STAMP := $(VENV)/.docs-ready
LIBRARIES_VENV := .venv-libraries
LIBRARIES_RUN := $(LIBRARIES_VENV)/bin/python
LIBRARIES_STAMP := $(LIBRARIES_VENV)/.ready

.PHONY: help setup evaluate test libraries train bench docs links lint format clean

help:  ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /	/'

setup: $(STAMP)  ## create the virtual environment

$(STAMP): pyproject.toml constraints.txt
	test -x $(RUN) || $(PYTHON) -m venv $(VENV)
	$(RUN) -m pip install --quiet --disable-pip-version-check torch==2.13.0 -c constraints.txt
	$(RUN) -m pip install --quiet --disable-pip-version-check --editable '.[train,dev,lmi,cluster,render]' -c constraints.txt
	touch $(STAMP)

evaluate: $(STAMP)  ## compare the shipped agent with the baselines on identical faults
	$(RUN) train/evaluate.py

test: $(STAMP)  ## run the tests
	$(RUN) -m pytest -n 2 --dist loadfile --no-loadscope-reorder --ignore tests/libraries

$(LIBRARIES_STAMP): pyproject.toml constraints-libraries.txt
	test -x $(LIBRARIES_RUN) || $(PYTHON) -m venv $(LIBRARIES_VENV)
	$(LIBRARIES_RUN) -m pip install --quiet --disable-pip-version-check torch==2.13.0 -c constraints-libraries.txt
	$(LIBRARIES_RUN) -m pip install --quiet --disable-pip-version-check --editable '.[libraries]' -c constraints-libraries.txt
	touch $(LIBRARIES_STAMP)

libraries: $(LIBRARIES_STAMP)  ## run the environments with libraries of reinforcement learning, in .venv-libraries
	OMP_NUM_THREADS=1 $(LIBRARIES_RUN) -m pytest -n 2 --dist load -o filterwarnings=default --disable-warnings tests/libraries

train: $(STAMP)  ## train the shipped agent again
	$(RUN) train/train.py

bench: $(STAMP)  ## measure the speed, as ratios of one run
	$(RUN) benchmarks/benchmark.py

$(DOCS_STAMP): $(STAMP)
	$(RUN) -m pip install --quiet --disable-pip-version-check --editable '.[docs,render]' -c constraints.txt
	touch $(DOCS_STAMP)

docs: $(DOCS_STAMP)  ## build the documentation site, run its tutorials and check its internal links
	$(RUN) -m sphinx --jobs auto --fresh-env --fail-on-warning --keep-going --nitpicky --quiet docs docs/_build/html

links: $(DOCS_STAMP)  ## check the links of the documentation to other sites, which needs the network
	$(RUN) -m sphinx --builder linkcheck --jobs auto --quiet docs docs/_build/links

lint: $(STAMP)  ## check style, types and prose
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/mypy
	$(RUN) docs/tools/prose.py

format: $(STAMP)  ## format the code
	$(VENV)/bin/ruff format .
	$(VENV)/bin/ruff check --fix .

clean:  ## remove what the targets made
	rm -rf $(VENV) $(LIBRARIES_VENV) results runs docs/_build docs/api/generated docs/baselines/generated docs/environments/generated
	rm -rf .mypy_cache .ruff_cache .pytest_cache
