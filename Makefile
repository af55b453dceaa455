# make demo | make test | make lint | make clean.   Everything else is `palpate --help`.
.PHONY: demo test lint clean setup
ARGS ?=
UV := $(shell command -v uv 2>/dev/null || echo .uv/bin/uv)
RUN := $(UV) run --no-sync

demo: setup
	@$(RUN) palpate run scenes/palpation.yaml --duration 20 --serve $(ARGS)

test: setup
	@$(RUN) pytest

setup: .venv/.ready

.venv/.ready: pyproject.toml CMakeLists.txt | $(filter .uv/bin/uv,$(UV))
	@$(UV) sync --all-extras --no-progress
	@touch $@

.uv/bin/uv:
	@python3 -m venv .uv && .uv/bin/pip install --quiet --disable-pip-version-check 'uv>=0.8,<1'

lint: setup
	@$(UV) run --no-sync --group lint pre-commit run --all-files

clean:
	rm -rf .venv build
