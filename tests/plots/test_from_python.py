"""Pictures drawn from Python: into given axes, in any style."""

import os
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from PIL import Image

import vibsim
from tests.plots.artists import lines
from vibsim.plots.picture import draw_files
from vibsim.plots.registry import KINDS, kind_named
from vibsim.plots.subject import PlotError, View, open_subject

matplotlib.use("agg")


@pytest.fixture(autouse=True)
def pyplot():
    import matplotlib.pyplot as pyplot

    yield pyplot
    pyplot.close("all")


FIRST = """
import matplotlib, sys, vibsim
class Interactive:
    def find_spec(self, name, path=None, target=None):
        if name == 'matplotlib.pyplot':
            matplotlib.rcParams['interactive'] = True
sys.meta_path.insert(0, Interactive())
vibsim.plot('II-B', 'stiffness')
assert 'matplotlib.pyplot' in sys.modules and matplotlib.is_interactive()
"""
LATER = """
import matplotlib, vibsim
assert not matplotlib.is_interactive()
vibsim.plot('II-B', 'stiffness')
assert matplotlib.is_interactive()
matplotlib.interactive(False)
vibsim.plot('II-B', 'stiffness')
assert not matplotlib.is_interactive()
"""


def run_in_notebook(program, **environment):
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, env={**os.environ, **environment}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_first_picture_leaves_a_notebook_as_it_is():
    """Their backend turns matplotlib interactive when pyplot is imported, by the first picture here."""
    run_in_notebook(FIRST, MPLBACKEND="agg")


def test_a_notebook_shows_later_pictures_too(tmp_path):
    """Its backend, which the first figure loads, turns matplotlib interactive."""
    backend = "from matplotlib.backends.backend_agg import *\nimport matplotlib\nmatplotlib.interactive(True)"
    (tmp_path / "of_notebooks.py").write_text(backend)
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    run_in_notebook(LATER, MPLBACKEND="module://of_notebooks", PYTHONPATH=path)


def test_given_axes_are_drawn_into_and_returned(runs, pyplot):
    result = vibsim.open_result(runs["motor"])
    figure, (left, right) = pyplot.subplots(1, 2)
    assert result.plot("relative", ax=left, window=(10, 12)) is left
    assert len(lines(left, "relative")) == 1 and not right.lines
    assert figure.axes == [left, right]


def test_a_picture_in_given_axes_is_the_one_of_the_command(runs, pyplot):
    """Every kind of one panel draws the same curves into given axes as on a sheet of its own."""
    subject = open_subject(runs["motor"])
    result = subject.result
    _, axes = pyplot.subplots()
    for kind in ("relative", "motor-speed", "stroboscopic", "spectrum", "waterfall"):
        own = next(each for each in KINDS if each.name == kind).draw([subject], View()).axes[0]
        axes.clear()
        result.plot(kind, ax=axes)
        for mine, theirs in zip(own.lines, axes.lines, strict=True):
            if kind != "motor-speed":  # an envelope has as many points as its sheet has columns
                assert np.array_equal(mine.get_xydata(), theirs.get_xydata(), equal_nan=True), kind
        assert axes.get_xlabel() == own.get_xlabel() and axes.get_ylabel() == own.get_ylabel()


def test_kinds_draw_on_figures_of_their_own(runs, pyplot):
    """Of every layout one: a sheet, panels below each other, unequal panels, a scale of colours."""
    result = vibsim.open_result(runs["motor"])
    for kind in map(kind_named, ("overview", "displacement", "impact-velocity", "spectrogram")):
        axes = result.plot(kind.name)
        panels = axes if isinstance(axes, list) else [axes]
        assert panels and all(isinstance(each, Axes) for each in panels), kind.name
        assert pyplot.fignum_exists(panels[0].figure.number)
        pyplot.close("all")


def test_the_number_of_panels_must_fit(runs, pyplot):
    result = vibsim.open_result(runs["motor"])
    _, axes = pyplot.subplots(3)
    with pytest.raises(PlotError, match="this picture has 2 panels, and ax gives 1"):
        result.plot("displacement", ax=axes[0])
    assert result.plot("displacement", ax=axes[:2])[1] is axes[1] and axes[1].lines
    with pytest.raises(PlotError, match="lays out a whole sheet of panels: leave ax out"):
        result.plot("overview", ax=axes[0])
    with pytest.raises(PlotError, match="ax must be axes of matplotlib"):
        result.plot("relative", ax=3)


def test_several_results_and_cases(runs, pyplot):
    one, other = (vibsim.open_result(runs[name]) for name in ("motor", "motor2"))
    assert {line.get_label() for line in vibsim.plot([one, other], "motor-speed").lines} >= {"II-B", "II-C"}
    assert vibsim.plot(vibsim.load_case("II-B"), "motor").get_xlabel().startswith("Motor speed")
    assert vibsim.plot("II-B", "motor").lines and vibsim.plot(runs["motor"], "phase")
    for wrong in (3, [], [3]):
        with pytest.raises(PlotError, match=r"must be a result of vibsim|nothing to draw"):
            vibsim.plot(wrong)


def test_the_style_can_be_left_out_and_leaves_nothing_behind(runs, pyplot):
    result = vibsim.open_result(runs["motor"])
    pyplot.rcParams["axes.labelsize"] = 14
    before = dict(pyplot.rcParams)
    mine, house = (result.plot("relative", style=style) for style in (False, True))
    assert mine.xaxis.label.get_size() == 14 and house.xaxis.label.get_size() == 8
    assert result.plot("relative", font_size=12).xaxis.label.get_size() == 12
    assert dict(pyplot.rcParams) == before


def test_the_style_is_a_sheet_of_matplotlib(pyplot):
    with pyplot.style.context("vibsim.plots.house"):
        assert pyplot.rcParams["font.size"] == 8 and pyplot.rcParams["svg.hashsalt"] == "vibsim"


def test_sheets_sizes_and_fonts(runs, tmp_path):
    sheet = tmp_path / "mine.mplstyle"
    sheet.write_text("axes.labelsize: 13\nfigure.facecolor: lightyellow\n")
    view = View(size_cm=(12, 9))
    draw_files([runs["motor"]], ["relative"], view, str(tmp_path / "a.png"), sheet=str(sheet))
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.size == (int(12 / 2.54 * 300), int(9 / 2.54 * 300))
        assert picture.getpixel((2, 2)) == (255, 255, 224)
    with pytest.raises(PlotError, match="must be a file, or a style of matplotlib such as ggplot"):
        draw_files([runs["motor"]], ["relative"], View(), str(tmp_path / "b.png"), sheet="none.mplstyle")
    assert not (tmp_path / "b.png").exists()


def test_a_span_may_be_a_text(runs):
    shown = [vibsim.plot(runs["motor"], "relative", window=window) for window in ((5, 6), "5:6")]
    first, second = (axes.lines[0].get_xydata() for axes in shown)
    assert first.tobytes() == second.tobytes()


@pytest.mark.parametrize(
    ("window", "message"),
    [(3, "a span is"), ("5", "not a span"), ((6, 5), "is empty"), ((1, 2, 3), "a span is")],
)
def test_what_is_no_span(runs, window, message):
    with pytest.raises(PlotError, match=message):
        vibsim.plot(runs["motor"], "relative", window=window)
