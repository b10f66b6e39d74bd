"""Short real runs of every make of scene, drawn from by the tests of the plots."""

from functools import cache

import pytest
from matplotlib.backends import backend_agg
from matplotlib.mathtext import MathTextParser

from tests.plots.browser import Browser, program
from vibsim.cases import load_case
from vibsim.plots import style
from vibsim.plots.subject import open_subject
from vibsim.results import simulate_to_file

FIXED = """
name: fixed
blocks: {m1: 0.297 kg, m2: fixed}
coupling: {k1: 200 N/m, c: 0.5 N s/m}
stop: {k2: 12400 N/m, G: 1 mm, acts: compression}
excitation: {kind: harmonic, A: 0.5 N, omega: 3.5 Hz}
run: {t_end: 8 s, every: 5 ms}
"""
BARE = """
name: bare
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 200 N/m, c: 0 N s/m}
excitation: {kind: none}
initial: {x1: 1 mm}
run: {t_end: 8 s, every: 5 ms}
"""
QUIET = """
name: quiet
blocks: {m1: 0.297 kg, m2: 2.94 kg}
coupling: {k1: 200 N/m, c: 0 N s/m}
stop: {k2: 12400 N/m, G: 1 m, acts: extension}
friction: {mu: 0.5}
excitation: {kind: harmonic, A: 0.01 N, omega: 6.5 Hz}
run: {t_end: 4 s, every: 5 ms}
"""
LENGTHS = {"ideal": ("I-C", "20 s"), "motor": ("II-B", "20 s"), "motor2": ("II-C", "12 s")}
RUNS = ("ideal", "motor", "fixed", "bare", "quiet")


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """Path of the result file of each run; in bare and quiet there are no impacts."""
    folder = tmp_path_factory.mktemp("runs")
    cases = {name: load_case(shipped, {"run.t_end": t_end}) for name, (shipped, t_end) in LENGTHS.items()}
    for name, text in {"fixed": FIXED, "bare": BARE, "quiet": QUIET}.items():
        (folder / f"{name}.yaml").write_text(text)
        cases[name] = load_case(str(folder / f"{name}.yaml"))
    for name, case in cases.items():
        simulate_to_file(case, folder / f"{name}.h5")
    return {name: str(folder / f"{name}.h5") for name in cases}


@pytest.fixture
def subject(runs):
    """Opens a run by name."""
    return lambda name: open_subject(runs[name])


@pytest.fixture(scope="session", autouse=True)
def one_parser():
    """All figures share matplotlib's parser of formulas, and what it has parsed: a tenth of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(backend_agg, "MathTextParser", cache(MathTextParser))
        yield


@pytest.fixture(autouse=True)
def house_style():
    """Figures are drawn under the settings that `draw_files` applies."""
    with style.applied():
        yield


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A headless browser, where there is one."""
    if program() is None:
        pytest.skip("no Chromium on this machine")
    opened = Browser(tmp_path_factory.mktemp("browser"))
    yield opened
    opened.close()
