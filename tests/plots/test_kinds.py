"""Every kind on every make of scene: it is drawn, its axes carry units, nothing is clipped or covered."""

import re
import shutil
from dataclasses import replace
from string import ascii_lowercase

import pytest
from matplotlib.text import Text

from tests.plots.artists import clipped_texts, colliding_legends, letters
from tests.plots.conftest import RUNS
from tests.plots.test_registry import FITTING, SPECTRA
from vibsim.cases import load_case
from vibsim.plots.registry import KINDS, kind_named
from vibsim.plots.subject import View, open_subjects
from vibsim.results import simulate_to_file

UNIT = re.compile(r"\((s|Hz|°|[kmµn]?(m|m/s|N|N m|W))\)$")
SINGLE = [kind for kind in KINDS if kind.name in FITTING["motor"]]


def drawn(kind, subjects, view=None):
    view = view or View()
    return kind.draw(subjects, replace(view, width=view.width or kind.width))


def assert_fit_to_print(figure):
    for axes in figure.axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or label in ("Count", "Run") or UNIT.search(label), label
    assert any(axes.get_xlabel() for axes in figure.axes)
    assert any(axes.get_ylabel() for axes in figure.axes)
    panels = [axes for axes in figure.axes if axes.get_label() not in ("<colorbar>", "<machine>")]
    expected = [f"({letter})" for letter in ascii_lowercase[: len(panels)]] if len(panels) > 1 else []
    assert sorted(letters(figure)) == expected
    figure.draw_without_rendering()
    assert clipped_texts(figure) == []
    assert colliding_legends(figure) == []


@pytest.mark.parametrize(("run", "name"), [(run, name) for run in RUNS for name in sorted(FITTING[run])])
def test_single_runs(subject, run, name):
    assert_fit_to_print(drawn(kind_named(name), [subject(run)]))


@pytest.fixture(scope="module")
def two_motors(runs, tmp_path_factory):
    """Two runs of one name in files whose names matplotlib would read as mathematics."""
    paths = [tmp_path_factory.mktemp("two") / f"{name}.h5" for name in ("a$\\frac$", "b_{$")]
    shutil.copy(runs["motor"], paths[0])
    simulate_to_file(load_case("II-B", {"Omega0": "6.5 Hz", "run.t_end": "12 s"}), paths[1])
    return open_subjects([str(path) for path in paths])


@pytest.mark.parametrize("kind", SINGLE, ids=lambda kind: kind.name)
def test_two_motors_in_a_window(two_motors, kind):
    """Nothing of their names is taken for mathematics, which fails where it is none."""
    figure = drawn(kind, two_motors[:1] if kind.alone else two_motors, View(window=(8.0, 11.0)))
    assert_fit_to_print(figure)
    said = {text.get_text() for text in figure.findobj(Text)}
    for name in () if kind.alone else (r"a\$\frac\$", r"b_{\$"):
        assert any(name in text for text in said)


@pytest.mark.parametrize("kind", ["overview", "displacement", "velocity", "phase", "relative", "stiffness"])
def test_all_makes_in_one_picture(subject, kind):
    assert_fit_to_print(drawn(kind_named(kind), [subject(run) for run in RUNS]))


@pytest.mark.parametrize(
    ("name", "width"), [("overview", "column"), ("phase", "page"), ("motor-speed", "page")]
)
def test_the_other_width(subject, name, width):
    assert_fit_to_print(drawn(kind_named(name), [subject("motor"), subject("motor2")], View(width=width)))


@pytest.mark.parametrize(
    "kind", [kind for kind in SINGLE if kind.name not in SPECTRA], ids=lambda kind: kind.name
)
def test_a_window_of_a_few_samples(subject, kind):
    assert_fit_to_print(drawn(kind, [subject("motor")], View(window=(10.0, 10.012))))
