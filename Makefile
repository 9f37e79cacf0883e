# echogrid: one target for each thing that is done often. `make run` and `make test` set up all they need.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ARGS ?=
CODE := src/echogrid/*/ src tests hil_tests examples

.PHONY: run test check fuzz bench latency faults hil evaluate trial trials learn figures lock clean

run: $(VENV)/run-ready
	$(BIN)/echogrid run $(ARGS)

test: $(VENV)/test-ready check
	$(BIN)/pytest -n auto --dist loadfile $(ARGS)

check: $(VENV)/test-ready
	$(BIN)/ruff check $(CODE)
	$(BIN)/ruff format --check $(CODE)
	$(BIN)/mypy

# Noise for the drivers of serial devices, 10 MB each, and of wheels on CAN, a million frames each; or as ARGS
# says (--bytes, --frames, --seed, names of drivers).
fuzz: $(VENV)/test-ready
	$(BIN)/python -m tests.fuzz $(ARGS)

# What things cost, beside what they may be compared with.
bench: $(VENV)/test-ready
	$(BIN)/python -m tests.bench

# How long a reading takes to the command that heeds it.
latency: $(VENV)/test-ready
	$(BIN)/python -m tests.bench.latency $(ARGS)

# How every fault of every ranger shows: the table in docs/devices/README.md is its output.
faults: $(VENV)/test-ready
	$(BIN)/python -m tests.runtime

# The same robot on a real kernel, in a guest: see docs/bench.md. What it needs it installs.
hil: $(VENV)/test-ready
	$(BIN)/python -m compileall -q $(CODE)
	$(BIN)/pytest -q hil_tests/test_guest.py hil_tests/test_ports.py
	$(BIN)/python -m hil_tests.guest --timeout 900 --out out/hil -- env PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 \
		$(BIN)/python -m pytest -p no:cacheprovider --guest hil_tests --ignore=hil_tests/test_guest.py $(ARGS)

# How good the maps are; the tables in docs/maps.md are its output. ROBOND is the folder of that recording.
ROBOND ?= ../shared/data/udacity
evaluate: $(VENV)/run-ready
	$(BIN)/echogrid evaluate $(if $(wildcard $(ROBOND)),--robond $(ROBOND)) $(ARGS)

# Pilots that drive by what they sense, and what they run into (docs/trials.md): a short look of some minutes,
# or all of it, which goes on where it was broken off.
trial: $(VENV)/run-ready
	$(BIN)/echogrid trial --seeds 2 --failures out/trial-failures $(ARGS)

trials: $(VENV)/run-ready
	$(BIN)/echogrid trial --seeds 50 --results out/trials.jsonl --failures out/trial-failures $(ARGS)

# The numbers of the networks that judge evidence, learned anew in the worlds made for it (minutes).
learn: $(VENV)/test-ready
	$(BIN)/python -m echogrid.runtime.learning mapping/calibrated_weights.py
	$(BIN)/ruff format --quiet src/echogrid/mapping/calibrated_weights.py

# The pictures in the docs.
SHOWN := bayes,himm,calibrated
figures: $(VENV)/run-ready
	$(BIN)/python -m echogrid.runtime.theory_pictures docs/figures/theories.png
	rm -rf out/office-log
	$(BIN)/echogrid run --simulate --duration 305s --out out/office --log out/office-log
	cp out/office/map.png docs/figures/office.png
	$(BIN)/echogrid compare out/office-log --truth emulated --out docs/figures/compare-office.png
	$(BIN)/python -m echogrid.runtime.steering_picture docs/figures/steering.png
	$(if $(wildcard $(ROBOND)),$(BIN)/echogrid map $(ROBOND) --format robond --out out/robond)
	$(if $(wildcard $(ROBOND)),cp out/robond/map.png docs/figures/robond.png)
	$(if $(wildcard $(ROBOND)),$(BIN)/echogrid compare $(ROBOND) --format robond \
		--theories $(SHOWN) --out docs/figures/compare-robond.png)

# Pins every version and hash anew. The files name no registry: pip uses the one it is set up for.
lock: $(VENV)/python-ready
	$(PYTHON) -m venv $(VENV)/lock && $(VENV)/lock/bin/pip install --quiet pip-tools
	$(VENV)/lock/bin/pip-compile $(LOCK) --output-file requirements.lock pyproject.toml
	$(VENV)/lock/bin/pip-compile $(LOCK) --extra test --output-file requirements-test.lock pyproject.toml
LOCK := --quiet --upgrade --generate-hashes --strip-extras --allow-unsafe --all-build-deps \
	--no-header --no-emit-index-url --no-emit-find-links --no-emit-trusted-host

clean:
	rm -rf $(VENV) out build dist src/*.egg-info

INSTALL := $(BIN)/pip install --quiet --disable-pip-version-check

$(VENV)/run-ready: requirements.lock pyproject.toml | $(VENV)/python-ready
	$(INSTALL) --require-hashes -r requirements.lock
	$(INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

$(VENV)/test-ready: requirements-test.lock $(VENV)/run-ready
	$(INSTALL) --require-hashes -r requirements-test.lock
	@touch $@

$(VENV)/python-ready:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "echogrid needs Python 3.11 or later: set PYTHON=/path/to/python3.11"; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
		|| { echo "python3 has no venv here: sudo apt-get install python3-venv"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	@touch $@
