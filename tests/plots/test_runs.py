"""Several runs in one picture are told apart, each with its trust horizon and its name; what a picture of one
run must not do.
"""

import shutil
from itertools import pairwise

import numpy as np
import pytest

import vibsim
from tests.plots.artists import collections, figure_of, letters, lines, notes, on_paper, patches, points
from vibsim.cases import load_case
from vibsim.orbits.orbit import save_orbit
from vibsim.physics.parts import EVENT_KINDS
from vibsim.plots.poincare_sections import drift_rate, turn_times
from vibsim.plots.portraits import POINTS, orbit_portrait_picture
from vibsim.plots.registry import choose
from vibsim.plots.samples import last_half
from vibsim.plots.style import dashed
from vibsim.plots.subject import PlotError, View, distinct_names, open_subject, open_subjects, subject_of
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
    assert [one.stem for one in twins] == ["run", "run"]


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


# What a picture of one run must not do: use a mark twice, change the unit, plot over itself.


def unit(label):
    return label.rpartition("(")[2].rstrip(")")


def test_the_detail_is_framed_and_grey_means_contact(subject):
    figure = figure_of("overview", [subject("motor")], width="page")
    (frame,) = patches(figure, "detail")
    assert frame.get_facecolor()[3] == 0 and frame.get_edgecolor()[3] == 1
    low, high = figure.axes[1].get_xlim()
    assert (frame.get_x(), frame.get_x() + frame.get_width()) == pytest.approx((low, high))
    assert patches(figure, "contact")


@pytest.mark.parametrize("name", ["motor", "ideal"])
@pytest.mark.parametrize("width", ["column", "page"])
def test_a_short_run_has_no_detail(subject, name, width):
    figure = figure_of("overview", [subject(name)], width=width, window=(2.0, 5.0))
    assert patches(figure, "detail") == []
    assert len([axes for axes in figure.axes if axes.get_label() != "<machine>"]) == 3
    wide = [patch.get_width() for patch in figure.axes[0].patches]
    assert max(wide) < 0.5


@pytest.mark.parametrize("kind", ["velocity", "displacement", "phase"])
def test_one_unit_per_figure(subject, kind):
    figure = figure_of(kind, [subject("motor")])
    assert len(figure.axes) == 2
    assert len({unit(axes.get_ylabel()) for axes in figure.axes}) == 1
    assert kind != "phase" or len({unit(axes.get_xlabel()) for axes in figure.axes}) == 1


def test_portraits_mark_the_impacts(subject):
    run, span = subject("motor"), (15.0, 16.0)
    events = run.result.events
    of = (events["kind"] == EVENT_KINDS["contact_begin"]) & (events["t"] >= 15.0) & (events["t"] <= 16.0)
    figure = figure_of("phase", [run], window=span)
    for column, marks in zip(("1", "2"), lines(figure, "impacts"), strict=True):
        x, v = points(marks)
        np.testing.assert_allclose(x, 1000 * events[f"x{column}"][of])
        factor = 1000 if unit(figure.axes[0].get_ylabel()) == "mm/s" else 1
        np.testing.assert_allclose(v, factor * events[f"v{column}"][of])


def test_drift_is_the_mean_velocity(subject):
    run, span = subject("motor"), (14.0, 20.0)
    for column in ("x1", "x2"):
        ends = run.result.at(np.array(span))[column]
        inside = (run.result.time >= span[0]) & (run.result.time <= span[1])
        mean = (ends[1] - ends[0]) / 6.0
        assert abs(drift_rate(run.result, column, span) - mean) < np.ptp(run.result[column][inside]) / 6.0
    assert drift_rate(run.result, "x1", (14.0, 14.2)) == 0.0  # less than two turns


def test_drift_of_a_uniform_motion_is_its_velocity():
    case = load_case(
        "I-C", {"run.t_end": "5 s", "friction.mu": "0", "excitation.A": "0 N", "coupling.c": "0 N s/m",
                "initial.v1": "20 mm/s", "initial.v2": "20 mm/s"},
    )  # fmt: skip
    result = vibsim.simulate(case)
    assert drift_rate(result, "x1", (0.0, 5.0)) == pytest.approx(0.02, rel=1e-12)
    x, v = points(lines(figure_of("phase-drift-free", [subject_of(result)]), "x1")[0])
    assert np.ptp(x) < 1e-9 and np.abs(v).max() < 1e-9


def test_drift_leaves_out_the_transient_and_blocks_that_are_held():
    stack = vibsim.simulate("gallery/stack-of-blocks")  # comes to vibrate about a place
    x = stack.at([8.0, 8.25])["x_lower"]
    settled = (x[1] - x[0]) / 0.25
    assert abs(settled) < 1e-9 and abs(drift_rate(stack, "x_lower", (0.0, 10.0))) < 1e-7
    oscillator = vibsim.simulate("gallery/drifting-oscillator")  # after some strides
    x = oscillator.at([10.0, 20.0])["x_slider"]
    assert drift_rate(oscillator, "x_slider", (0.0, 20.0)) == pytest.approx((x[1] - x[0]) / 10.0, rel=1e-5)
    sink = vibsim.simulate("gallery/energy-sink")  # a spring holds the body, the body the ball
    assert drift_rate(sink, "x_body", (0.0, 2.0)) == drift_rate(sink, "x_ball", (0.0, 2.0)) == 0.0


def test_many_turns_are_drawn_by_their_extremes(subject):
    run = subject("motor")
    figure = figure_of("displacement-frequency", [run])
    (dots,) = collections(figure.axes[0], "extremes")
    times = turn_times(run.result, (0.0, 20.0))
    x, t, n = run.result["x1"], run.result.time, len(times) - 1
    parts = [x[(t >= a) & (t < b)] for a, b in pairwise(times)]
    hertz, values = np.asarray(dots.get_offsets()).T
    np.testing.assert_allclose(hertz, np.tile(1 / np.diff(times), 2))
    np.testing.assert_allclose(values[:n], [1000 * part.min() for part in parts])
    np.testing.assert_allclose(values[n:], [1000 * part.max() for part in parts])
    np.testing.assert_allclose(dots.get_array()[:n], (times[:-1] + times[1:]) / 2)


def test_few_turns_are_drawn_as_loops(subject):
    figure = figure_of("displacement-frequency", [subject("motor")], window=(15.0, 18.0))
    assert not any(axes.collections for axes in figure.axes)
    assert lines(figure, "x1")[0].get_color() != "0.86"


def test_bars_of_the_histogram_end_before_the_frame(subject):
    histogram = figure_of("impact-velocity", [subject("motor")]).axes[1]
    (bars,) = histogram.patches
    assert histogram.get_xlim()[1] >= 1.05 * np.nanmax(bars.get_data().values)


def test_stroboscopic_points_are_called_so(subject):
    title = figure_of("stroboscopic", [subject("ideal")]).axes[0].get_title(loc="right")
    assert title.startswith("66 points; 10–20 s")


@pytest.mark.parametrize("k2", ["12400 N/m", "1000020 N/m", "3 N/m"])
def test_slopes_are_named_inside_the_frame(k2):
    case = load_case("II-B", {"stop.k2": k2})
    figure = figure_of("stiffness", [subject_of(case)])
    figure.draw_without_rendering()
    (axes,) = figure.axes
    names = notes(axes, "slope")
    assert len(names) == 2
    for text in names:
        box = text.get_window_extent()
        assert axes.bbox.x0 < box.x0 and box.x1 < axes.bbox.x1
        assert axes.bbox.y0 < box.y0 and box.y1 < axes.bbox.y1
        assert "e+" not in text.get_text()
    shown = {"12400 N/m": "12.6 kN/m", "1000020 N/m": "1 MN/m", "3 N/m": "203 N/m"}[k2]
    assert names[1].get_text().endswith(f"= {shown}")


CARRIED = """
name: carried
bodies: {disc: 0.1 kg m^2, pin: 0.1 kg m^2}
stops: {dog: {between: [disc, pin], law: rigid, gap: 0.1 rad, acts: compression, e: 0.5}}
forces:
  turn: {on: disc, force: "T - b*v_disc", T: 1 N m, b: 0.05 N m s/rad}
  ripple: {on: disc, A: 1 mN m, omega: 1 Hz}
run: {t_end: 20 s, every: 10 ms}
"""


@pytest.mark.parametrize("case", ["gallery/stack-of-blocks", CARRIED], ids=["returns", "rests on a stop"])
def test_the_section_of_what_is_a_point_is_no_narrower_than_can_be_read(case):
    """Once a period bodies are where they were, to rounding: labels of 13 digits met."""
    figure = figure_of("stroboscopic", [subject_of(vibsim.simulate(case))])
    figure.draw_without_rendering()
    (axes,) = figure.axes
    for axis in (axes.xaxis, axes.yaxis):
        labels = [label.get_text() for label in axis.get_ticklabels() if label.get_text()]
        assert len(labels) >= 2 and max(map(len, labels)) <= 8


# The picture of a stored orbit.


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    path = tmp_path_factory.mktemp("orbits") / "orbit.h5"
    orbit = vibsim.orbit("I-A")
    save_orbit(orbit, path)
    return orbit, open_subject(str(path))


@pytest.mark.parametrize("width", ["column", "page"])
def test_what_is_drawn(stored, width):
    orbit, subject = stored
    figure = on_paper(orbit_portrait_picture([subject], View(width=width)))
    assert letters(figure) == ["(a)", "(b)"]
    (curve,) = lines(figure, "orbit")
    y, u = points(curve)  # in mm and mm/s
    assert len(y) >= POINTS and abs(y[0] - y[-1]) < 1e-9 and abs(u[0] - u[-1]) < 1e-8  # it closes
    (returns,) = lines(figure, "section")
    np.testing.assert_allclose(points(returns)[0], 1e3 * orbit.points[:, 0], rtol=0, atol=1e-9)
    (impacts,) = lines(figure, "impacts")
    np.testing.assert_allclose(points(impacts)[0], -1.0, rtol=1e-9)
    assert len(points(impacts)[0]) == 3
    inside, outside = lines(figure, "multipliers")
    shown = [complex(*pair) for pair in zip(*points(inside), strict=True)]
    np.testing.assert_array_equal(np.sort_complex(shown), np.sort_complex(orbit.multipliers))
    assert len(points(outside)[0]) == 0
    first, second = (axes.get_position() for axes in figure.axes)
    assert first.width > 0.4 and second.height > 0.2


def test_it_is_what_an_orbit_is_drawn_as(stored):
    _, subject = stored
    assert [kind.name for kind in choose(None, [subject])] == ["orbit-portrait"]
    assert "overview" in {kind.name for kind in choose(["all"], [subject])}
    run = vibsim.simulate("I-A", overrides={"run.t_end": "1 s"})
    with pytest.raises(PlotError, match="it needs a periodic orbit"):
        choose(["orbit-portrait"], [subject_of(run)])


def test_the_settled_part_of_an_orbit_is_all_of_it(stored):
    """Not its last half: that is no period."""
    _, subject = stored
    figure = figure_of("impact-velocity", [subject])
    assert [len(points(line)[0]) for line in lines(figure, "impacts")] == [3, 3]  # over time, over phase
    assert last_half(subject, (0.0, 1.0)) == (0.0, 1.0)
