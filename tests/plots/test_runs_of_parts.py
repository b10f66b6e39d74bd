"""Pictures of runs of scenes of named parts: every body, its impacts, the stop that is struck."""

import numpy as np
import pytest

import vibsim
from tests.plots.artists import figure_of, lines, points, words
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.plots.registry import choose, fitting
from vibsim.plots.samples import contact_spans
from vibsim.plots.subject import PlotError, subject_of
from vibsim.plots.traces import pair_of

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


def run_of(case, changes=None):
    return subject_of(vibsim.simulate(case, overrides=changes))


@pytest.fixture(scope="module")
def row():
    return run_of(load_case_text(ROW))


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
    assert near > 0 and far > 0
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
    pair = pair_of(run_of("gallery/impact-damper", {"run.t_end": "20 s"}))
    assert sorted(pair.stops) == [(-0.01, "left"), (0.01, "right")]  # of x_ball - x_body


def test_contact_is_shaded_for_any_stop(row):
    spans = contact_spans(row, (0.0, 1.0))
    middle = np.array([(a + b) / 2 for a, b in spans])
    left, ball, right = (row.result.at(middle)[f"x_{name}"] for name in ("left", "ball_1", "right"))
    assert len(spans) > 3
    assert (np.maximum(left - ball - 0.001, ball - right - 0.002) > 0).all()


def test_a_stop_that_has_let_go_by_force_is_not_shaded():
    drill = run_of("gallery/percussive-drill", {"run.t_end": "1 s"})
    events = drill.result.events
    begin, end = (events["t"][events["kind"] == kind] for kind in (1, 2))
    shaded = sum(b - a for a, b in contact_spans(drill, (0.0, 1.0)))
    assert shaded == pytest.approx(np.sum(end - begin[: len(end)]), rel=1e-9)
    assert 0 < shaded < 0.5


@pytest.fixture(scope="module")
def ball():
    return run_of("gallery/bouncing-ball")


def test_velocity_jumps_upright_at_a_rigid_stop(ball):
    """Also where a sample lies at the instant of the impact: the state in front of it comes first."""
    events = ball.result.events
    [curve] = lines(figure_of("velocity", [ball], window=(0.0, 4.0)), "v_ball")
    t, v = points(curve)
    at = [int(np.flatnonzero(t == time)[0]) for time in events["t"][1:20]]
    assert v[at] == pytest.approx(events["before_v_ball"][1:20], rel=1e-12)
    assert v[np.add(at, 1)] == pytest.approx(events["v_ball"][1:20], rel=1e-12)
    pair = run_of("gallery/impact-pair", {"run.t_end": "1 s"})
    [curve] = lines(figure_of("velocity", [pair], window=(0.0, 0.1)), "v_ball")
    v = np.round(points(curve)[1], 9)  # mm/s; the first impact is at a sample, 0.05 s
    assert set(v) == {300.0, -210.0}
    assert np.count_nonzero(np.diff(v)) == 1


def test_characteristic_ends_at_rigid_stops():
    wall, pair = (
        points(lines(figure_of("stiffness", [subject_of(load_case(f"gallery/{name}"))]), "stiffness")[0])
        for name in ("impact-oscillator-coco", "impact-pair")
    )
    assert np.array_equal(wall, [[-2.5, 1.0]] * 2)  # x <= 1 m
    assert pair[0].tolist() == [-10.0, 10.0]  # mm


def test_a_rigid_stop_stands_upright_inside_the_frame():
    """The force of a lone rigid stop is 0 until it is met, then what holds against it, away from the stop."""
    ball = load_case("gallery/bouncing-ball")  # x >= 0
    (axes,) = figure_of("stiffness", [subject_of(ball)]).axes
    ((at, also), (foot, end)) = points(lines(axes.figure, "rigid")[0])
    low, high = axes.get_ylim()
    assert (at, also, foot) == (0.0, 0.0, 0.0) and end == low < 0 < high
    assert axes.get_xlim()[0] < 0.0 and axes.get_yticks().tolist() == [0]
    assert words(axes, "slope") == ["no spring"]
    wall = load_case("gallery/impact-oscillator-coco")
    (axes,) = figure_of("stiffness", [subject_of(wall)]).axes
    (_, upright) = points(lines(axes.figure, "rigid")[0])
    assert upright.tolist() == [1.0, axes.get_ylim()[1]] and axes.get_xlim()[1] > 1.0


def test_rest_on_a_rigid_stop_is_shaded(ball):
    [(begin, end)] = contact_spans(ball, (0.0, 5.0))
    assert (begin, end) == pytest.approx((9 * np.sqrt(2 / 9.81), 5.0), rel=1e-12)


def test_kinds_that_need_a_source_say_so(row):
    names = [kind.name for kind in fitting([row])]
    assert names == [
        "overview", "displacement", "velocity", "phase", "relative", "impact-velocity", "spectrum",
        "spectrogram", "waterfall", "stiffness",
    ]  # fmt: skip
    with pytest.raises(PlotError, match=r"it needs a periodic source, and row has none"):
        choose(["stroboscopic"], [row])


@pytest.mark.parametrize(("kind", "drawn"), [("overview", "x2"), ("phase", "x2"), ("motor-speed", "phidot")])
def test_pages_of_the_paper_s_machine_in_the_long_form(kind, drawn):
    long = load_case_text(load_case("II-B", {"run.t_end": "3 s"}).long_text())
    figure = figure_of(kind, [run_of(long)], width="page")
    figure.canvas.draw()
    assert lines(figure, drawn)


def test_runs_without_a_common_relative_motion_are_told(row):
    other = run_of("gallery/friction-oscillator", {"run.t_end": "5 s"})
    with pytest.raises(PlotError, match="common to the runs: x_right - x_ball_1, x_mass; draw"):
        figure_of("relative", [row, other])
    figure_of("displacement", [row, other])


def test_impact_velocities_are_those_of_every_stop(row):
    """The chain of equal bodies: each blow has the whole 1 m/s, into the stop."""
    chain = run_of("gallery/chain-with-gaps")
    (dots,) = [line for line in figure_of("impact-velocity", [chain]).axes[0].get_lines() if line.get_gid()]
    t, closing = points(dots)
    half = np.pi * np.sqrt(1 / 2e6)  # of a contact [s]
    np.testing.assert_allclose(t, 5e-3 + np.arange(4) * (5e-3 + half / 2), rtol=1e-9)
    np.testing.assert_allclose(closing, 1.0, rtol=1e-9)
    figure = figure_of("impact-velocity", [row])
    assert (points(lines(figure, "impacts")[0])[1] > 0).all()


def test_the_stroboscopic_section_has_the_published_orbit_of_the_bilinear_oscillator():
    """One impact in two periods: two points, which the run meets in turn."""
    run = run_of("gallery/bilinear-oscillator", {"run.t_end": "2000 s"})
    figure = figure_of("stroboscopic", [run], window=(1900.0, 2000.0))
    (dots,) = lines(figure, "section")
    x, v = points(dots)
    period = 2 * np.pi / 0.8
    exact = run.result.at(period * np.arange(np.ceil(1900 / period), np.floor(2000 / period) + 1))
    scale = np.ptp(x) / np.ptp(exact["x_mass"])
    np.testing.assert_allclose(x, scale * exact["x_mass"], atol=1e-6 * np.ptp(x))
    assert len({round(float(one), 4) for one in x / np.ptp(x)}) == 2
    assert len(v) == len(x)


def test_a_section_without_points_says_so():
    capsule = run_of("gallery/drifting-capsule", {"run.t_end": "2 s"})
    for window, said in (((0.05, 0.15), ["no period of the source ends here"]), ((0.0, 2.0), [])):
        (axes,) = figure_of("stroboscopic", [capsule], window=window).axes
        assert [text.get_text() for text in axes.texts if "period" in text.get_text()] == said


def test_the_base_is_part_of_the_relative_motion():
    """The lowest of the blocks against the shaken table: x - X(t)."""
    stack = run_of("gallery/stack-of-blocks", {"run.t_end": "2 s"})
    (curve,) = lines(figure_of("relative", [stack], window=(0.0, 2.0)), "relative")
    x, _ = points(curve)
    run = stack.result
    base = 0.02 * np.sin(2 * np.pi * 4 * run.time)
    drawn = 1000 * (run["x_lower"] - base)
    assert x.min() <= drawn.min() + 1e-6
    assert x.max() >= drawn.max() - 1e-6
    assert np.ptp(x) == pytest.approx(np.ptp(drawn), rel=1e-3)


def test_the_characteristic_of_links_and_stops_has_a_panel_for_each_pair_of_ends():
    damper = load_case("gallery/impact-damper")
    figure = figure_of("stiffness", [subject_of(damper)])
    assert len(figure.axes) == len({line.axes for line in lines(figure, "stiffness")}) == 2
    spring, cage = map(points, lines(figure, "stiffness"))
    slopes = np.diff(spring[1]) / np.diff(spring[0])
    np.testing.assert_allclose(slopes, 0.39478, rtol=1e-9)  # mN/um
    np.testing.assert_allclose(spring[0].max(), 1000 * 200 / 394.78)  # as far as the drive of 0.2 N bends it
    y, force = cage  # mm, N (or kN): 0 between the stops, 50 kN/m beyond either
    inside = np.abs(y) <= 10
    assert (force[inside] == 0).all()
    assert force[-1] == -force[0] > 0
    assert sorted(words(figure.axes[1], "slope")) == ["slope 0 N/m", "slope 50 kN/m", "slope 50 kN/m"]
    assert {text.get_text() for text in figure.axes[1].texts} >= {"left", "right"}


def test_a_case_of_parts_without_springs_has_no_characteristic():
    stack = subject_of(load_case("gallery/stack-of-blocks"))
    for names in (None, ["all"]):
        with pytest.raises(
            PlotError, match=r"no kind shows .*, a case without spring or motor; vibsim cases "
        ):
            choose(names, [stack])
    with pytest.raises(PlotError, match="it needs springs or stops"):
        choose(["stiffness"], [stack])


@pytest.mark.parametrize(("name", "t_end"), [("impact-damper", "2 s"), ("chain-with-gaps", "0.04 s")])
def test_the_machine_heads_the_overview_in_its_own_size(name, t_end):
    """Beside the portrait where there is room, else above all; a centimetre of it is one on paper."""
    run = run_of(f"gallery/{name}", {"run.t_end": t_end})
    figure = figure_of("overview", [run], width="page")
    figure.draw_without_rendering()
    (machine,) = [axes for axes in figure.axes if axes.get_label() == "<machine>"]
    drawn = {artist.get_gid() for artist in machine.get_children()}
    assert {f"bodies.{body.name}" for body in run.scene.bodies} <= drawn
    box = machine.get_window_extent()
    scale = box.width / figure.dpi * 2.54 / np.ptp(machine.get_xlim())
    assert scale == pytest.approx(1.0, rel=0.03)
    others = [axes for axes in figure.axes if axes is not machine]
    covered = [axes for axes in others if axes.get_tightbbox().overlaps(machine.get_window_extent())]
    assert covered == []


def test_runs_laid_over_each_other_have_no_machine():
    runs = [run_of("gallery/friction-oscillator", {"run.t_end": "20 s"}) for _ in range(2)]
    figure = figure_of("overview", runs, width="page")
    assert not [axes for axes in figure.axes if axes.get_label() == "<machine>"]


@pytest.mark.parametrize("width", ["page", "column"])
def test_runs_of_several_bodies_have_a_panel_for_each(row, width):
    """Of three bodies and more a page had none, and ended in an IndexError."""
    axes = figure_of("overview", [row, row], width=width).axes
    drawn = [[line.get_gid() for line in panel.get_lines()] for panel in axes]
    for name in ("x_left", "x_ball_1", "x_right", "x_idle"):
        assert any(name in gids for gids in drawn)


@pytest.mark.parametrize("name", ["stack-of-blocks", "energy-sink", "drifting-capsule"])
def test_labels_of_narrow_panels_stay_on_the_sheet(name):
    """Beside a machine the portrait is narrow: its labels take two lines."""
    run = run_of(f"gallery/{name}", {"run.t_end": "2 s"})
    figure = figure_of("overview", [run], width="page")
    figure.draw_without_rendering()
    (portrait,) = [axes for axes in figure.axes if axes.get_xlabel().startswith("Relative")]
    for label in (portrait.xaxis.label, portrait.yaxis.label):
        box = label.get_window_extent()
        assert "\n" in label.get_text()
        assert figure.bbox.x0 < box.x0 and box.x1 < figure.bbox.x1
        assert box.y1 < portrait.get_tightbbox().y1 + 1 and box.y1 < figure.bbox.y1
