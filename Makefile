# Two commands do everything: `make run` and `make test`. Both set up what is missing first.

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
HEADLESS := QT_QPA_PLATFORM=offscreen VTK_DEFAULT_OPENGL_WINDOW=vtkEGLRenderWindow QT_API=pyside6
DEMO := concord-demo

.PHONY: setup system run test lint bench screenshots clean

# Compiled loops do not notice that a function they call in another file has changed: they are made anew then.
setup: $(READY)
	@if [ -n "$$(find engine -name '*.py' -newer $(READY) -print -quit)" ]; then \
	  find engine -name '*.nb[ci]' -delete; touch $(READY); \
	fi

$(READY): pyproject.toml constraints.txt scripts/setup.sh
	@scripts/setup.sh $(VENV)
	@touch $(READY)

# System libraries of Qt and OpenGL: installed where we are root, named where we are not.
system:
	@scripts/system-packages.sh

# Opens the window on the bundled example; with no display, does the same job headless and writes a report.
run: setup
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then \
	  scripts/system-packages.sh && exec $(BIN)/concord; \
	else \
	  echo "There is no display: running the bundled example headless."; \
	  scripts/system-packages.sh || echo "Going on; the report will have no pictures."; \
	  $(HEADLESS) $(BIN)/concord demo --out $(DEMO) && echo "Open $(DEMO)/report.html to look at it."; \
	fi

# The whole suite off-screen, then the few tests that need an X server under Xvfb.
test: setup system
	@scripts/test-server.sh
	@$(HEADLESS) $(BIN)/python -m pytest -m "not xvfb"
	@QT_API=pyside6 QT_QPA_PLATFORM=xcb xvfb-run -a -s "-screen 0 1600x1000x24" $(BIN)/python -m pytest -m xvfb

lint: setup
	@$(BIN)/ruff check .
	@$(BIN)/mypy

bench: setup
	@$(BIN)/python tests/benchmarks/speed.py
	@$(BIN)/python tests/benchmarks/presets.py --pairs 30 --seed-from 1000
	@$(BIN)/python tests/benchmarks/puzzle_speed.py
	@$(BIN)/python tests/benchmarks/voting_latency.py

screenshots: setup system
	@$(HEADLESS) $(BIN)/python -m gui.screenshots screenshots

clean:
	@rm -rf build dist *.egg-info $(DEMO) screenshots .pytest_cache .mypy_cache .ruff_cache
