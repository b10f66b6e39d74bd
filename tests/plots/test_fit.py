"""The picture of a fit: every candidate judged from all starts, the best ringed."""

from itertools import combinations

import pytest

from tests.fitting.made import done, light_motor, plan_of
from vibsim.plots import style
from vibsim.plots.fit_and_bench import fit_picture
from vibsim.plots.picture import draw_files
from vibsim.plots.registry import fitting
from vibsim.plots.sheet import Powers
from vibsim.plots.subject import PlotError, View, subject_of

WANTED = ["passes 3 Hz before 5 s"]


def fitted(free, readings=()):
    return subject_of(done(plan_of([light_motor(run__t_end="8 s")], free, WANTED, readings, candidates=8)))


def artist(figure, gid):
    (found,) = [each for each in figure.axes[0].get_children() if each.get_gid() == gid]
    return found


def drawn(subject):
    with style.applied():
        figure = fit_picture([subject], View())
        figure.canvas.draw()
    return figure


def test_two_parameters_are_a_plane_of_prices():
    subject = fitted({"J": "0.2:5 g m^2", "M0": "2:10 mN m"})
    figure = drawn(subject)
    prices = [each.price for each in subject.result.ranking]
    assert sorted(artist(figure, "price").get_array()) == sorted(prices)
    best = subject.result.case_of(subject.result.best.candidate)
    (x,), (y,) = artist(figure, "best").get_data()
    assert (x, y) == pytest.approx((1e3 * best.number("J"), 1e3 * best.number("M0")))
    assert artist(figure, "printed").get_xydata().tolist() == [[1.0, 5.0]]
    assert figure.axes[0].get_xlabel() == "J (g m^2)" and figure.axes[0].get_xscale() == "log"


def test_one_parameter_is_a_line_of_prices():
    subject = fitted({"J": "linear 0.2:5 g m^2"})
    figure = drawn(subject)
    assert len(artist(figure, "price").get_xdata()) == len(subject.result.ranking)
    assert figure.axes[0].get_xscale() == "linear"


def test_readings_alone_have_no_picture():
    assert [kind.name for kind in fitting([fitted({}, ["J=0.002"])]) if kind.reads == "fit"] == []


def test_it_is_drawn_from_its_file(here):
    fitted({"J": "0.2:5 g m^2", "M0": "2:10 mN m"}).result.save("found.h5")
    assert draw_files(["found.h5"], None, View(), None, False)[0].endswith("-fit.png")
    with pytest.raises(PlotError, match=r"it shows a sweep, and found\.h5 is a fit"):
        draw_files(["found.h5"], ["sommerfeld"], View(), None, False)


def test_points_are_whole_and_ticks_stand_apart():
    """Of ranges of one, two and four decades."""
    figure = drawn(fitted({"J": "0.2:5 g m^2", "M0": "0.01:100 mN m"}))
    figure.draw_without_rendering()
    axes = figure.axes[0]
    (low, high), (left, right) = axes.get_ylim(), axes.get_xlim()
    x, y = artist(figure, "price").get_offsets().T
    assert left < x.min() and x.max() < right and low < y.min() and y.max() < high
    for axis in (axes.xaxis, axes.yaxis):
        shown = [tick.label1 for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())]
        boxes = [text.get_window_extent() for text in shown if text.get_text() and text.get_visible()]
        inside = [box for box in boxes if box.width]
        assert len(inside) >= 2
        assert not any(one.overlaps(other) for one, other in combinations(inside, 2))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["best", "as in the case"]


@pytest.mark.parametrize(
    ("span", "ticks"),
    [((0.9, 5.5), [1, 2, 5]), ((0.5, 2e3), [1, 10, 100, 1000]), ((1.02, 1.9), [1.2, 1.4, 1.6, 1.8]),
     ((1e-6, 2e-5), [1e-6, 2e-6, 5e-6, 1e-5, 2e-5])],
)  # fmt: skip
def test_ticks_of_a_logarithmic_axis(span, ticks):
    within = [x for x in Powers().tick_values(*span) if span[0] * (1 - 1e-9) <= x <= span[1] * (1 + 1e-9)]
    assert within == pytest.approx(ticks)
