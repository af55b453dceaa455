# make demo | make test | make test-long | make lint | make mutants | make fuzz | make night | make stubs | make wheel | make site | make clean.   `palpate --help` lists all other commands.
.PHONY: demo test test-long lint mutants fuzz night stubs wheel site clean setup constraints
ARGS ?=
OUT ?= dist
export UV_PYTHON_DOWNLOADS = never
# Modules stay compiled even where the environment forbids it: otherwise each process compiles all that it imports.
export PYTHONDONTWRITEBYTECODE =
UV := $(or $(shell command -v uv 2>/dev/null),.uv/bin/uv)
RUN := $(UV) run --no-sync
# Installs packages in the versions of constraints.txt, so that two clones are alike.
INSTALL = $(UV) pip install --quiet --python .venv/bin/python --constraints constraints.txt --no-build-isolation-package palpate
EXTRAS := bodies,calibrate,dask,experiment,files,lab,learning,pandas,planning,registration,remote,report,ros,tissue,tracking,viewer

demo: .venv/.demo
	@$(RUN) palpate run scenes/palpation.yaml --duration 20 $(ARGS)

# Tests in real time run two at a time, and beside them those that compute; a test that fails is repeated once, alone (tools/tests.py).
test: setup
	@$(RUN) palpate bench build --last
	@$(RUN) python tools/tests.py

# More cases of tests that have a short version, more examples of property tests.
test-long: setup
	@$(RUN) python tools/tests.py --long

# The wheel of this platform, built from the compiled core.
wheel: setup
	@PATH="$(CURDIR)/.venv/bin:$$PATH" $(UV) build --wheel --no-build-isolation --python .venv/bin/python --out-dir "$(OUT)" --quiet

# The documentation as a site, which needs no network.
site: setup
	@$(INSTALL) --group site
	@NO_MKDOCS_2_WARNING=1 $(RUN) python tools/site.py

setup: .venv/.ready

# The demo needs the core, the viewer and the report, and no other part (CMakeLists.txt, PALPATE_PARTS).
.venv/.demo: pyproject.toml constraints.txt CMakeLists.txt | $(UV)
	@command -v g++ >/dev/null || { echo "palpate: no C++ compiler (g++) found. Mend: sudo apt install g++"; exit 1; }
	@python3 -c 'import os, sys, sysconfig; sys.exit(not os.path.exists(sysconfig.get_path("include") + "/Python.h"))' \
	  || { echo "palpate: Python.h is missing beside $$(command -v python3). Mend: sudo apt install python3-dev"; exit 1; }
	@python3 -c 'import sys; v = sys.version_info[:2]; sys.exit(not (3, 11) <= v < (3, 15) and f"palpate: python3 is {v[0]}.{v[1]}, and Palpate needs 3.11 to 3.14 (its libraries have no packages for others). Mend: put such a python3 first in PATH")'
	@echo "setting up, once: packages into .venv, then the C++ core (two minutes on two idle cores)"
	@test -x .venv/bin/python || $(UV) venv --quiet --python "$$(command -v python3)" .venv
	@$(INSTALL) --group build
	@$(if $(wildcard .venv/.ready),,PALPATE_PARTS=) $(INSTALL) --editable '.[viewer,report]'
	@touch $@

# All parts of the compiled code and all other extras: ROS 2, calibration, clusters, tests. The ros-* wheels contain .egg-info
# folders of other names, which uv takes for unknown packages: they are deleted. uv does not compile modules: those of
# a ROS 2 client are compiled here, since it takes three times as long to start where the environment forbids it to.
.venv/.ready: .venv/.demo
	@echo "setting up, once: all parts of the compiled code, the packages of all extras and of the tests"
	@$(INSTALL) --group dev --reinstall-package palpate --editable '.[$(EXTRAS)]'
	@cd .venv/lib/python3*/site-packages && cat ros_*.dist-info/RECORD 2>/dev/null | grep -o '^[^/,]*\.egg-info' | sort -u | xargs -r rm -rf
	@cd .venv/lib/python3*/site-packages && cat ros_*.dist-info/RECORD lark_parser-*.dist-info/RECORD pyyaml-*.dist-info/RECORD 2>/dev/null \
	  | grep -o '^[^.,][^,]*\.py,' | tr -d , | ../../../bin/python -m compileall -q -i - >/dev/null || true
	@.venv/bin/palpate ros setup >/dev/null || true
	@touch $@

# Installs uv from the package index into a plain folder, or, where python3 has no pip, into a small environment, which
# takes three times as long.
.uv/bin/uv:
	@python3 -m pip install --quiet --disable-pip-version-check --no-compile --upgrade --target .uv 'uv>=0.8,<1' >/dev/null 2>&1 \
	  || { python3 -m venv .uv && .uv/bin/python -m pip install --quiet --disable-pip-version-check 'uv>=0.8,<1'; } \
	  || { echo "palpate: uv could not be installed. Install it from https://docs.astral.sh/uv, or: sudo apt install python3-venv python3-pip"; exit 1; }

lint: setup
	@$(INSTALL) --group lint
	@$(RUN) pre-commit run --all-files

# Plants faults in units, report energies, operators, certificate, studies and conformance, and counts those that tests find.
mutants: setup
	@$(UV) run --no-sync --with 'cosmic-ray>=8.7,<9' python tools/mutants.py $(ARGS)

# Coverage-guided fuzzing of scene, contact and message code in C++, with clang's sanitizers: make fuzz ARGS="--runs 1000000"
fuzz: setup
	@$(RUN) python tools/fuzz.py $(ARGS)

# All judges that take hours, in slices, resumable; what ran and what it found is in docs/results/night.json. A part of it:
# make night ARGS="--hours 8", make night ARGS="'soak ros' conformance". Left to run: make night ARGS=--list
night: setup
	@$(UV) run --no-sync --with 'cosmic-ray>=8.7,<9' python tools/night.py $(ARGS)

# Generates palpate/_core.pyi and the stubs of the parts (_guidance.pyi, ...) from the compiled bindings.
stubs: setup
	@$(RUN) python tools/stubs.py

# Chooses the newest versions that pyproject.toml allows and writes them to constraints.txt: commit the file.
constraints: | $(UV)
	@$(UV) pip compile pyproject.toml --all-extras --group build --group test --group lint --group site --universal --upgrade \
	  --python-version 3.11 --no-annotate --no-header --quiet --output-file constraints.txt

clean:
	rm -rf .venv .uv build runs
