# povgen: `make movies` renders the paper's three movies, `make test` runs the tests. Each target first sets up what
# it needs: POV-Ray and Python from Debian's packages, and the package in a virtual environment.

QUALITY ?= paper
VENV := .venv
POVGEN := $(VENV)/bin/povgen
MOVIES := $(patsubst %.toml,%.mp4,$(wildcard movies/*.toml))
SOURCES := $(wildcard povgen/*.py povgen/*/*.py templates/*.j2 templates/*/*.j2)
READY := $(VENV)/ready
# Says that make made the environment, and may therefore remove it.
OURS := $(VENV)-made-by-make
# Debian's package for each program (or file) that may be missing
NEEDED := $(if $(shell command -v povray),,povray) \
  $(if $(shell command -v python3),$(if $(shell python3 -c 'import ensurepip, venv' 2>&1),python3-venv),python3 python3-venv)
SUDO := $(if $(filter 0,$(shell id -u)),,$(if $(shell command -v sudo),sudo))
# root or sudo can install
CAN_INSTALL := $(filter 0,$(shell id -u))$(SUDO)
# installs packages of Debian's, or says who has to
install = $(if $(strip $(CAN_INSTALL)),$(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq --no-install-recommends $(1) \
  > /dev/null,@echo "povgen needs Debian's packages: $(1). Have them installed: apt-get install $(1)" >&2; exit 1)

# What a whole environment's READY says: the Python and the folder that it was made for. Where it says anything else, as
# after an upgrade of Python, or in a copy of the checkout, whose .venv runs the original's code, the environment is
# made anew.
WHOLE = $$(python3 -VV) in $(CURDIR)
$(if $(shell test "$$(cat $(READY) 2> /dev/null)" = "$(WHOLE)" && $(VENV)/bin/python -c '' 2> /dev/null \
  || echo stale),$(shell rm -f $(READY) $(VENV)/*-ready $(VENV)/mitsuba/ready))
# Installs into the environment, which is not whole until that has ended: what was interrupted is made anew.
install-into-venv = @rm -f $(READY) && $(1) && echo "$(WHOLE)" > $(READY)

.PHONY: movies frame demo figures readme-images test lint test-deps verify chart docs bench cluster-bench auto-check clean help
.DELETE_ON_ERROR:

movies: $(MOVIES)  ## the paper's three movies, into movies/

movies/%.mp4: movies/%.toml $(SOURCES) build/quality | $(READY)
	$(POVGEN) movie $< -o $@ --quality $(QUALITY)

frame: | $(READY)  ## one frame, frame.png: the chess piece and its predicted place
	$(POVGEN) frame chess --predicted-image --quality $(QUALITY) -o frame.png

demo: | $(READY)  ## a page to teach with, build/demo/index.html: the movies beside the equations, no network needed
	@mkdir -p build
	$(POVGEN) demo -o build/demo --quality $(QUALITY)

test: $(VENV)/test-ready test-deps  ## all tests
	$(VENV)/bin/python -m pytest --numprocesses 4 --dist loadgroup

figures: $(VENV)/charts-ready  ## the paper's six figures with their captions, into docs/figures
	@mkdir -p docs/figures
	$(POVGEN) figure 1 2 3 4 5 6 -o docs/figures
	cat docs/figures/figure?.md > docs/figures/README.md

readme-images: | $(READY)  ## the pictures in README.md
	$(POVGEN) movie vary-alpha --sheet ideal --size 400x300 --antialias 1,0.1,3 --caption --overlay -o docs/alpha.gif
	$(POVGEN) frame chess --quality high --antialias 2,0.1,3 -o docs/prisms.png
	$(POVGEN) frame chess --quality high --antialias 2,0.1,3 --sheet ideal -o docs/ideal.png
	$(POVGEN) frame spheres --alpha 150 --quality high --antialias 2,0.1,3 --overlay --caption -o docs/spheres.png
	$(POVGEN) frame chess --alpha 180 --quality high --antialias 2,0.1,3 --caption -o docs/real-image.png
	$(POVGEN) frame chess --alpha 90 --z1 15 --quality high --antialias 2,0.1,3 --overlay --caption -o docs/far.png
	$(POVGEN) frame chess --sheet single --quality high --antialias 2,0.1,3 --caption -o docs/single.png

docs/lesson.ipynb: docs/lesson.md docs/notebook.py | $(VENV)/test-ready  ## the lesson as a notebook
	$(VENV)/bin/python docs/notebook.py

lint: $(VENV)/test-ready  ## what ruff and mypy say of the code
	$(VENV)/bin/ruff format --quiet --check .
	$(VENV)/bin/ruff check --quiet .
	$(VENV)/bin/mypy

verify: $(VENV)/charts-ready  ## every picture against the equations, and where methods fail: tables, and maps in stability/
	$(POVGEN) verify
	$(POVGEN) verify --stability
	cp stability/stability.png docs

chart: $(VENV)/charts-ready  ## error against CPU seconds, every model and sampling: charts and tables, into docs/chart
	$(POVGEN) chart --baselines benchmarks -o docs/chart

docs: $(VENV)/docs-ready  ## pages about the Python interface, build/api/povgen.html
	$(VENV)/bin/python docs/api.py build/api

bench: $(VENV)/charts-ready $(VENV)/mitsuba/ready  ## what povgen costs beside others: a table, and build/bench.json
	@mkdir -p build
	$(VENV)/bin/python benchmarks/bench.py $(VENV)/mitsuba/bin/python

cluster-bench: $(VENV)/cluster-ready  ## what rendering on a Dask cluster costs: tables, and build/cluster.json
	@mkdir -p build
	$(VENV)/bin/python benchmarks/cluster_bench.py

auto-check: $(VENV)/charts-ready  ## what --sheet auto promises, on 100 random scenes: a table; goes on where it stopped
	$(VENV)/bin/python benchmarks/auto_check.py

clean:  ## remove movies, frame and virtual environment (frames stay in the user's cache)
	$(if $(wildcard $(OURS)),rm -rf $(VENV) $(OURS))
	rm -rf build stability frame.png movies/*.mp4 movies/*.gif movies/*.webm .pytest_cache

help:  ## this list
	@echo "QUALITY=draft|paper|high, now $(QUALITY)"
	@sed -n 's/^\([a-z-]*\):.*## */\1\t/p' $(MAKEFILE_LIST)
	@echo "movies/NAME.mp4	one movie, for every movies/NAME.toml"

# changes when QUALITY does
build/quality: FORCE
	@mkdir -p build
	@echo $(QUALITY) | cmp -s - $@ || echo $(QUALITY) > $@
FORCE:

$(READY): pyproject.toml $(if $(strip $(NEEDED)),FORCE)
	$(if $(strip $(NEEDED)),$(call install,$(strip $(NEEDED))))
	@test -e $(OURS) -o ! -e $(VENV) || { echo "povgen: $(VENV) was not made by make; allowed: remove it, or name" \
	  "another folder, as in make VENV=.venv-povgen" >&2; exit 2; }
	@touch $(OURS) && rm -rf $(VENV)
	python3 -m venv $(VENV)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable .)

# what only tests need: a browser, with which they drive the page of demo, and POV-Ray's own includes
TESTED := $(if $(shell command -v chromium),,chromium) $(if $(wildcard /usr/lib/*/libatomic.so.1),,libatomic1) \
  $(if $(wildcard /usr/share/povray*/include/colors.inc),,povray-includes)
test-deps:
	$(if $(strip $(TESTED)),$(call install,$(strip $(TESTED))))

# a baseline of the benchmark, in an environment of its own
$(VENV)/mitsuba/ready: | $(READY)
	python3 -m venv --clear $(VENV)/mitsuba
	$(VENV)/mitsuba/bin/pip install --quiet --disable-pip-version-check mitsuba numpy
	@touch $@

# many packages, which pip takes a minute for
$(VENV)/test-ready: pyproject.toml | $(READY)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check uv \
	  && $(VENV)/bin/uv pip install --quiet --python $(VENV)/bin/python --editable .[test])
	@touch $@

$(VENV)/%-ready: pyproject.toml | $(READY)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable .[$*])
	@touch $@
