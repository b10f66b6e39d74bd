"""Pictures of runs of scenes of named parts: every body, its impacts, the stop that is struck."""

import numpy as np
import pytest

import vibsim
from tests.plots.artists import lines, points
from vibsim.cases import load_case
from vibsim.cases.loading import load_case_text
from vibsim.plots.errors import PlotError
from vibsim.plots.pairs import pair_of
from vibsim.plots.registry import choose, fitting, kind_named
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

# three bodies in a row: the middle one flies between the others, which never touch
ROW = """
name: row
bodies: {left: 1 kg, ball_1: 0.1 kg, right: 2 kg, idle: 1 kg}
links:
  one: {between: [left, ground], k: 100 N/m}
  two: {between: [right, ground], k: 150 N/m}
stops:
  near: {between: [left, ball_1], gap: 1 mm, acts: compression, k: 100 kN/m}
  far: {between: [right, ball_1], gap: 2 mm, acts: extension, k: 100 kN/m}
initial: {ball_1: {v: 0.5 m/s}}
run: {t_end: 1 s, every: 2 ms}
"""


def subject_of(case):
    return Subject("run.h5", case.name, "trajectory", case, vibsim.simulate(case))


@pytest.fixture(scope="module")
def row():
    return subject_of(load_case_text(ROW))


def figure_of(kind, subjects, **view):
    return kind_named(kind).draw(subjects, View(**{"width": "column", **view}))


@pytest.mark.parametrize(("kind", "letter"), [("displacement", "x"), ("velocity", "v")])
def test_every_body_has_its_curve(row, kind, letter):
    figure = figure_of(kind, [row], window=(0.2, 0.4))
    for body in ("left", "ball_1", "right", "idle"):
        (curve,) = lines(figure, f"{letter}_{body}")
        t, values = points(curve)
        factor = 1000 if "(mm" in figure.axes[0].get_ylabel() else 1
        np.testing.assert_allclose(values / factor, row.result.at(t)[f"{letter}_{body}"], atol=1e-12)
    figure.canvas.draw()  # names with _ are no subscripts of subscripts


def test_impacts_are_marked_on_the_bodies_that_take_part(row):
    figure = figure_of("displacement", [row], window=(0.0, 1.0))
    events = row.result.events
    begins = events["kind"] == 1
    marked = [len(points(line)[0]) for line in lines(figure, "impacts")]
    near, far = (np.count_nonzero(begins & (events["part"] == part)) for part in (0, 1))
    assert near > 0
    assert far > 0
    assert sorted(marked) == sorted([near, near + far, far, 0])


def test_the_relative_portrait_is_of_the_stop_struck_most_often(row):
    pair = pair_of(row)
    events = row.result.events
    counts = np.bincount(events["part"][events["kind"] == 1], minlength=2)
    most, other = (("left", "ball_1"), ("right", "ball_1"))[:: 1 if counts[0] >= counts[1] else -1]
    assert pair.names == ("time", *(f"{letter}_{body}" for body in most for letter in "xv"))
    position = {"left": 0.001, "right": -0.002}[most[0]]  # of x_P - x_Q
    assert [where for where, _ in pair.stops] == [position]
    (curve,) = lines(figure_of("relative", [row]), "relative")
    x, _ = points(curve)
    drawn = row.result[f"x_{most[0]}"] - row.result[f"x_{most[1]}"]
    assert x.max() >= 1000 * drawn.max()
    assert other


def test_where_both_stops_of_a_ball_are_met():
    pair = pair_of(subject_of(load_case("gallery/impact-damper", {"run.t_end": "20 s"})))
    assert sorted(pair.stops) == [(-0.01, "left"), (0.01, "right")]  # of x_ball - x_body


def test_contact_is_shaded_for_any_stop(row):
    from vibsim.plots.impacts import contact_spans

    spans = contact_spans(row, (0.0, 1.0))
    middle = np.array([(a + b) / 2 for a, b in spans])
    states = row.result.at(middle)
    depth = np.maximum(
        states["x_left"] - states["x_ball_1"] - 0.001, states["x_ball_1"] - states["x_right"] - 0.002
    )
    assert len(spans) > 3
    assert (depth > 0).all()


def test_a_stop_that_has_let_go_by_force_is_not_shaded():
    from vibsim.plots.impacts import contact_spans

    drill = subject_of(load_case("gallery/percussive-drill", {"run.t_end": "1 s"}))
    events = drill.result.events
    begin, end = (events["t"][events["kind"] == kind] for kind in (1, 2))
    shaded = sum(b - a for a, b in contact_spans(drill, (0.0, 1.0)))
    assert shaded == pytest.approx(np.sum(end - begin[: len(end)]), rel=1e-9)
    assert 0 < shaded < 0.5


def test_kinds_that_show_two_blocks_only_say_so(row):
    names = [kind.name for kind in fitting([row])]
    assert names == ["overview", "displacement", "velocity", "phase", "relative"]
    with pytest.raises(PlotError, match=r"it shows two blocks, and run\.h5 is a scene of named parts"):
        choose(["impact-velocity"], [row])


@pytest.mark.parametrize("kind", ["overview", "phase", "motor-speed"])
def test_pages_of_the_paper_s_machine_in_the_long_form(kind):
    short = load_case("II-B", {"run.t_end": "3 s"})
    figure = figure_of(kind, [subject_of(load_case_text(short.long_text()))], width="page")
    figure.canvas.draw()
    gids = {line.get_gid() for axes in figure.axes for line in axes.get_lines()}
    assert {"overview": "x2", "phase": "x2", "motor-speed": "phidot"}[kind] in gids


def test_runs_without_a_common_relative_motion_are_told(row):
    other = subject_of(load_case("gallery/friction-oscillator", {"run.t_end": "5 s"}))
    with pytest.raises(PlotError, match="no relative motion is common"):
        figure_of("relative", [row, other])
    figure_of("displacement", [row, other])
