"""The picture of a fit: every candidate judged from all starts, the best ringed."""

import pytest

from tests.fitting.made import done, light_motor, plan_of
from vibsim.plots import style
from vibsim.plots.errors import PlotError
from vibsim.plots.picture import draw_files
from vibsim.plots.registry import fitting
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

WANTED = ["passes 3 Hz before 5 s"]


def subject_of(free, readings=()):
    found = done(plan_of([light_motor(run__t_end="8 s")], free, WANTED, readings, candidates=8))
    return Subject("fit.h5", found.case.name, "fit", found.case, found)


def artist(figure, gid):
    (found,) = [each for each in figure.axes[0].get_children() if each.get_gid() == gid]
    return found


def drawn(subject):
    from vibsim.plots.fit import draw

    with style.applied():
        figure = draw([subject], View())
        figure.canvas.draw()
    return figure


def test_two_parameters_are_a_plane_of_prices():
    subject = subject_of({"J": "0.2:5 g m^2", "M0": "2:10 mN m"})
    figure = drawn(subject)
    prices = [each.price for each in subject.result.ranking]
    assert sorted(artist(figure, "price").get_array()) == sorted(prices)
    best = subject.result.case_of(subject.result.best.candidate)
    (x,), (y,) = artist(figure, "best").get_data()
    assert (x, y) == pytest.approx((1e3 * best.number("J"), 1e3 * best.number("M0")))
    assert artist(figure, "printed").get_xydata().tolist() == [[1.0, 5.0]]
    assert figure.axes[0].get_xlabel() == "J (g m^2)" and figure.axes[0].get_xscale() == "log"


def test_one_parameter_is_a_line_of_prices():
    subject = subject_of({"J": "linear 0.2:5 g m^2"})
    figure = drawn(subject)
    assert len(artist(figure, "price").get_xdata()) == len(subject.result.ranking)
    assert figure.axes[0].get_xscale() == "linear"


def test_readings_alone_have_no_picture():
    assert [kind.name for kind in fitting([subject_of({}, ["J=0.002"])]) if kind.reads == "fit"] == []


def test_it_is_drawn_from_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    subject_of({"J": "0.2:5 g m^2", "M0": "2:10 mN m"}).result.save("found.h5")
    assert draw_files(["found.h5"], None, View(), None, False)[0].endswith("-fit.png")
    with pytest.raises(PlotError, match=r"it shows a sweep, and found\.h5 is a fit"):
        draw_files(["found.h5"], ["sommerfeld"], View(), None, False)
