"""What pictures of runs say of themselves: coordinates on axes, walls, belts, Poincare points, marks."""

import numpy as np
import pytest

from tests.plots.artists import lines
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.plots.picture import chosen_kinds
from vibsim.plots.registry import kind_named
from vibsim.plots.sheet import Scale
from vibsim.plots.subject import PlotError, View, subject_of
from vibsim.results import simulate


def run_of(name, t_end):
    return subject_of(simulate(load_case(name, {"run.t_end": t_end})))


def drawn(kind, subject, **view):
    return kind_named(kind).draw([subject], View(**view))


@pytest.mark.parametrize(
    ("name", "across", "up"),
    [
        ("gallery/duffing-hardening", "Displacement", "Velocity"),
        ("gallery/impact-damper", "Relative displacement", "Relative velocity"),
        ("gallery/cantilever", "Relative displacement", "Relative velocity"),
    ],
)
def test_only_two_ends_that_move_have_a_relative_motion(name, across, up):
    axes = drawn("relative", run_of(name, "5 s"), width="page").axes[0]
    assert axes.get_xlabel().replace("\n", " ").startswith(f"{across} $x_")
    assert axes.get_ylabel().replace("\n", " ").startswith(f"{up} $v_")


def test_the_wall_of_the_ground_stands_where_it_is_struck():
    """The gap of the stop is 0; of the others walls nothing is drawn."""
    figure = drawn("displacement", run_of("gallery/impact-oscillator", "20 s"))
    (wall,) = lines(figure, "wall")
    assert np.all(wall.get_ydata() == 0)
    assert [text.get_text() for text in figure.axes[0].texts if text.get_gid() == "wall name"] == ["wall"]


def test_walls_of_the_base_move_with_it():
    """The box of the impact pair: 10 mm either way of 5 mm sin(2 pi 5 t); every impact lies on a wall."""
    figure = drawn("displacement", run_of("gallery/impact-pair", "1 s"))
    axes = figure.axes[0]
    walls = [line for line in axes.get_lines() if line.get_gid() == "wall"]
    assert len(walls) == 2
    for wall, side in zip(sorted(walls, key=lambda line: line.get_ydata()[0]), (-10, 10), strict=True):
        t, x = wall.get_data()
        np.testing.assert_allclose(x, side + 5 * np.sin(2 * np.pi * 5 * t), atol=1e-9)
    (marks,) = [line for line in axes.get_lines() if line.get_gid() == "impacts"]
    gaps = [np.abs(np.interp(marks.get_xdata(), *wall.get_data()) - marks.get_ydata()) for wall in walls]
    assert np.min(gaps, axis=0).max() < 1e-3


def test_a_wall_that_is_not_struck_is_not_drawn():
    """One that the body comes nowhere near."""
    text = (
        "bodies: {a: 1 kg}\nlinks: {s: {between: [a, ground], k: 100 N/m}}\n"
        "stops: {w: {between: [a, ground], gap: 1 m, acts: compression, k: 1 kN/m}}\n"
        "initial: {a: {x: 1 mm}}\nrun: {t_end: 5 s, every: 10 ms}\n"
    )
    figure = drawn("displacement", subject_of(simulate(load_case_text(text))))
    assert lines(figure, "wall") == []


def test_the_velocity_of_a_belt_is_marked_where_the_block_rides_on_it():
    figure = drawn("relative", run_of("gallery/block-on-belt", "20 s"))
    axes = figure.axes[0]
    (belt,) = lines(figure, "belt")
    (curve,) = lines(figure, "relative")
    unit = 1e3 if "mm/s" in axes.get_ylabel() else 1.0
    assert belt.get_ydata()[0] == pytest.approx(0.2 * unit)
    assert np.count_nonzero(np.abs(curve.get_ydata() - 0.2 * unit) < 1e-9 * unit) > 10  # it sticks
    assert "velocity of belt" in {text.get_text() for text in axes.texts}


@pytest.mark.parametrize("kind", ["relative", "phase"])
def test_portraits_carry_poincare_points_when_asked(kind):
    """Once per period of the force, 3.7 rad/s: where a run of the engine is at those instants."""
    subject = run_of("gallery/impact-oscillator", "60 s")
    figure = drawn(kind, subject, window=(20.0, 60.0), poincare=True)
    (dots,) = lines(figure, "poincare")
    period = 2 * np.pi / 3.7
    times = period * np.arange(np.ceil(20 / period), np.floor(60 / period) + 1)
    state = subject.result.at(times)
    scale = Scale(1e3, "mm") if "(mm)" in figure.axes[0].get_xlabel() else Scale(1.0, "m")
    np.testing.assert_allclose(dots.get_xdata(), scale(state["x_mass"]), atol=1e-9)
    assert "dots: once per period" in figure.axes[0].get_title(loc="right")
    assert lines(drawn(kind, subject), "poincare") == []


def test_poincare_points_of_what_is_no_portrait_are_refused():
    with pytest.raises(PlotError, match="poincare: kind overview has none; kinds that have: phase"):
        chosen_kinds([run_of("gallery/impact-oscillator", "5 s")], ["overview"], View(poincare=True))


def test_marks_are_explained_above_the_panel():
    figure = drawn("displacement", run_of("gallery/impact-damper", "12 s"))
    assert "rings: impacts; grey: contact" in figure.axes[-1].get_title(loc="right")
    portrait = drawn("phase", run_of("gallery/impact-damper", "12 s"))
    assert "rings: impacts" in portrait.axes[0].get_title(loc="right")
