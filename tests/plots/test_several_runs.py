"""Several runs in one picture are told apart, each with its trust horizon and its name."""

import shutil

import numpy as np
import pytest

from tests.plots.artists import figure_of, lines, patches, points
from vibsim.plots.style import dashed
from vibsim.plots.subject import distinct_names, open_subjects, subject_of
from vibsim.results import simulate


@pytest.fixture
def twins(runs, tmp_path):
    """The same run under one file name in two folders."""
    (tmp_path / "other").mkdir()
    copies = [tmp_path / "run.h5", tmp_path / "other" / "run.h5"]
    for copy in copies:
        shutil.copy(runs["motor"], copy)
    return open_subjects([str(copy) for copy in copies])


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (["/a/x.h5", "/a/y.h5"], ["x", "y"]),
        (["/a/x.h5", "/b/x.h5"], ["a/x", "b/x"]),
        (["/a/c/x.h5", "/b/c/x.h5"], ["a/c/x", "b/c/x"]),
        (["/a/x.h5", "/a/x.h5", "/b/x.h5"], ["a/x (1)", "a/x (2)", "b/x"]),
        ([], []),
    ],
)
def test_files_are_named_by_what_differs(paths, names):
    assert distinct_names(paths) == names


@pytest.mark.parametrize("kind", ["displacement", "overview"])
def test_runs_of_one_file_name_keep_axis_and_legend(twins, kind):
    axes = figure_of(kind, twins).axes[0]
    assert axes.get_ylabel().startswith("$x_{1}$ (")
    assert len(set(legend(axes))) == 2 and all(name.endswith("run") for name in legend(axes))


def test_bands_do_not_hide_each_other(twins):
    bands = lines(figure_of("displacement", twins, width="page"), "x1")
    assert len(bands) == 2 and all(band.get_alpha() < 1 for band in bands)


def test_lines_that_coincide_are_both_seen(twins):
    first, second = lines(figure_of("displacement", twins, window=(12.0, 13.0)), "x1")
    np.testing.assert_array_equal(points(first)[1], points(second)[1])
    assert first.get_linewidth() > 2 * second.get_linewidth() > 0
    first, second = lines(figure_of("motor", twins), "motor")
    assert first.get_linewidth() > 1.5 * second.get_linewidth()


@pytest.mark.parametrize("window", [None, (12.0, 13.0)])
def test_the_legend_looks_as_the_curves_do(twins, window):
    axes = figure_of("displacement", twins, window=window).axes[0]
    for shown, drawn in zip(axes.get_legend().get_lines(), lines(axes.figure, "x1"), strict=True):
        assert (shown.get_color(), shown.get_linestyle()) == (drawn.get_color(), drawn.get_linestyle())


def test_bodies_of_one_run_are_told_apart_without_colours(subject):
    figure = figure_of("displacement", [subject("motor")])
    details = [lines(figure, name)[1] for name in ("x1", "x2")]
    looks = [(line.get_color(), line._dash_pattern) for line in figure.axes[0].get_legend().get_lines()]
    assert looks[0][1] != looks[1][1]
    scale = details[1].get_linewidth() / 1.2  # dashes are in line widths
    dashes = [[scale * length for length in pattern or ()] for _, (_, pattern) in looks]
    for i, line in enumerate(details):
        assert line.get_color() == looks[i][0]
        assert list(line._dash_pattern[1] or ()) == pytest.approx(dashes[i])
    assert lines(figure, "x2")[0].get_linestyle() == "-"  # an envelope is a band


def test_no_two_of_many_bodies_look_alike():
    looks = {(look["color"], str(look["linestyle"])) for look in map(dashed, range(49))}
    assert len(looks) == 49
    first = [str(dashed(index)["linestyle"]) for index in range(7)]
    assert len(set(first)) == 7  # by their dashes alone


def test_a_body_that_moves_with_another_shows_through_its_dashes():
    stack = subject_of(simulate("gallery/stack-of-blocks"))  # the middle one never slips on the lower one
    lower, middle = (lines(figure_of("velocity", [stack]), name)[0] for name in ("v_lower", "v_middle"))
    np.testing.assert_allclose(lower.get_ydata(), middle.get_ydata(), atol=1e-9)
    assert lower.get_linestyle() == "-" and middle.get_linestyle() == "--"


@pytest.mark.parametrize("kind", ["displacement", "overview", "motor-speed", "impact-velocity"])
def test_every_run_has_its_trust_horizon(subject, kind):
    runs = [subject("motor"), subject("motor2")]
    for run, horizon in zip(runs, (7.5, 4.25), strict=True):
        run.result.attrs["trust_horizon_s"] = horizon
    figure = figure_of(kind, runs)
    marks = lines(figure, "trust-horizon")[:2]
    assert [points(mark)[0][0] for mark in marks] == [7.5, 4.25]
    assert marks[0].get_color() != marks[1].get_color()
    beyond = patches(figure, "beyond-trust")[:2]
    assert [patch.get_x() for patch in beyond] == [7.5, 4.25]
    assert len({patch.get_hatch() for patch in beyond}) == 2
    assert "trust horizons 7.5, 4.25 s" in figure.axes[0].get_title(loc="right")


@pytest.mark.parametrize("kind", ["phase", "relative", "stroboscopic", "displacement-frequency"])
def test_planes_say_that_they_lie_beyond_the_trust_horizon(subject, kind):
    run = subject("motor")
    run.result.attrs["trust_horizon_s"] = 7.5
    figure = figure_of(kind, [run], window=(10.0, 20.0))
    assert "beyond the trust horizon, 7.5 s" in figure.axes[0].get_title(loc="right")
