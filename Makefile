# Everything from a clean checkout: each target sets up what it needs in .venv.

PYTHON ?= python3
VENV := .venv
ifeq ($(OS),Windows_NT)
BIN := $(VENV)/Scripts
else
BIN := $(VENV)/bin
endif
STAMP := $(VENV)/installed
TOOLS := $(VENV)/tools
ADD := $(BIN)/python -m pip install --quiet --disable-pip-version-check
ENGINE := $(wildcard $(foreach end,*.[ch] *.cpp,vibsim/engine/$(end) vibsim/engine/*/$(end) vibsim/engine/*/*/$(end)))
BELTS := 0.95,1.025,1.1,1.175,1.25,1.325,1.4,1.475,1.5,1.55,1.625,1.7,1.775,1.83,1.84,1.85,1.925,2
EVERYWHERE := new:Haswell:1:all new:Zen:2:least old:SkylakeX:2:all old:Prescott:1:least
PAPER := I-A I-B I-C I-A-eq211 I-B-eq211 I-C-eq211 II-A II-B II-C
BUILD_ENGINE := $(BIN)/python setup.py -q build_ext --inplace --force
BRANCHES := results/branches
UP_DOWN := $(BIN)/vibsim sweep II-B --omega0 3:7:0.05 --param c=0.001,0.01,0.03,0.05 --direction both --carry-state \
  --compute power -o results/up-down.h5
SANITIZED := tests/engine tests/kernel tests/events tests/flows tests/tangent tests/sweeps

.PHONY: help env run paper test everywhere docs article wheel wheels oldest without-compiler coverage workflows fuzz sanitize verify lint figures contact-sheet sweep sommerfeld basins branches bench budgets truths true-motions paper-page clean
.DEFAULT_GOAL := help

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 18

env: $(TOOLS) ## set up .venv with vibsim, its engine and the development tools

$(STAMP): pyproject.toml setup.py build_backend.py $(ENGINE)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	VIBSIM_BUILD=$(or $(VIBSIM_BUILD),strict) $(ADD) --editable .
	$(BIN)/python -m compileall -q vibsim
	touch $@

$(TOOLS): $(STAMP)
	$(ADD) 'vibsim[dev]'
	touch $@

run: $(STAMP) ## run case II-B and plot it: results/II-B.h5, results/II-B.png
	mkdir -p results
	$(BIN)/vibsim run cases/II-B.yaml -o results/II-B.h5 --force
	$(BIN)/vibsim plot results/II-B.h5 -o results/II-B.png --force

paper: $(STAMP) ## reproduce and audit the paper: results/paper/report.html
	$(BIN)/vibsim paper -o results/paper

test: $(TOOLS) ## run the test suite in parallel
	$(BIN)/python -m pytest -n auto -q

docs: $(STAMP) ## build the site and run the gallery: build/site/index.html; warnings are errors
	$(BIN)/python -c "import sphinx, myst_parser, furo, latex2mathml" 2>/dev/null || \
	  $(ADD) 'vibsim[docs]'
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going -b html docs build/site

article: $(STAMP) ## make the article about vibsim with its references: build/article.html
	mkdir -p build
	$(BIN)/python -c "import pypandoc" 2>/dev/null || \
	  $(ADD) pypandoc_binary
	$(BIN)/python -c "import pypandoc; pypandoc.convert_file('docs/article/paper.md', 'html', outputfile='build/article.html', \
	  extra_args=['--citeproc', '--resource-path=docs/article', '--standalone', '--fail-if-warnings'])"

wheel: $(TOOLS) ## build sdist and wheel, install the wheel into an empty environment, try it there
	rm -rf dist build/empty
	VIBSIM_BUILD=strict $(BIN)/python -m build --quiet
	$(BIN)/python tests/packaging/complete.py dist/*.tar.gz
	$(PYTHON) -m venv build/empty
	build/empty/bin/python -m pip install --quiet --disable-pip-version-check dist/*.whl
	build/empty/bin/python tests/packaging/smoke.py

wheels: $(STAMP) ## build and try wheels for all Pythons of this system with cibuildwheel: wheelhouse/
	$(ADD) "cibuildwheel>=4,<5"
	$(BIN)/python -m cibuildwheel --output-dir wheelhouse

everywhere: $(TOOLS) ## run the tests under four kernels of OpenBLAS; every two of its threads, of numpy new and old and of its vector units meet (TESTS=)
	test -x build/oldest/bin/python || $(PYTHON) -m venv build/oldest
	build/oldest/bin/python -m pip install --quiet --disable-pip-version-check \
	  --constraint tests/packaging/oldest.txt --editable '.[dev]'
	for run in $(EVERYWHERE); do \
	  set -- $$(echo $$run | tr : ' '); echo "numpy $$1, OpenBLAS for $$2, threads $$3, vector units $$4"; \
	  python=$(BIN)/python; test $$1 = new || python=build/oldest/bin/python; \
	  units=; test $$4 = all || units="$$($$python -m tests.digests units)"; \
	  kernel=OPENBLAS_CORETYPE=$$2; env $$kernel $$python -c "import numpy as np; a = np.eye(50); np.linalg.svd(a @ a)" || \
	    { echo "this processor cannot run the kernels for $$2: its own are taken"; kernel=; }; \
	  env $$kernel OPENBLAS_NUM_THREADS=$$3 NPY_DISABLE_CPU_FEATURES="$$units" $$python -m pytest -n auto -q $(TESTS) || exit 1; \
	done

oldest: ## run the tests with the oldest dependencies, in an environment of their own (PYTHON=python3.10)
	test -x build/oldest/bin/python || $(PYTHON) -m venv build/oldest
	build/oldest/bin/python -m pip install --quiet --disable-pip-version-check \
	  --constraint tests/packaging/oldest.txt --editable '.[dev]'
	build/oldest/bin/python -m pytest -n auto -q

without-compiler: ## install into an empty environment where no compiler answers, and try it there
	rm -rf build/without build/lib* build/temp* && $(PYTHON) -m venv build/without
	CC=false CXX=false VIBSIM_BUILD=strict build/without/bin/python -m pip install --quiet --disable-pip-version-check .
	build/without/bin/python tests/packaging/smoke.py

coverage: $(TOOLS) ## tell which lines and branches of Python and C no test reaches (TESTS=): build/coverage/
	$(BIN)/python -c "import coverage, gcovr" 2>/dev/null || \
	  $(ADD) 'vibsim[checks]'
	rm -rf build/coverage && mkdir -p build/coverage/c && find build -name '*.gcda' -delete
	trap '$(BUILD_ENGINE)' EXIT; VIBSIM_BUILD=coverage $(BUILD_ENGINE) && \
	  $(BIN)/python -m coverage run -m pytest -n auto -q --timeout 1200 -p no:faulthandler $(TESTS) || echo 'not all passed'; \
	  $(BIN)/python -m coverage combine --quiet && $(BIN)/python -m coverage html --quiet && \
	  $(BIN)/python -m coverage report > build/coverage/python.txt && \
	  $(BIN)/gcovr --root . --filter vibsim/engine --txt build/coverage/c.txt --html-details build/coverage/c/index.html \
	    --exclude-unreachable-branches --exclude-throw-branches build
	grep TOTAL build/coverage/python.txt
	grep TOTAL build/coverage/c.txt

workflows: $(TOOLS) ## lint the workflows of .github: their schema, and what an attacker could use
	$(BIN)/python -c "import check_jsonschema" 2>/dev/null && test -x $(BIN)/zizmor || \
	  $(ADD) check-jsonschema zizmor
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.dependabot .github/dependabot.yml
	$(BIN)/zizmor --offline --config .github/zizmor.yml .github

fuzz: $(TOOLS) ## throw three thousand mutants of cases, command lines and files at vibsim (COUNT=, SEED=)
	$(BIN)/python -m tests.fuzz --count $(or $(COUNT),3000) --seed $(or $(SEED),1)

sanitize: $(TOOLS) ## run the C engine's tests and a thousand random scenes under ASan and UBSan
	trap '$(BUILD_ENGINE)' EXIT; VIBSIM_BUILD=sanitize $(BUILD_ENGINE) && \
	  LD_PRELOAD="$$(gcc -print-file-name=libasan.so) $$(gcc -print-file-name=libubsan.so)" ASAN_OPTIONS=detect_leaks=0 \
	  PYTHONMALLOC=malloc VIBSIM_SCENES=1000 \
	  $(BIN)/python -m pytest -n auto -q --timeout 1200 -p no:faulthandler $(SANITIZED)

verify: $(TOOLS) ## verify against known cases, then run the slow tests
	$(BIN)/vibsim verify
	$(BIN)/python -m pytest -n auto -q -m slow --timeout 1800

truths: $(STAMP) ## compute the stored truths of `vibsim verify` anew (half a minute)
	$(BIN)/python -m vibsim.evidence.verification.truth_making

paper-page: $(TOOLS) ## bring the numbers of docs/paper.md up to date with results/paper
	$(BIN)/python -m tests.docs.paper_page results/paper/numbers.json

true-motions: $(STAMP) ## run the paper's cases with many digits, and keep their motions from rest (half an hour; takes the runs that are in results/true-motions)
	$(BIN)/python -m vibsim.evidence.reports.paper

lint: $(TOOLS) ## check style and types
	$(BIN)/ruff check vibsim tests docs setup.py build_backend.py
	$(BIN)/ruff format --check --quiet vibsim tests docs setup.py build_backend.py
	$(BIN)/mypy vibsim

figures: $(STAMP) ## run the nine cases and draw each one's overview into figures/
	mkdir -p results figures
	for name in $(PAPER); do \
	  $(BIN)/vibsim run $$name -o results/$$name.h5 --force && \
	  $(BIN)/vibsim plot results/$$name.h5 -o figures/$$name.pdf --force || exit 1; \
	done

contact-sheet: $(TOOLS) ## draw every kind of picture of every kind of subject onto sheets to look at (half an hour; ONLY=): build/contact-sheet/
	$(BIN)/python -m tests.plots.contact_sheet build/contact-sheet --only "$(ONLY)"

sweep: $(STAMP) ## sweep the motor constant of II-B and draw the Sommerfeld diagram
	mkdir -p results
	$(BIN)/vibsim sweep --omega0 3:7:0.05 -o results/sommerfeld.h5
	$(BIN)/vibsim plot results/sommerfeld.h5 -o results/sommerfeld.png --force

sommerfeld: $(STAMP) ## the showcase (ten minutes; goes on where it was stopped): docs/sommerfeld.png, docs/capture-map.png
	mkdir -p results
	$(UP_DOWN)
	$(BIN)/vibsim sweep II-B --omega0 3:7:0.04 --param c=0.001:0.1/100 --compute capture,regime --section 0 \
	  -o results/capture-map.h5
	$(BIN)/vibsim plot results/up-down.h5 --kind sommerfeld --width page -o docs/sommerfeld.png --force
	$(BIN)/vibsim plot results/up-down.h5 --kind power --width page -o results/power-flow.png --force
	$(BIN)/vibsim plot results/capture-map.h5 --kind capture --width page -o docs/capture-map.png --force
	$(BIN)/vibsim plot results/capture-map.h5 --kind regime -o results/regime-map.png --force

basins: $(STAMP) ## basins of the belt oscillator, 5,000 starts at each of 18 speeds (nine minutes of one core; goes on where it was stopped)
	mkdir -p results
	$(BIN)/vibsim sweep gallery/belt-oscillator --param belt.belt=$(BELTS)m/s --ensemble 5000 \
	  --spread block.x=-2:2m --spread block.v=0:2m/s --t-end 500s --discard 400s --section 0 --compute end-state \
	  -o results/basins.h5
	$(BIN)/vibsim sweep gallery/belt-oscillator -s belt.belt='1.5 m/s' --ensemble 5000 --seed 1 \
	  --spread block.x=-2:2m --spread block.v=0:2m/s --t-end 500s --discard 400s --section 0 --compute end-state \
	  -o results/basin-starts.h5
	$(BIN)/vibsim plot results/basins.h5 --kind end-state -o docs/basins.png --force
	$(BIN)/vibsim plot results/basin-starts.h5 --kind end-state -o docs/basin-starts.png --force
	$(BIN)/vibsim sweep gallery/cantilever --param tip.x=-5:5/100mm --param tip.v=-500:500/100mm/s --section 0 \
	  --compute attractor -o results/basin-cantilever.h5
	$(BIN)/vibsim sweep II-B -s Omega0=5.5Hz -s c='0.03 N s/m' --param phi=0:330/12deg --param phidot=0:6/13Hz \
	  --t-end 600s --section 0 --compute attractor -o results/basin-capture.h5
	$(BIN)/vibsim sweep gallery/impact-oscillator --param drive.omega=1.6:6.4/97rad/s --param wall.e=0.5:0.95/10 \
	  --t-end 3000s --section 0 --compute attractor -o results/impact-map.h5
	$(BIN)/vibsim plot results/impact-map.h5 --kind basins -o docs/impact-map.png --force
	for name in cantilever capture; do \
	  $(BIN)/vibsim plot results/basin-$$name.h5 --kind basins -o docs/basin-$$name.png --force || exit 1; done

branches: $(STAMP) ## periodic orbits of II-B for four dampings over its sweep, and where captures end (two minutes; goes on where it was stopped): results/branches/
	mkdir -p results/branches
	for c in 0.001 0.01 0.03 0.05; do \
	  $(BIN)/vibsim continue II-B -s c=$$c -s Omega0=3.8Hz --omega0 3:9 -o $(BRANCHES)/captured-$$c.h5 && \
	  $(BIN)/vibsim continue $(BRANCHES)/captured-$$c.h5 --switch PD2 --max-points 600 \
	    -o $(BRANCHES)/two-thirds-$$c.h5 || exit 1; done
	$(BIN)/vibsim continue II-B -s c=0.001 -s Omega0=5.9Hz --omega0 5:9 -o $(BRANCHES)/three-quarters-0.001.h5
	$(BIN)/vibsim continue II-B -s c=0.01 -s Omega0=6.1Hz --omega0 5:9 -o $(BRANCHES)/three-quarters-0.01.h5
	$(BIN)/vibsim continue II-B -s c=0.03 -s Omega0=7Hz --omega0 5:9 -o $(BRANCHES)/three-quarters-0.03.h5
	$(BIN)/vibsim orbit II-B -s c=0.03 -s Omega0=7Hz -o $(BRANCHES)/at-0.03.h5 --force
	$(BIN)/vibsim orbit II-B -s c=0.05 -s Omega0=7Hz --from $(BRANCHES)/at-0.03.h5 -o $(BRANCHES)/at-0.05.h5 --force
	$(BIN)/vibsim continue $(BRANCHES)/at-0.05.h5 --omega0 5:9 -o $(BRANCHES)/three-quarters-0.05.h5
	for label in F1 NS1; do $(BIN)/vibsim continue $(BRANCHES)/captured-0.03.h5 --locus $$label \
	  --param c=0.001:0.1 -o $(BRANCHES)/ends-$$label.h5 || exit 1; done
	$(UP_DOWN)
	$(BIN)/vibsim sweep II-B --omega0 3:7:0.08 --param c=0.001:0.1/25 --compute capture --section 0 \
	  -o $(BRANCHES)/capture-map.h5
	$(BIN)/vibsim plot $(BRANCHES)/captured-0.03.h5 --kind load-curve -o docs/load-curve.png --force
	$(BIN)/vibsim plot $(BRANCHES)/captured-0.03.h5 $(BRANCHES)/two-thirds-0.03.h5 $(BRANCHES)/three-quarters-0.03.h5 \
	  --kind load-curve -o docs/load-curves.png --force
	$(BIN)/vibsim plot $(BRANCHES)/captured-0.03.h5 --kind branch,multipliers -o $(BRANCHES)/captured.png --force
	$(BIN)/vibsim plot $(BRANCHES)/ends-F1.h5 $(BRANCHES)/ends-NS1.h5 -o $(BRANCHES)/ends.png --force
	$(BIN)/vibsim plot results/up-down.h5 $(BRANCHES)/captured-*.h5 $(BRANCHES)/two-thirds-*.h5 \
	  $(BRANCHES)/three-quarters-*.h5 --kind sommerfeld --width page -o docs/branches-over-sweep.png --force
	$(BIN)/vibsim plot $(BRANCHES)/capture-map.h5 $(BRANCHES)/ends-*.h5 --kind capture --width page \
	  -o docs/capture-ends.png --force

bench: $(STAMP) ## measure speed against error beside other solvers, and draw the picture of docs/speed.md
	mkdir -p results
	-$(ADD) 'vibsim[bench]'
	$(BIN)/vibsim bench II-B -o results/II-B-bench.h5 --force
	$(BIN)/vibsim plot results/II-B-bench.h5 -o docs/work-precision.png --force

budgets: $(TOOLS) ## measure the speed budgets on this machine, and append them to docs/benchmarks/history.json
	$(BIN)/python tests/budgets/budgets.py

clean: ## remove the environment, builds, results and figures
	rm -rf $(VENV) build dist wheelhouse docs/generated *.egg-info results figures .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find vibsim tests -name __pycache__ -type d -prune -exec rm -rf {} +
	rm -f vibsim/engine/*.so
